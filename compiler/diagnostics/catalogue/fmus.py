"""BG750-BG753: FMUs."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_platform(name: str, known: Sequence[str]) -> Diagnostic:
    """BG750: an unknown platform"""
    return error(
        "BG750",
        f"there is no platform `{name}`",
        help=did_you_mean(name, known)
        or f"give names among {', '.join(f'`{each}`' for each in known)}, separated by commas",
    )


def platform_needs_zig(name: str) -> Diagnostic:
    """BG751: a binary for another platform needs ziglang"""
    return error(
        "BG751",
        f"a binary for `{name}` needs the C compiler of the package `ziglang`, which is missing",
        help='install it (`pip install "bgc-lang[zig]"`), or leave that platform out',
    )


def platform_not_built(name: str, compiler: str, output: str) -> Diagnostic:
    """BG752: the binary for a platform could not be built"""
    return error(
        "BG752",
        f"the C compiler `{compiler}` cannot build the FMU for `{name}`",
        note="\n".join(output.splitlines()[:20]),
        help="remove the reason above, or leave the platform out of `--platforms`",
    )


def solver_not_in_fmu(solver: str, methods: Sequence[str]) -> Diagnostic:
    """BG753: an FMU cannot hold this solver"""
    names = ", ".join(f"`{name}`" for name in methods)
    return error(
        "BG753",
        f"an FMU cannot hold the solver `{solver}`, which belongs to another package",
        help=f"choose one of bgc's own methods in the scene: {names}",
    )
