"""Diagnostics: derived equations."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, underlined, warning
from bgc.diagnostics.diagnostic import Label
from bgc.diagnostics.source import Span


@error(
    "BG540: {what} holds the number {number}, which is outside the range of doubles",
    "check exponents and units: quotients and products of the model's numbers lie "
    "between about 4.9e-324 and 1.8e308",
)
def unrepresentable(span: Span | None, what: str, number: str) -> None: ...
@warning(
    "BG541: the {what} of `{name}` has impulses, which its values and the energy supplied "
    "leave out",
    "put an R {joined} between them, or let the value rise within a time, as `tanh` does",
    note="a source that jumps determines what `{name}` stores, without a state of its own",
)
def impulses(span: Span, name: str, what: str, places: Sequence[Span]) -> Values:
    return {
        "labels": underlined([Label(place, "jumps here") for place in places]),
        "joined": "in series" if what == "flow" else "in parallel",
    }


# BG541, of a transformer between dependent storage, whose modulus jumps.
@warning(
    "BG541: the modulus of `{name}` jumps, and the impulses between what it joins are left out",
    "put a C with an R in parallel between them, or let the modulus change within a time",
    note="the storage on both sides has one state, which the jump would change",
)
def modulus_jumps(span: Span, name: str, places: Sequence[Span]) -> Values:
    return {"labels": underlined([Label(place, "jumps here") for place in places])}
