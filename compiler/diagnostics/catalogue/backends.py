"""Diagnostics of the solvers of others: what they need and which models they serve."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def solver_not_installed(solver: str, suite: str, packages: str, output: str) -> Diagnostic:
    """BG046: a solver of others that is not installed

    What: the solver is not one of bgc's own, and what it is part of was not found by the C
    compiler.

    Why: SUNDIALS (6 or later) is not installed, or without its headers.

    Example: `solver cvode(rtol = 1e-6);` or `bgc run rlc.bg --solver cvode` on a fresh machine.

    Way out: `apt-get install libsundials-dev` on Debian and Ubuntu, or a method that is always
    there: `solver rodas5p;`.
    """
    complaint = next((line for line in output.splitlines() if "error" in line), "")
    return error(
        "BG046",
        f"solver `{solver}` needs {suite}, against which nothing can be compiled here",
        note=complaint.strip(),
        help=f"`apt-get install {packages}` on Debian and Ubuntu, or `solver rodas5p`",
    )


def solver_does_not_serve(solver: str, reason: str) -> Diagnostic:
    """BG047: a model that a solver of others does not serve

    What: the solver takes equations of the form y' = f(t, y), which run from one end to the
    other by themselves.

    Why: the model has algebraic equations or rates that depend on each other (a mass matrix),
    inputs that a device or a program writes on the way, or nothing to integrate.

    Example: `bgc run two_beam_crane.bg --solver cvode`, whose handle is read from a device.

    Way out: one of bgc's own methods, which serve all models: `solver rodas5p`.
    """
    return error(
        "BG047",
        f"solver `{solver}` does not serve this model: {reason}",
        help="use one of bgc's own methods, as `solver rodas5p`",
    )
