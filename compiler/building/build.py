"""Compile C text to a shared object: each unit once, in parallel, then linked.

A unit's object is cached under the hash of everything that determines it (compiler, flags,
headers, text), so the runtime in `runtime/c` is compiled on first use only, and a model's units
only when their text changes. The shared object is cached in the same way.
"""

from __future__ import annotations

import errno
import re
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence, Set
from concurrent.futures import CancelledError, ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

from bgc.building.cache import Cache, digest_of, digest_of_bytes
from bgc.building.recall import machine_identity, processors
from bgc.building.toolchain import (
    GCC_ALIASES,
    GCC_PASSES,
    LIGHT_FLAGS,
    LOOP_FLAGS,
    NO_FILE,
    RUNTIME_FLAGS,
    SCALAR_FLAGS,
    STEP_FLAGS,
    Compilations,
    Toolchain,
    try_compiler,
)
from bgc.diagnostics.catalogue.machine import (
    cannot_write,
    compiler_does_not_work,
    compiler_rejected_code,
)
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.record_class import dataclass

_LINES_SHOWN = 20
_DISK_FULL = {
    errno.ENOSPC: "No space left on device",
    errno.EDQUOT: "Disk quota exceeded",
}
_LOOPS = frozenset(
    (
        "accounts",
        "blocks",
        "checks",
        "corrections",
        "dense",
        "error_rows",
        "explicit",
        "followed_states",
        "inner",
        "local_error",
        "rosenbrock",
        "sparse",
        "stages",
        "stiffness",
        "substeps",
        "subtolerance",
        "vectors",
    )
)
_SCALAR = frozenset(("attempt", "collocation", "global_error", "linear", "watch"))
# Optional parts that every step of a model with them calls.
_IN_STEPS = frozenset(("closures", "consistent", "events", "sampled", "timed"))
# Optional parts of the runtime and their files or folders; `runtime/c/absent` holds the stubs that
# replace them in a model that does not need them.
_OPTIONAL = {
    "blocks": ("block_pivots", "blocks"),
    "closures": ("chain_kernel", "closures", "closed_start", "chosen_rows", "singular_chains"),
    "consistent": ("consistent", "consistent_steps", "least_squares"),
    "devices": ("devices", "drivers/"),
    "events": (
        "at_events",
        "event_location",
        "events",
        "modes",
        "switch_margins",
        "switch_minima",
        "time_events",
    ),
    "fmus": ("fmus", "fmus2", "fmus3"),
    "jumps": ("jumps",),
    "sampled": ("sampled",),
    "start": ("start",),
    "timed": ("timed",),
    "watch": ("watch",),
}
EVERY_PART = frozenset(_OPTIONAL)
_SHARED = 3  # units that every model needs
# Files of the runtime that are compiled twice: for one instance, and on vector registers for many.
INTEGRATOR = (
    "acceptance",
    "accounts",
    "attempt",
    "backward_error",
    "corrections",
    "dense",
    "dense_error",
    "evaluate",
    "explicit",
    "followed_states",
    "rosenbrock",
    "rounding",
    "rows",
    "spectrum",
    "stages",
    "switching",
    "switching_fixed",
    "vectors",
)


@dataclass(frozen=True, slots=True)
class Unit:
    """One C file to compile: its name without `.c`, its text and the compiler's flags.

    `compiler` overrides the compiler of the build, which links everything. `parts` names the
    optional parts of the runtime that the unit needs. `files` are the names and contents of files
    that the text includes.
    """

    name: str
    text: str
    flags: tuple[str, ...] = RUNTIME_FLAGS
    compiler: Toolchain | None = None
    parts: frozenset[str] = EVERY_PART
    files: tuple[tuple[str, bytes], ...] = ()


def runtime_directory() -> Path:
    """The directory of the runtime's C sources and of `bgc.h`."""
    spec = find_spec("bgc.runtime")
    assert spec is not None and spec.submodule_search_locations
    return Path(next(iter(spec.submodule_search_locations))) / "c"


