"""BG750-BG753: FMUs."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_platform(name: str, known: Sequence[str]) -> Diagnostic:
    """BG750: an unknown platform

    What: `--platforms` names a platform for which bgc builds no binary.

    Why: a name is misspelt, or this machine is of another kind and no name is given.

    Example: `bgc build rlc.bg --target fmu2 --platforms linux`.

    Way out: give names among `linux64`, `linux-aarch64`, `win64`, `darwin64` and `darwin-aarch64`,
    separated by commas.
    """
    return error(
        "BG750",
        f"there is no platform `{name}`",
        help=did_you_mean(name, known)
        or f"give names among {', '.join(f'`{each}`' for each in known)}, separated by commas",
    )


def platform_needs_zig(name: str) -> Diagnostic:
    """BG751: a binary for another platform needs ziglang

    What: the binary of an FMU for another platform is built by the C compiler of the Python package
    `ziglang`, which is not installed.

    Why: the C compiler of this machine makes programs for this machine only.

    Example: `bgc build rlc.bg --target fmu2 --platforms win64` on Linux without `ziglang`.

    Way out: `pip install "bgc-lang[zig]"`, or leave the platform out: the importer can compile the
    sources in the FMU.
    """
    return error(
        "BG751",
        f"a binary for `{name}` needs the C compiler of the package `ziglang`, which is missing",
        help='install it (`pip install "bgc-lang[zig]"`), or leave that platform out',
    )


def platform_not_built(name: str, compiler: str, output: str) -> Diagnostic:
    """BG752: the binary for a platform could not be built

    What: the C compiler failed on the source of the FMU for one of the platforms.

    Why: the compiler has no C library for that platform, or ran out of memory or disk space.

    Example: `CC="gcc -nostdinc" bgc build rlc.bg --target fmu2`.

    Way out: remove the reason that the compiler gives, or leave the platform out of `--platforms`:
    the importer can compile the sources in the FMU.
    """
    return error(
        "BG752",
        f"the C compiler `{compiler}` cannot build the FMU for `{name}`",
        note="\n".join(output.splitlines()[:20]),
        help="remove the reason above, or leave the platform out of `--platforms`",
    )


def solver_not_in_fmu(solver: str, methods: Sequence[str]) -> Diagnostic:
    """BG753: an FMU cannot hold this solver

    What: the scene's solver belongs to another package, and an FMU contains its solver.

    Why: an FMU runs where neither bgc nor its packages are installed.

    Example: `solver cvode(rtol = 1e-8);` and `bgc build rlc.bg --target fmu2`.

    Way out: choose one of bgc's own methods in the scene, such as `solver rodas5p(rtol = 1e-8);`.
    """
    names = ", ".join(f"`{name}`" for name in methods)
    return error(
        "BG753",
        f"an FMU cannot hold the solver `{solver}`, which belongs to another package",
        help=f"choose one of bgc's own methods in the scene: {names}",
    )
