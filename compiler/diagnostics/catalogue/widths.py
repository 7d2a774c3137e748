"""Diagnostics: widths, domains and units of bonds."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error
from bgc.diagnostics.diagnostic import Label
from bgc.diagnostics.source import Span


@error(
    "BG410: a bond connects the widths {one} and {two}",
    "correct one of them; a `Mux` joins bonds, and a slice such as `hub[1..3]` selects a part",
)
def widths_differ(
    span: Span, one: int, one_at: Span | None, two: int, two_at: Span | None
) -> Values:
    return {
        "labels": [
            Label(at, f"width {size}")
            for size, at in ((one, one_at), (two, two_at))
            if at is not None
        ]
    }


@error(
    "BG411: the bonds at `{name}` have widths {found}, but must add up to {total}",
    "correct the widths or the number of bonds",
)
def widths_do_not_add_up(span: Span, name: str, total: int, parts: Sequence[int]) -> Values:
    return {"found": " + ".join(map(str, parts)) or "0"}


@error("BG412: there is no component {component} in `{name}`", "use components from 1 to {width}")
def slice_outside(span: Span, name: str, component: int, width: int) -> None: ...
@error("BG413: a bond connects the domains `{one}` and `{two}`", "put a TF or GY between them")
def domains_differ(span: Span, one: str, one_at: Span, two: str, two_at: Span) -> Values:
    return {"labels": [Label(one_at, one), Label(two_at, two)]}


@error(
    "BG414: the {variable} of `{name}` would be both {one} and {two}",
    "correct one of the units, or put a TF or GY between two domains; if effort times "
    "flow is not a power (temperature, heat flow), use a port of a `pseudo domain`",
)
def units_differ(
    span: Span, name: str, variable: str, one: str, one_at: Span, two: str, two_at: Span
) -> Values:
    labels = [Label(one_at, one)]
    if (two_at.start, two_at.end) != (one_at.start, one_at.end):
        labels.append(Label(two_at, two))
    return {"labels": labels}


@error("BG423: on `{name}` the unit of the {argument} must be that of {wanted}, not of {given}")
def unit_misfit(
    span: Span,
    name: str,
    argument: str,
    wanted: str,
    given: str,
    places: Sequence[tuple[Span, str]],
    instead: str = "",
    exchanged: bool = False,
) -> Values:
    way_out = "correct the unit, or put a TF or GY between two domains"
    if instead:
        way_out = f"this is the unit of a {instead}: give it by name, `{instead} = ..`"
    if exchanged:
        way_out = "effort and flow are exchanged: an `Se` sets the effort, an `Sf` the flow"
    labels: dict[tuple[int, int], Label] = {}
    for at, text in places:
        labels.setdefault((at.start, at.end), Label(at, text))
    return {"labels": tuple(labels.values()), "help": way_out}


@error(
    "BG415: domain `{name}` has {efforts:counted effort} and {flows:counted flow}",
    "give both the same number of components, in the same order",
)
def domain_unbalanced(span: Span, name: str, efforts: int, flows: int) -> None: ...
@error(
    "BG416: effort times flow of component {component} of `{name}` is {found}, not a power",
    "correct the units, or write `pseudo domain`",
)
def domain_no_power(span: Span, name: str, component: int, found: str) -> None: ...
@error(
    "BG417: `{model}` is a `{interface}[{has}]`, but the slot needs a `{interface}[{needs}]`",
    "give it the slot's dimensions",
    labels={"place": "the slot"},
)
def slot_width(
    span: Span,
    model: str,
    interface: str,
    asked: tuple[int, ...],
    have: tuple[int, ...],
    place: Span,
) -> Values:
    return {"has": ", ".join(map(str, have)), "needs": ", ".join(map(str, asked))}
