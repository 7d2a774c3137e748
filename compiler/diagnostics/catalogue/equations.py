"""Diagnostics of derived equations."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def unrepresentable(span: Span | None, what: str, number: str) -> Diagnostic:
    """BG540: equations with a number outside the range of doubles

    What: the derived equations hold a constant above about 1.8e308, or a nonzero one below about
    4.9e-324. It is a product or quotient of numbers of the model.

    Why: the model computes in double precision, where such a constant is infinite or zero.

    Example: `body : I(1e-320 kg);` divides a momentum by the mass, hence multiplies it by 1e320.

    Way out: check exponents and units. A part of negligible size can be removed, or made rigid.
    """
    return error(
        "BG540",
        f"{what} holds the number {number}, which is outside the range of doubles",
        span,
        help="check exponents and units: quotients and products of the model's numbers lie between "
        "about 4.9e-324 and 1.8e308",
    )
