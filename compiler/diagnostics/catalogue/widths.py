"""Diagnostics of widths, domains and units of bonds."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def widths_differ(
    span: Span, one: int, one_at: Span | None, two: int, two_at: Span | None
) -> Diagnostic:
    """BG410: two widths for one bond

    What: what stands at the two ends of a bond, or around a junction, has different widths.

    Why: a bond of width n is n bonds; all must have both ends.

    Example: `body : I[6](M); node : J1[3]; node -> body;`

    Way out: correct one of the widths; to join bonds of width 3 and 3 to one of 6 use
    `join : Mux[3, 3];`, to take a part use a slice: `node[1..3] -> ..`.
    """
    labels = [
        Label(at, f"width {size}") for size, at in ((one, one_at), (two, two_at)) if at is not None
    ]
    return error(
        "BG410",
        f"widths {one} and {two} meet here",
        span,
        labels=labels,
        help="a `Mux` joins bonds, a slice as `hub[1..3]` takes a part of one",
    )


def widths_do_not_add_up(span: Span, name: str, total: int, parts: Sequence[int]) -> Diagnostic:
    """BG411: bonds that do not fill what they join

    What: the widths of the bonds at a Mux, or at an element of several ports, do not add up to
    its width.

    Why: every component needs exactly one bond.

    Example: `join : Mux[3, 3];` with bonds of width 3 and 2.

    Way out: correct the widths, or their number.
    """
    found = " + ".join(map(str, parts)) or "0"
    return error(
        "BG411",
        f"the bonds at `{name}` have widths {found}, where {total} is needed",
        span,
        help="every component needs one bond",
    )


def slice_outside(span: Span, name: str, component: int, width: int) -> Diagnostic:
    """BG412: a slice of components that are not there

    What: an index of a bond's end is less than 1 or more than the width.

    Why: components count from 1.

    Example: `hub[4..7] -> lin;` where hub has width 6.

    Way out: keep the slice within the width.
    """
    return error(
        "BG412",
        f"there is no component {component} in `{name}`",
        span,
        help=f"components count from 1 to {width}",
    )


def domains_differ(span: Span, one: str, one_at: Span, two: str, two_at: Span) -> Diagnostic:
    """BG413: two domains on one bond

    What: ports of different domains are bonded with each other.

    Why: a domain gives effort and flow their meaning; between two of them stands a transformer
    or gyrator.

    Example: a port of `Frame` bonded to one of `Electric`.

    Way out: put the TF or GY between that turns one into the other.
    """
    return error(
        "BG413",
        f"domains `{one}` and `{two}` meet here",
        span,
        labels=[Label(one_at, one), Label(two_at, two)],
        help="a TF or GY stands between two domains",
    )


def units_differ(
    span: Span, name: str, variable: str, one: str, one_at: Span, two: str, two_at: Span
) -> Diagnostic:
    """BG414: two units for one effort or flow

    What: the units given around a bond do not go together.

    Why: effort times flow is a power, and all bonds of a junction have the same units; here an
    element says otherwise.

    Example: `supply : Se(e = 5 V); push : Se(e = 2 N); supply, push -> node;`

    Way out: correct the unit, put a TF or GY between the domains, or declare the domain as
    `pseudo` where effort times flow is no power: `pseudo domain Heat { effort T : K; flow Q : W; }`
    and, in a model of the parts, `port side in : Heat;`. One such port tells all bonds that it is
    connected to by junctions.
    """
    labels = [Label(one_at, one)]
    if (two_at.start, two_at.end) != (one_at.start, one_at.end):
        labels.append(Label(two_at, two))
    return error(
        "BG414",
        f"the {variable} of `{name}` would be {one}, and {two}",
        span,
        labels=labels,
        help="correct one of the units; between two domains stands a TF or GY; where effort times "
        "flow is no power (temperature, heat flow), a port of a `pseudo domain` says so",
    )


def unit_misfit(
    span: Span,
    name: str,
    argument: str,
    wanted: str,
    given: str,
    places: Sequence[tuple[Span, str]],
) -> Diagnostic:
    """BG423: an element whose unit does not fit its bond

    What: the unit of a resistance, stiffness, compliance, inertia or conductance does not go with
    the effort and flow of the bond that it is on.

    Why: a stiffness is effort by displacement, an inertia momentum by flow: what the bond carries
    settles which unit each has.

    Example: `push : Se(e = 1 N); spring : C(stiffness = 20 kN*m); push -> spring;`

    Way out: correct the unit, here `20 kN/m`; a number without a unit fits any. Where the unit is
    right and the bond's is not, correct that, or put a TF or GY between the two domains.
    """
    labels: dict[tuple[int, int], Label] = {}
    for at, text in places:
        labels.setdefault((at.start, at.end), Label(at, text))
    return error(
        "BG423",
        f"on `{name}` the {argument} must be {wanted}, not {given}",
        span,
        labels=tuple(labels.values()),
        help="correct the unit; between two domains stands a TF or GY",
    )


def domain_unbalanced(span: Span, name: str, efforts: int, flows: int) -> Diagnostic:
    """BG415: a domain whose efforts and flows do not pair up

    What: a domain has more components of effort than of flow, or the other way round.

    Why: the k-th effort times the k-th flow is a power.

    Example: `domain D { effort F[3] : N; flow v[2] : m/s; }`

    Way out: give both the same number of components.
    """
    return error(
        "BG415",
        f"domain `{name}` has {efforts} efforts and {flows} flows",
        span,
        help="give both the same number of components, in the same order",
    )


def domain_no_power(span: Span, name: str, component: int, found: str) -> Diagnostic:
    """BG416: a domain whose effort times flow is no power

    What: the units of an effort and its flow multiply to something other than watts.

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

    What: the model in a slot is the right interface, but with other dimensions.

    Why: the slot's bonds have the width that it asks for.

    Example: `lock : Lock[5] = Rigid[6];`

    Way out: give the model the dimensions of the slot.
    """
    needs = ", ".join(map(str, asked))
    has = ", ".join(map(str, have))
    return error(
        "BG417",
        f"`{model}` is a `{interface}[{has}]` here, where a `{interface}[{needs}]` is needed",
        span,
        labels=[Label(place, "the slot")],
        help="give it the slot's dimensions",
    )
