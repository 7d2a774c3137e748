"""Diagnostics of derived equations."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, underlined, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
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


def impulses(span: Span, name: str, what: str, places: Sequence[Span]) -> Diagnostic:
    """BG541: a flow or effort with impulses

    What: a storage element without a state of its own follows a value that jumps: a capacitor
    parallel to an effort source with an `if`, a mass on a flow source with a `sign`. Its charge or
    momentum jumps as well, which takes an impulse of its flow or effort. Values of that flow or
    effort, of the source's power and of `energy.supplied` are those between the impulses.

    Why: an impulse is infinite for no time, which a result of rows over time cannot show. The
    charge itself, and all that follows from it, is right.

    Example: `s : Se(e = if time < 1 s then 0 V else 5 V);  c : C(1 mF);  node : J0;` with
    `s -> node -> c;`, where the scene observes `c.f` or an energy account.

    Way out: put an R between the source and a C (parallel to an I), so that the element has a state
    of its own; or let the value rise within a time, `5 V*(1 + tanh((time - 1 s)/1 ms))/2`.
    """
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
