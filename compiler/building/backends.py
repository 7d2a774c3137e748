"""Integrators of other projects (SUNDIALS), compiled on demand against the installed library.

A backend is one C file in `runtime/c/backends` and has its own shared object in the cache. It is
handed models that are compiled already.
"""

from __future__ import annotations

from pathlib import Path

from bgc.building.cache import Cache, digest_of
from bgc.building.recall import machine_identity
from bgc.diagnostics.catalogue.backends import solver_not_installed
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Backend:
    """An external solver: the library that it belongs to, and how to compile against it.

    `family` and `purpose` are as in `bgc_method_info` of `bgc.h`. `variants` are flags and
    libraries, the best first; the first that can be built is taken.
    """

    name: str
    suite: str
    packages: str
    family: str
    purpose: str
    variants: tuple[tuple[str, ...], ...]


_CVODE = ("-lsundials_cvode", "-lsundials_nvecserial")
BACKENDS = {
    "cvode": Backend(
        "cvode",
        "SUNDIALS",
        "libsundials-dev",
        "backward differentiation formulas",
        "a yardstick of variable order: systems without devices and algebraic equations",
        (
            (
                "-DBGC_KLU",
                "-I/usr/include/suitesparse",
                *_CVODE,
                "-lsundials_sunlinsolklu",
                "-lsundials_sunmatrixsparse",
            ),
            (*_CVODE, "-lsundials_sunlinsoldense", "-lsundials_sunmatrixdense"),
        ),
    ),
}


def build_backend(backend: Backend, cache: Cache) -> Path:
    """Compile a backend, or find it in the cache, and return its shared object.

    Raises BgError BG046 where what it needs is not installed.
    """
    # A warm start needs the names of backends alone, and does without what compiles.
    from bgc.building.build import runtime_directory
    from bgc.building.toolchain import RUNTIME_FLAGS, find_toolchain

    toolchain = find_toolchain()
    folder = runtime_directory()
    source = folder / "backends" / f"{backend.name}.c"
    texts = [path.read_text("utf-8") for path in (source, *sorted(folder.glob("*.h")))]
    identity = (*toolchain.command, toolchain.version, machine_identity())
    output = ""
    for variant in backend.variants:
        name = f"{digest_of((*identity, *RUNTIME_FLAGS, *variant, *texts))}.so"
        if (found := cache.blob("models", name)) is not None:
            return found
        with cache.workplace() as place:
            made = Path(place) / name
            flags = (*RUNTIME_FLAGS, "-shared", f"-I{folder}", str(source), "-o", made.name)
            done = toolchain.run((*flags, *variant, "-lm"), Path(place))
            if done.returncode == 0:
                return cache.publish("models", name, made)
            output = done.stdout
    raise BgError([solver_not_installed(backend.name, backend.suite, backend.packages, output)])