def driver_names() -> tuple[str, ...]:
    """The drivers of this installation, sorted: those that its list in C names."""
    listed = (runtime_directory() / "drivers/drivers.h").read_text(encoding="utf-8")
    return tuple(sorted(re.findall(r"DRIVER\(bgc_(\w+)_driver\)", listed)))


def shared_runtime_units() -> tuple[Unit, ...]:
    """Read the C sources that every model needs: three units, by how often a step goes there.

    Started once each, and at no higher level than is felt, the C compiler takes half the time that
    it takes for every file by itself at `-O3`.
    """
    sources = runtime_sources(runtime_directory())
    optional = {name for name in sources if any(_belongs(name, part) for part in EVERY_PART)}
    return _units("runtime", {name: sources[name] for name in sources.keys() - optional})


def runtime_units(parts: Set[str] = EVERY_PART) -> tuple[Unit, ...]:
    """Read the C sources that models with these optional parts share, those of all models first.

    A part is a unit of its own, so that a model with another choice of parts finds it in the cache.
    """
    folder = runtime_directory()
    sources = runtime_sources(folder)
    units = list(shared_runtime_units())
    for part in sorted(parts):
        own = {name: path for name, path in sources.items() if _belongs(name, part)}
        units += _units(f"runtime_{part}", own, STEP_FLAGS if part in _IN_STEPS else LIGHT_FLAGS)
    absent = {part: folder / "absent" / f"{part}.c" for part in EVERY_PART - parts}
    return (*units, *_units("runtime_absent", absent))


def _units(
    name: str, sources: Mapping[str, Path], flags: tuple[str, ...] = LIGHT_FLAGS
) -> tuple[Unit, ...]:
    """Join C sources to units of loops, of scalar code and, with `flags`, of the rest."""
    texts = {file: sources[file].read_text(encoding="utf-8") for file in sorted(sources)}
    loops = {file: texts.pop(file) for file in sorted(_LOOPS & texts.keys())}
    scalar = {file: texts.pop(file) for file in sorted(_SCALAR & texts.keys())}
    units = (
        Unit(f"{name}_loops", _joined(loops), LOOP_FLAGS),
        Unit(f"{name}_scalar", _joined(scalar), SCALAR_FLAGS),
        Unit(name, _joined(texts), flags),
    )
    return tuple(unit for unit in units if unit.text)


def runtime_sources(folder: Path) -> dict[str, Path]:
    """The C files of the runtime and of its drivers by name: `step`, `drivers/trace`."""
    paths = (*folder.glob("*.c"), *folder.glob("drivers/*.c"))
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(paths)}


def needed_sources(folder: Path, parts: Set[str]) -> dict[str, Path]:
    """The C files of the runtime by name, those of optional parts other than `parts` as stubs."""
    left_out = EVERY_PART - parts
    sources = {
        name: path
        for name, path in runtime_sources(folder).items()
        if not any(_belongs(name, part) for part in left_out)
    }
    return sources | {part: folder / "absent" / f"{part}.c" for part in left_out}


def _belongs(name: str, part: str) -> bool:
    """Return whether a C file of the runtime belongs to an optional part."""
    return any(
        name == file or (file[-1] == "/" and name.startswith(file)) for file in _OPTIONAL[part]
    )


def _joined(sources: Mapping[str, str]) -> str:
    """Join several C files; `#line` directives keep the compiler's messages on the right file."""
    return "".join(f'#line 1 "{name}.c"\n{text}' for name, text in sources.items())


def lane_runtime_units() -> tuple[Unit, ...]:
    """Read the C sources that models share which run many instances at once, as one unit."""
    folder = runtime_directory()
    paths = (*sorted(folder.glob("lanes/*.c")), *(folder / f"{name}.c" for name in INTEGRATOR))
    return (Unit("lanes_runtime", _joined({path.stem: path.read_text("utf-8") for path in paths})),)


