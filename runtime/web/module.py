"""Compile a model with its runtime to a WebAssembly module, by the C compiler of ziglang."""

from __future__ import annotations

import base64
import gzip
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from bgc.building.build import needed_sources, runtime_directory
from bgc.building.cache import Cache, digest_of
from bgc.building.toolchain import NO_FILE, ZIGLANG, identify
from bgc.diagnostics.catalogue.live_pages import page_needs_zig, page_not_compiled
from bgc.diagnostics.diagnostic import BgError
from bgc.emission.amalgamate import joined
from bgc.emission.emit import EmittedModel, emit_lowered
from bgc.runtime.running.structures import C_OPTIONS

DRIVERS: Final = ("pointer", "spring_hand", "trace")
"""The drivers of a module: a page has neither sockets nor libraries of devices."""

RUN: Final = "web.c"
METER: Final = "meter.c"

# The page gives texts of files to `trace` itself.
_HEAD = """\
/* {name}: a model for a page, made by bgc. */
#define BGC_GIVEN_TEXTS
#define BGC_DRIVERS(DRIVER) {drivers}
#define BGC_OPTIONS(number) {options}
"""
# A reactor is a library with exports. The stack lies first, so that an overflow is a trap and does
# not overwrite data. Memory grows on demand, without a limit of its own. Only functions marked
# `inline` are inlined: clang otherwise joins the parts into which long functions were cut, which
# takes 3 (70 states) to 6 times (2,000) as long to compile, and a step of two_beam_crane 1.3 times.
_FLAGS = (
    "-target", "wasm32-wasi", "-mexec-model=reactor",
    "-std=c11", "-O2", "-finline-hint-functions", "-g0", "-s", "-w", "-ffp-contract=off",
    "-fno-math-errno",
    "-Wl,-z,stack-size=1048576",
)  # fmt: skip


def require_zig() -> None:
    """Raise BG545 where ziglang is missing."""
    if find_spec("ziglang") is None:
        raise BgError([page_needs_zig()])


def module_source(emitted: EmittedModel, runtime_dir: Path, exports: str = RUN) -> str:
    """Print the C11 file of a module; equal input gives equal bytes.

    `exports` is the file of the functions that it exports, `RUN` or `METER`.
    """
    own = emit_lowered(emitted.lowered, emitted.source_hash, split=False).units
    parts = {part for unit in own for part in unit.parts}
    sources = needed_sources(runtime_dir, parts)
    kept = {
        name: path
        for name, path in sources.items()
        if not name.startswith("drivers/") or name.removeprefix("drivers/") in DRIVERS
    }
    texts = [(f"{unit.name}.c", unit.text) for unit in own]
    texts += [(f"{name}.c", path.read_text("utf-8")) for name, path in kept.items()]
    texts.append((exports, (runtime_dir / "web" / exports).read_text("utf-8")))
    listed = [name for name in DRIVERS if f"drivers/{name}" in kept]
    drivers = " ".join(f"DRIVER(bgc_{name}_driver)" for name in listed)
    return _HEAD.format(name=emitted.name, drivers=drivers, options=_options()) + joined(
        texts, runtime_dir
    )


def _options() -> str:
    """Take the options of C from numbers in the order of `option_values`."""
    kinds = {**{name: known.kind for name, known in C_OPTIONS.items()}, "accounts": int}
    casts = {float: "", int: "(int)"}
    return ", ".join(
        f".{name} = {casts[kind]}(number)[{k}]" for k, (name, kind) in enumerate(kinds.items())
    )


def build_module(source: str, cache: Cache) -> bytes:
    """Compile the C file of a module, or take the module from the cache.

    Raises BgError: BG545 without ziglang, BG547 with the compiler's reason where it fails.
    """
    require_zig()
    toolchain = identify(ZIGLANG)
    key = digest_of((toolchain.version, version("ziglang"), *_FLAGS, source))
    name = f"{key}.wasm"
    if (found := cache.blob("models", name)) is not None:
        return found.read_bytes()
    with cache.workplace() as place:
        work = Path(place)
        (work / "module.c").write_text(source, encoding="utf-8")
        made = work / "module.wasm"
        done = toolchain.run((*_FLAGS, "module.c", "-o", made.name, "-lm"), work)
        if done.returncode != 0 or not made.is_file():
            raise BgError([page_not_compiled(toolchain.name, done.stdout.strip() or NO_FILE)])
        content = made.read_bytes()
        cache.publish("models", name, made)
    cache.prune()
    return content


def packed(module: bytes) -> str:
    """A module as text for JSON: base64 of gzip."""
    return base64.b64encode(gzip.compress(module, 9, mtime=0)).decode()


def emitted_module(emitted: EmittedModel, cache: Cache, exports: str = RUN) -> bytes:
    """Compile an emitted model to a module with the functions of a file, `RUN` or `METER`."""
    return build_module(module_source(emitted, runtime_directory(), exports), cache)
