"""Diagnostics of `jacobian`, of random numbers, and of data and interpolation."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

# --- jacobian ---------------------------------------------------------------------------


def jacobian_by_expression(span: Span) -> Diagnostic:
    """BG475: a derivative by an expression

    What: the second argument of `jacobian` is an expression, a constant, or a variable of a bond
    that is itself computed.

    Why: a partial derivative is by a quantity that can be varied while all others are held: a
    state, an input, a signal, an output, a parameter, or the time.

    Example: `state x = 1; let g = jacobian(sin(2*x), 2*x);`

    Way out: name the quantity, and use the name in the first argument:
    `signal phase = 2*x; let g = jacobian(sin(phase), phase);`.
    """
    return error(
        "BG475",
        "`jacobian` differentiates by states, signals and inputs, not by an expression",
        span,
        help="give the expression a name with `signal`, use the name in both arguments",
    )


def jacobian_of_matrix(span: Span, found: str) -> Diagnostic:
    """BG476: the derivative of a matrix

    What: the first argument of `jacobian` is a matrix.

    Why: the derivatives of a vector by a list are a matrix; those of a matrix would need three
    indices.

    Example: `state x = 1; let d = jacobian([[x, 0], [0, x]], x);`

    Way out: differentiate each row or column: `jacobian(A[1, 1..2], x)`.
    """
    return error(
        "BG476",
        f"`jacobian` differentiates a scalar or a vector, not {found}",
        span,
        help="differentiate its rows or columns one by one",
    )


# --- random numbers ---------------------------------------------------------------------


def random_of_what_varies(span: Span, what: str, found: str) -> Diagnostic:
    """BG477: a random number of something else than whole constants

    What: the seed or the index of `random` changes during a run, or is not a whole number below
    2^53.

    Why: a random number is a function of its seed and its index, so that it is the same on every
    machine and in every run. One that changed with the state would be a noise without an equation.

    Example: `let phase = 2*pi*random(1, time);`

    Way out: number the draws: `for i in 1..20 { let phase = 2*pi*random(seed, i); }`, with
    `param seed = 1;`.
    """
    return error(
        "BG477",
        f"{what} of `random` must be a whole number"
        + (f", not {found}" if found else " that is known before the run"),
        span,
        help="use a constant, a parameter or the variable of a `for`",
    )
