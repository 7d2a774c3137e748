"""Diagnostics: FMUs."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, nearest


@error(
    "BG750: there is no platform `{name}`", "give names among {known:quoted}, separated by commas"
)
def unknown_platform(name: str, known: Sequence[str]) -> Values:
    return nearest(name, known)


@error(
    "BG751: a binary for `{name}` needs the C compiler of the package `ziglang`, which is missing",
    'install it (`pip install "bgc-lang[zig]"`), or leave that platform out',
)
def platform_needs_zig(name: str) -> None: ...
@error(
    "BG752: the C compiler `{compiler}` cannot build the FMU for `{name}`",
    "remove the reason above, or leave the platform out of `--platforms`",
)
def platform_not_built(name: str, compiler: str, output: str) -> Values:
    return {"note": "\n".join(output.splitlines()[:20])}


@error(
    "BG753: an FMU cannot hold the solver `{solver}`, which belongs to another package",
    "choose one of bgc's own methods in the scene: {methods:quoted}",
)
def solver_not_in_fmu(solver: str, methods: Sequence[str]) -> None: ...
