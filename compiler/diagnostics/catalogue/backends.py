"""Diagnostics: external solvers."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, error


@error(
    "BG046: solver `{solver}` needs {suite}, which the C compiler did not find",
    "install it (`apt-get install {packages}` on Debian and Ubuntu), or use `solver rodas5p`",
)
def solver_not_installed(solver: str, suite: str, packages: str, output: str) -> Values:
    return {"note": next((line.strip() for line in output.splitlines() if "error" in line), "")}


@error(
    "BG047: solver `{solver}` cannot integrate this model: {reason}",
    "use a built-in method, for example `solver rodas5p`",
)
def solver_does_not_serve(solver: str, reason: str) -> None: ...