def tangent_runtime_units() -> tuple[Unit, ...]:
    """Read the C sources that models share whose runs are differentiated, as one unit."""
    paths = sorted(runtime_directory().glob("tangents/*.c"))
    text = _joined({path.stem: path.read_text("utf-8") for path in paths})
    return (Unit("tangents_runtime", text),)


def build_shared_object(
    units: Sequence[Unit],
    toolchain: Toolchain,
    cache: Cache,
    ready: Callable[[], None] | None = None,
) -> Path:
    """Compile a model's units, link them with the runtime and return the shared object's path.

    Units of one compilation have distinct names, which may not be those of the runtime's. `ready`
    waits for a `compile_runtime` that was started before.

    Where the disk of the cache is full, a temporary directory takes its place, with a warning.

    Raises BgError: BG052 where the compiler does not work at all, BG053 where it fails on these
    units, BG055 where nothing can be written.
    """
    try:
        try:
            return _build(units, toolchain, cache, ready)
        except OSError as problem:
            if problem.errno not in _DISK_FULL or cache.warnings:
                raise
            cache.move_away(_reason(problem))
            return _build(units, toolchain, cache, None)
    except OSError as problem:
        raise BgError([cannot_write(str(cache.root), _reason(problem))]) from problem


def compile_runtime(toolchain: Toolchain, cache: Cache, compilations: Compilations) -> None:
    """Compile what every model needs of the runtime, unless it is in the cache."""
    units = shared_runtime_units()
    shared = _shared_key(toolchain)
    with cache.workplace() as place:
        keys = [_unit_key(shared, unit) for unit in units]
        _compile_all(units, keys, toolchain, cache, Path(place), compilations)


def _build(
    units: Sequence[Unit], toolchain: Toolchain, cache: Cache, ready: Callable[[], None] | None
) -> Path:
    everything = (*runtime_units({part for unit in units for part in unit.parts}), *units)
    assert len({unit.name for unit in everything}) == len(everything), "units share a name"
    shared = _shared_key(toolchain)
    keys = [_unit_key(shared, unit) for unit in everything]
    link_flags = _link_flags(toolchain, units)
    library = f"{digest_of((shared, *link_flags, *keys))}.so"
    if (found := cache.blob("models", library)) is not None:
        return found
    with cache.workplace() as place:
        work = Path(place)
        if ready is not None:
            _compile_all(everything[_SHARED:], keys[_SHARED:], toolchain, cache, work)
            ready()
        objects = _compile_all(everything, keys, toolchain, cache, work)
        made = work / library
        arguments = (*link_flags, "-o", made.name, *map(str, objects), "-lm")
        linking = toolchain.run(arguments, work)
        if linking.returncode != 0 or not made.is_file():
            raise BgError([_failure(toolchain, linking.stdout or NO_FILE, cache, work)])
        path = cache.publish("models", library, made)
    cache.prune()
    return path


def _shared_key(toolchain: Toolchain) -> str:
    """Hash what all units of a build depend on: the headers of the runtime and the compiler."""
    fixed = sorted(runtime_directory().rglob("*.h"))
    texts = [(path.name, path.read_text(encoding="utf-8")) for path in fixed]
    identity = (*toolchain.command, toolchain.version, machine_identity())
    return digest_of((*identity, *(part for pair in texts for part in pair)))


def _unit_key(shared: str, unit: Unit) -> str:
    own = (*unit.compiler.command, unit.compiler.version) if unit.compiler else ()
    contents = (part for name, content in unit.files for part in (name, digest_of_bytes(content)))
    return digest_of((shared, *own, *unit.flags, unit.name, unit.text, *contents))


