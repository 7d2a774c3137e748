"""The servo loop (`runtime/c/servo`) as a shared object of its own, compiled on first use."""

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
    toolchain = find_toolchain()
    folder = runtime_directory()
    sources = sorted((folder / "servo").glob("*.c"))
    headers = [*sorted(folder.glob("*.h")), *sorted((folder / "servo").glob("*.h"))]
    texts = [path.read_text("utf-8") for path in (*sources, *headers)]
    identity = (*toolchain.command, toolchain.version, machine_identity())
    name = f"{digest_of((*identity, *RUNTIME_FLAGS, *texts))}.so"
    if (found := cache.blob("models", name)) is not None:
        return found
    with cache.workplace() as place:
        made = Path(place) / name
        files = [str(path) for path in sources]
        flags = (*RUNTIME_FLAGS, "-shared", "-pthread", f"-I{folder}", *files, "-o", made.name)
        done = toolchain.run((*flags, "-lm"), Path(place))
        if done.returncode != 0:
            raise BgError([compiler_rejected_code(toolchain.name, done.stdout, str(folder))])
        return cache.publish("models", name, made)
