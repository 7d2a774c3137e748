"""Diagnostics of derived equations."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, underlined, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def unrepresentable(span: Span | None, what: str, number: str) -> Diagnostic:
    """BG540: equations with a number outside the range of doubles"""
    return error(
        "BG540",
        f"{what} holds the number {number}, which is outside the range of doubles",
        span,
        help="check exponents and units: quotients and products of the model's numbers lie between "
        "about 4.9e-324 and 1.8e308",
    )


def impulses(span: Span, name: str, what: str, places: Sequence[Span]) -> Diagnostic:
    """BG541: a flow or effort with impulses"""
    joined = "in series" if what == "flow" else "in parallel"
    return warning(
        "BG541",
        f"the {what} of `{name}` has impulses, which its values and the energy supplied leave out",
        span,
        labels=underlined([Label(place, "jumps here") for place in places]),
        note=f"a source that jumps determines what `{name}` stores, without a state of its own",
        help=f"put an R {joined} between them, or let the value rise within a time, as `tanh` does",
    )


def modulus_jumps(span: Span, name: str, places: Sequence[Span]) -> Diagnostic:
    """BG541, of a transformer between dependent storage, whose modulus jumps."""
    return warning(
        "BG541",
        f"the modulus of `{name}` jumps, and the impulses between what it joins are left out",
        span,
        labels=underlined([Label(place, "jumps here") for place in places]),
        note="the storage on both sides has one state, which the jump would change",
        help="put a C with an R in parallel between them, or let the modulus change within a time",
    )