def _link_flags(toolchain: Toolchain, units: Sequence[Unit]) -> tuple[str, ...]:
    # clang as gcc understand -shared on macOS too.
    flags = ["-shared"]
    if toolchain.kind == "zig":
        flags.append("-fno-sanitize=undefined")
    if sys.platform == "linux" and any(unit.compiler for unit in units):
        flags.append("-Wl,-z,noexecstack")  # tcc does not say so, and glibc would not load it
    return tuple(flags)


def unit_flags(unit: Unit, toolchain: Toolchain) -> tuple[str, ...]:
    """Return the unit's flags as this compiler takes them, those of gcc's passes to gcc alone."""
    if toolchain.kind == "gcc":
        return unit.flags
    kept = _without_passes(unit.flags)
    return (*kept, "-fno-sanitize=undefined") if toolchain.kind == "zig" else kept


def _without_passes(flags: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(flag for flag in flags if flag not in {*GCC_PASSES, *GCC_ALIASES})


def _compile_all(
    units: Sequence[Unit],
    keys: Sequence[str],
    toolchain: Toolchain,
    cache: Cache,
    work: Path,
    compilations: Compilations | None = None,
) -> list[Path]:
    """Compile what is not cached, the longest texts first, on all processors."""
    found = [cache.blob("objects", f"{key}.o") for key in keys]
    missing = [k for k, path in enumerate(found) if path is None]
    missing.sort(key=lambda k: -len(units[k].text))
    running = compilations or Compilations()

    def compile_one(k: int) -> str:
        if running.ended:
            return ""
        unit = units[k]
        (work / f"{unit.name}.c").write_text(unit.text, encoding="utf-8")
        for name, content in unit.files:
            (work / name).write_bytes(content)
        include = f"-I{runtime_directory()}"
        compiler = unit.compiler or toolchain
        flags = unit_flags(unit, compiler)
        made = f"{unit.name}.o"
        rest = (include, "-c", f"{unit.name}.c", "-o", made)
        done = compiler.run((*flags, *rest), work, running)
        plain = _without_passes(flags)
        if done.returncode != 0 and plain != flags and not running.ended:
            done = compiler.run((*plain, *rest), work, running)  # a gcc without those passes
        if done.returncode != 0 or running.ended:
            return done.stdout or f"{compiler.name} ended with status {done.returncode}"
        if not (work / made).is_file():
            return NO_FILE
        found[k] = cache.publish("objects", f"{keys[k]}.o", work / made)
        return ""

    with ThreadPoolExecutor(max_workers=processors()) as pool:
        try:
            outputs = [output for output in pool.map(compile_one, missing) if output]
        except BaseException:  # Ctrl-C: the pool waits for its threads
            running.end()
            raise
    if running.ended:
        raise CancelledError  # compilers that were killed say nothing about the compiler
    if outputs:
        raise BgError([_failure(toolchain, "\n".join(outputs), cache, work)])
    return [path for path in found if path is not None]


def _failure(toolchain: Toolchain, output: str, cache: Cache, work: Path) -> Diagnostic:
    """Say why the compiler failed: itself, or the emitted code; OSError where the disk is full."""
    shown = _first_lines(output)
    for number, words in _DISK_FULL.items():
        if words in output:
            raise OSError(number, words)
    if complaint := try_compiler(toolchain):
        return compiler_does_not_work(toolchain.name, _first_lines(complaint))
    kept = cache.root / "failed" / digest_of([output])
    shutil.copytree(work, kept, ignore=shutil.ignore_patterns("*.o"), dirs_exist_ok=True)
    (kept / "output.txt").write_text(output, encoding="utf-8")
    return compiler_rejected_code(toolchain.name, shown, str(kept))


def _first_lines(output: str) -> str:
    lines = output.strip().splitlines()
    more = [f"... and {len(lines) - _LINES_SHOWN} more lines"] if len(lines) > _LINES_SHOWN else []
    return "\n".join([*lines[:_LINES_SHOWN], *more])


def _reason(problem: OSError) -> str:
    return problem.strerror or str(problem)
