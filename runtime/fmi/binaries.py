"""Build the binaries of an FMU: by this machine's C compiler, for others by that of ziglang."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from bgc.building.cache import Cache, digest_of
from bgc.building.platforms import PLATFORMS, Platform, host_platform
from bgc.building.toolchain import NO_FILE, ZIGLANG, Toolchain, find_toolchain, identify
from bgc.diagnostics.catalogue.fmus import (
    platform_needs_zig,
    platform_not_built,
    unknown_platform,
)
from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.emission.mockup import MockupSource

_FLAGS = ("-std=c11", "-O2", "-fPIC", "-fno-math-errno", "-fvisibility=hidden")


def read_platforms(text: str | None) -> tuple[Platform, ...]:
    """Read the names of `--platforms`; by default this machine's. BG750 for an unknown one."""
    names = [name.strip() for name in text.split(",")] if text else [host_platform()]
    unknown = [name for name in names if name not in PLATFORMS]
    if unknown:
        raise BgError([unknown_platform(unknown[0], sorted(PLATFORMS))])
    return tuple(PLATFORMS[name] for name in dict.fromkeys(names))


def binary_folders(platforms: Sequence[Platform], version: int) -> dict[str, str]:
    """The folders of the binaries by the platforms' names.

    FMI 2 names no processor but that of `linux64` and `darwin64`, and importers on other ones look
    there too. Where two platforms would share a folder, the second has its name of FMI 3.
    """
    folders: dict[str, str] = {}
    for each in sorted(platforms, key=lambda p: "aarch64" in p.name):
        shared = version == 3 or each.folder2 in folders.values()
        folders[each.name] = each.folder3 if shared else each.folder2
    return folders


def build_binaries(
    source: MockupSource, platforms: Sequence[Platform], cache: Cache
) -> dict[str, bytes]:
    """Compile an FMU for several platforms; returns the binaries by the platforms' names.

    The compiled runtime is kept in the cache, where FMUs of other models find it.

    Raises BgError: BG751 where another platform is asked for without ziglang, BG752 with the
    compiler's reason where one does not build, BG055 where the cache cannot be written.
    """
    try:
        return {each.name: _build(source, each, cache) for each in platforms}
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise BgError([cannot_write(str(cache.root), reason)]) from problem


def _build(source: MockupSource, wanted: Platform, cache: Cache) -> bytes:
    toolchain, target = _compiler_for(wanted)
    flags = [*_FLAGS, *target]
    if wanted.name.startswith("win"):
        flags.remove("-fPIC")
    with cache.workplace() as place:
        work = Path(place)

        def run(made: str, *arguments: str) -> Path:
            done = toolchain.run((*flags, *arguments, "-o", made), work)
            if done.returncode != 0 or not (work / made).is_file():
                reason = done.stdout.strip() or NO_FILE
                raise BgError([platform_not_built(wanted.name, toolchain.name, reason)])
            return work / made

        objects = []
        for name, text in (("model", source.model), ("runtime", source.runtime)):
            key = f"{digest_of((*toolchain.command, toolchain.version, *flags, text))}.o"
            found = cache.blob("objects", key)
            if found is None:
                (work / f"{name}.c").write_text(text, encoding="utf-8")
                found = cache.publish("objects", key, run(f"{name}.o", "-c", f"{name}.c"))
            objects.append(str(found))
        return run(f"fmu.{wanted.ending}", "-shared", *objects, "-lm").read_bytes()


def _compiler_for(wanted: Platform) -> tuple[Toolchain, tuple[str, ...]]:
    """The compiler for a platform, and the flags that choose it."""
    if wanted.name == host_platform():
        toolchain = find_toolchain()
        more = ("-fno-sanitize=undefined",) if toolchain.kind == "zig" else ()
        return toolchain, more
    if find_spec("ziglang") is None:
        raise BgError([platform_needs_zig(wanted.name)])
    # -s: without symbols, and without the debug information of a file of its own on Windows.
    return identify(ZIGLANG), ("-target", wanted.target, "-fno-sanitize=undefined", "-s")
