"""Diagnostics of external solvers: their packages and the models that they can integrate."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def solver_not_installed(solver: str, suite: str, packages: str, output: str) -> Diagnostic:
    """BG046: an external solver that is not installed

    What: the solver belongs to an external library, and the C compiler did not find that library.

    Why: SUNDIALS (6 or later) is not installed, or its headers are missing.

    Example: `solver cvode(rtol = 1e-6);` or `bgc run rlc.bg --solver cvode` on a fresh machine.

    Way out: install it (`apt-get install libsundials-dev` on Debian and Ubuntu), or use a built-in
    method: `solver rodas5p;`.
    """
    complaint = next((line for line in output.splitlines() if "error" in line), "")
    return error(
        "BG046",
        f"solver `{solver}` needs {suite}, which the C compiler did not find",
        note=complaint.strip(),
        help=f"install it (`apt-get install {packages}` on Debian and Ubuntu), or use `solver "
        "rodas5p`",
    )


def solver_does_not_serve(solver: str, reason: str) -> Diagnostic:
    """BG047: a model that an external solver cannot integrate

    What: the solver integrates only y' = f(t, y), without interruption from start to end.

    Why: the model has algebraic equations, coupled rates (a mass matrix), inputs that a device or a
    program writes during the run, closed chains of rigid connections, or no states.

    Example: `bgc run two_beam_crane.bg --solver cvode`, whose handle is read from a device.

    Way out: use a built-in method, which integrates all models: `solver rodas5p`.
    """
    return error(
        "BG047",
        f"solver `{solver}` cannot integrate this model: {reason}",
        help="use a built-in method, for example `solver rodas5p`",
    )
