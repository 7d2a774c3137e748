"""Diagnostics of external solvers: their packages and the models that they can integrate."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def solver_not_installed(solver: str, suite: str, packages: str, output: str) -> Diagnostic:
    """BG046: an external solver that is not installed"""
    complaint = next((line for line in output.splitlines() if "error" in line), "")
    return error(
        "BG046",
        f"solver `{solver}` needs {suite}, which the C compiler did not find",
        note=complaint.strip(),
        help=f"install it (`apt-get install {packages}` on Debian and Ubuntu), or use `solver "
        "rodas5p`",
    )


def solver_does_not_serve(solver: str, reason: str) -> Diagnostic:
    """BG047: a model that an external solver cannot integrate"""
    return error(
        "BG047",
        f"solver `{solver}` cannot integrate this model: {reason}",
        help="use a built-in method, for example `solver rodas5p`",
    )
