"""Diagnostics of widths, domains and units of bonds."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def widths_differ(
    span: Span, one: int, one_at: Span | None, two: int, two_at: Span | None
) -> Diagnostic:
    """BG410: different widths on one bond

    What: the two ends of a bond, or the bonds at a junction, have different widths.

    Why: a bond of width n is n scalar bonds, each with two ends.

    Example: `body : I[6](M); node : J1[3]; node -> body;`

    Way out: correct one of the widths. To join bonds of width 3 and 3 into one of 6 use `join :
    Mux[3, 3];`; to use a part of a bond write a slice: `node[1..3] -> ..`.
    """
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
    """BG411: bond widths that do not add up

    What: the widths of the bonds at a Mux, or at an element with several ports, do not add up to
    its width.

    Why: each component needs exactly one bond.

    Example: `join : Mux[3, 3];` with bonds of width 3 and 2.

    Way out: correct the widths or the number of bonds.
    """
    found = " + ".join(map(str, parts)) or "0"
    return error(
        "BG411",
        f"the bonds at `{name}` have widths {found}, but must add up to {total}",
        span,
        help="correct the widths or the number of bonds",
    )


def slice_outside(span: Span, name: str, component: int, width: int) -> Diagnostic:
    """BG412: a slice outside the width

    What: an index at the end of a bond is less than 1 or greater than the width.

    Why: components are numbered from 1.

    Example: `hub[4..7] -> lin;` where `hub` has width 6.

    Way out: keep the slice within the width.
    """
    return error(
        "BG412",
        f"there is no component {component} in `{name}`",
        span,
        help=f"use components from 1 to {width}",
    )


def domains_differ(span: Span, one: str, one_at: Span, two: str, two_at: Span) -> Diagnostic:
    """BG413: two domains on one bond

    What: ports of different domains are bonded to each other.

    Why: a domain gives effort and flow their meaning; a transformer or gyrator connects two
    domains.

    Example: a port of `Frame` bonded to one of `Electric`.

    Way out: put a TF or GY between them.
    """
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
    """BG414: different units for one effort or flow

    What: around a bond or junction, the given units imply different units for one effort or flow.

    Why: effort times flow is power, and all bonds of a junction have the same units.

    Example: `supply : Se(e = 5 V); push : Se(e = 2 N); supply, push -> node;`

    Way out: correct the unit, or put a TF or GY between two domains. If effort times flow is not a
    power, declare the domain as `pseudo`: `pseudo domain Heat { effort T : K; flow Q : W; }`, and
    give a model of the parts a port of it: `port side in : Heat;`. One such port sets the domain of
    all bonds that junctions connect to it.
    """
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
    """BG423: an element whose unit does not fit its bond

    What: the unit of a resistance, stiffness, compliance, inertia or conductance does not match the
    effort and flow of its bond.

    Why: a stiffness is effort by displacement, an inertia momentum by flow, so the bond determines
    the unit.

    Example: `push : Se(e = 1 N); spring : C(stiffness = 20 kN*m); push -> spring;`

    Way out: correct the unit, here `20 kN/m`; a number without a unit fits any. If the bond's unit
    is wrong, correct that, or put a TF or GY between two domains. `C(20 kN/m)` gives a compliance:
    a stiffness is given by its name, `C(stiffness = 20 kN/m)`. A voltage, force or pressure is set
    by an `Se`, a current, velocity or volume flow by an `Sf`.
    """
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
    """BG415: a domain with unequal efforts and flows

    What: a domain has more components of effort than of flow, or the other way round.

    Why: the product of the k-th effort and the k-th flow is a power.

    Example: `domain D { effort F[3] : N; flow v[2] : m/s; }`

    Way out: give both the same number of components.
    """
    return error(
        "BG415",
        f"domain `{name}` has {_counted(efforts, 'effort')} and {_counted(flows, 'flow')}",
        span,
        help="give both the same number of components, in the same order",
    )


def domain_no_power(span: Span, name: str, component: int, found: str) -> Diagnostic:
    """BG416: a domain without power

    What: the product of an effort's unit and its flow's unit is not watt.

    Why: energy could not be accounted for.

    Example: `domain Heat { effort T : K; flow Q : W; }`

    Way out: correct the units, or declare it as `pseudo domain`.
    """
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
    """BG417: a model in a slot of another width

    What: the model in a slot has the right interface but other dimensions.

    Why: the bonds of the slot have the width of its declaration.

    Example: `lock : Lock[5] = Rigid[6];`

    Way out: give the model the slot's dimensions.
    """
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
