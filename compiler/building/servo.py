"""The servo loop (`runtime/c/servo`) and the process of a driver, compiled on first use."""

from __future__ import annotations

from pathlib import Path

from bgc.building.build import runtime_directory
from bgc.building.cache import Cache, digest_of
from bgc.building.recall import machine_identity
from bgc.building.toolchain import RUNTIME_FLAGS, find_toolchain
from bgc.diagnostics.catalogue.machine import compiler_rejected_code
from bgc.diagnostics.diagnostic import BgError


def build_servo(cache: Cache) -> Path:
    """Compile the servo loop, or find it in the cache, and return its shared object.

    Raises BgError BG053 where the compiler rejects it.
    """
    return _build(cache, "servo", ".so", ("-shared", "-pthread"))


def build_host(cache: Cache) -> Path:
    """Compile the program that runs the driver of a device, or find it, as `build_servo`."""
    return _build(cache, "host", "", ("-pthread", "-ldl"))


def _build(cache: Cache, part: str, suffix: str, kind: tuple[str, ...]) -> Path:
    """Compile a folder of the runtime to a file of its own."""
    toolchain = find_toolchain()
    folder = runtime_directory()
    sources = sorted((folder / part).glob("*.c"))
    headers = [*sorted(folder.glob("*.h")), *sorted((folder / "servo").glob("*.h"))]
    texts = [path.read_text("utf-8") for path in (*sources, *headers)]
    identity = (*toolchain.command, toolchain.version, machine_identity())
    name = f"{digest_of((*identity, *RUNTIME_FLAGS, *kind, *texts))}{suffix}"
    if (found := cache.blob("models", name)) is not None:
        return found
    with cache.workplace() as place:
        made = Path(place) / name
        files = [str(path) for path in sources]
        flags = (*RUNTIME_FLAGS, f"-I{folder}", *files, "-o", made.name, *kind, "-lm")
        done = toolchain.run(flags, Path(place))
        if done.returncode != 0:
            raise BgError([compiler_rejected_code(toolchain.name, done.stdout, str(folder))])
        return cache.publish("models", name, made)
