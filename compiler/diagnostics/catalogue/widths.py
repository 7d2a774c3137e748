"""Diagnostics of widths, domains and units of bonds."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def widths_differ(
    span: Span, one: int, one_at: Span | None, two: int, two_at: Span | None
) -> Diagnostic:
    """BG410: different widths on one bond"""
    labels = [
        Label(at, f"width {size}") for size, at in ((one, one_at), (two, two_at)) if at is not None
    ]
    return error(
        "BG410",
        f"a bond connects the widths {one} and {two}",
        span,
        labels=labels,
        help="correct one of them; a `Mux` joins bonds, and a slice such as `hub[1..3]` selects a "
        "part",
    )


def widths_do_not_add_up(span: Span, name: str, total: int, parts: Sequence[int]) -> Diagnostic:
    """BG411: bond widths that do not add up"""
    found = " + ".join(map(str, parts)) or "0"
    return error(
        "BG411",
        f"the bonds at `{name}` have widths {found}, but must add up to {total}",
        span,
        help="correct the widths or the number of bonds",
    )


def slice_outside(span: Span, name: str, component: int, width: int) -> Diagnostic:
    """BG412: a slice outside the width"""
    return error(
        "BG412",
        f"there is no component {component} in `{name}`",
        span,
        help=f"use components from 1 to {width}",
    )


def domains_differ(span: Span, one: str, one_at: Span, two: str, two_at: Span) -> Diagnostic:
    """BG413: two domains on one bond"""
    return error(
        "BG413",
        f"a bond connects the domains `{one}` and `{two}`",
        span,
        labels=[Label(one_at, one), Label(two_at, two)],
        help="put a TF or GY between them",
    )


def units_differ(
    span: Span, name: str, variable: str, one: str, one_at: Span, two: str, two_at: Span
) -> Diagnostic:
    """BG414: different units for one effort or flow"""
    labels = [Label(one_at, one)]
    if (two_at.start, two_at.end) != (one_at.start, one_at.end):
        labels.append(Label(two_at, two))
    return error(
        "BG414",
        f"the {variable} of `{name}` would be both {one} and {two}",
        span,
        labels=labels,
        help="correct one of the units, or put a TF or GY between two domains; if effort times "
        "flow is not a power (temperature, heat flow), use a port of a `pseudo domain`",
    )


def unit_misfit(
    span: Span,
    name: str,
    argument: str,
    wanted: str,
    given: str,
    places: Sequence[tuple[Span, str]],
    instead: str = "",
    exchanged: bool = False,
) -> Diagnostic:
    """BG423: an element whose unit does not fit its bond"""
    way_out = "correct the unit, or put a TF or GY between two domains"
    if instead:
        way_out = f"this is the unit of a {instead}: give it by name, `{instead} = ..`"
    if exchanged:
        way_out = "effort and flow are exchanged: an `Se` sets the effort, an `Sf` the flow"
    labels: dict[tuple[int, int], Label] = {}
    for at, text in places:
        labels.setdefault((at.start, at.end), Label(at, text))
    return error(
        "BG423",
        f"on `{name}` the unit of the {argument} must be that of {wanted}, not of {given}",
        span,
        labels=tuple(labels.values()),
        help=way_out,
    )


def domain_unbalanced(span: Span, name: str, efforts: int, flows: int) -> Diagnostic:
    """BG415: a domain with unequal efforts and flows"""
    return error(
        "BG415",
        f"domain `{name}` has {_counted(efforts, 'effort')} and {_counted(flows, 'flow')}",
        span,
        help="give both the same number of components, in the same order",
    )


def domain_no_power(span: Span, name: str, component: int, found: str) -> Diagnostic:
    """BG416: a domain without power"""
    return error(
        "BG416",
        f"effort times flow of component {component} of `{name}` is {found}, not a power",
        span,
        help="correct the units, or write `pseudo domain`",
    )


def slot_width(
    span: Span,
    model: str,
    interface: str,
    asked: tuple[int, ...],
    have: tuple[int, ...],
    place: Span,
) -> Diagnostic:
    """BG417: a model in a slot of another width"""
    needs = ", ".join(map(str, asked))
    has = ", ".join(map(str, have))
    return error(
        "BG417",
        f"`{model}` is a `{interface}[{has}]`, but the slot needs a `{interface}[{needs}]`",
        span,
        labels=[Label(place, "the slot")],
        help="give it the slot's dimensions",
    )


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
