"""Diagnostics of bonds and ports."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def cannot_be_bonded(span: Span, name: str, what: str) -> Diagnostic:
    """BG400: an end of a bond that is no element, part or port

    What: a chain names a value, or something else that has no power port.

    Why: a bond joins two power ports.

    Example: `supply -> loop -> resistance;` where `param resistance`.

    Way out: name the element, part or port; a value is given to a source as its argument.
    """
    return error(
        "BG400",
        f"`{name}` is {what}, and cannot be bonded",
        span,
        help="a bond joins elements, parts and ports",
    )


def bond_to_inner_part(span: Span, part: str, owner: str, ports: Sequence[str]) -> Diagnostic:
    """BG401: a bond to the inside of a part

    What: a chain names something inside a part that is not one of its ports.

    Why: a model is bonded only at its ports, so that another may take its place. Its values can
    be read from everywhere.

    Example: `crane.boom.hub -> load;`

    Way out: bond to a port of the part, or add one to its model.
    """
    listing = ", ".join(f"`{owner}.{p}`" for p in ports)
    return error(
        "BG401",
        f"`{part}` is inside `{owner}`",
        span,
        help=f"bond to a port: {listing}" if listing else f"add a port to the model of `{owner}`",
    )


def which_port(span: Span, part: str, direction: str, ports: Sequence[str]) -> Diagnostic:
    """BG402: a part with several ports that fit

    What: a part stands in a chain by its bare name, and more than one of its ports could take
    the arrow.

    Why: a bare name means the part's only port of that direction, or the one marked `main`.

    Example: `a -> gearbox;` where gearbox has two `in` ports.

    Way out: name the port: `a -> gearbox.shaft;`
    """
    listing = " or ".join(f"`{part}.{p}`" for p in ports)
    return error(
        "BG402",
        f"`{part}` has {len(ports)} ports for an arrow {direction} it",
        span,
        help=f"write {listing}",
    )


def no_port(span: Span, part: str, direction: str, ports: Sequence[str]) -> Diagnostic:
    """BG403: a part without a port that fits

    What: an arrow points into a part that has only `out` ports, or out of one that has only
    `in` ports, or the part has no ports.

    Why: the arrow is the direction of positive power, and a port says which way its bond points.

    Example: `load -> crane;` where crane has only `port tip out`.

    Way out: turn the arrow round, or put a junction between.
    """
    listing = ", ".join(f"`{p}`" for p in ports)
    return error(
        "BG403",
        f"`{part}` has no port for an arrow {direction} it",
        span,
        help=f"its ports are {listing}" if ports else "its model has no ports",
    )


def arrow_against_port(
    span: Span, port: str, direction: str, inside: bool, place: Span
) -> Diagnostic:
    """BG404: an arrow against the direction of a port

    What: an arrow points out of an `in` port or into an `out` port (seen from outside; inside
    the model it is the other way round: there `base -> hub` carries on what came in).

    Why: turning it silently would change the sign of a flow.

    Example: `port base in; hub -> base;`

    Way out: turn the arrow round.
    """
    where = "inside its model the arrow leaves it" if inside else "the arrow points into it"
    if direction == "out":
        where = "inside its model the arrow points into it" if inside else "the arrow leaves it"
    return error(
        "BG404",
        f"the arrow runs against the port `{port}`",
        span,
        labels=[Label(place, f"an `{direction}` port: {where}")],
        help="turn the arrow round",
    )


def arrow_out_of_element(span: Span, name: str, kind: str) -> Diagnostic:
    """BG405: an arrow out of a C, I or R

    What: a bond's half arrow leaves a storage element or a resistor.

    Why: their power is counted as it flows in; an arrow out would turn the sign of the law.

    Example: `spring -> node;`

    Way out: turn the arrow round: `node -> spring;`
    """
    return error(
        "BG405",
        f"an arrow cannot leave `{name}`, {with_article(kind)}",
        span,
        help=f"turn it round: `.. -> {name}`",
    )


def bonded_twice(span: Span, name: str, first: Span, is_port: bool) -> Diagnostic:
    """BG406: two bonds where there is room for one

    What: a port or a one-port element has a second bond.

    Why: where power divides there is a junction, and it matters which.

    Example: `loop -> coil; other -> coil;`

    Way out: put a J0 (common effort) or J1 (common flow) between. An element of several ports
    gets its width in brackets: `field : C[2](..);`
    """
    more = "" if is_port else ", or give the element a width, as in `C[2]`"
    return error(
        "BG406",
        f"`{name}` is bonded twice",
        span,
        labels=[Label(first, "first bonded here")],
        help=f"put a J0 or J1 between{more}",
    )


def not_bonded(span: Span, name: str, what: str) -> Diagnostic:
    """BG407: an element or port without a bond

    What: an element, or a port seen from outside or inside, is not bonded.

    Why: what happens at an open end has to be said: nothing is assumed.

    Example: `tip : J1;` and no chain that names it.

    Way out: bond it. A free end has no effort: `free : Se(e = 0); part.port -> free;`. A fixed
    one has no flow: `fixed : Sf(f = 0);`
    """
    return error(
        "BG407",
        f"{what} `{name}` is not bonded",
        span,
        help="bond it; a free end is `free : Se(e = 0);`, a held one `held : Sf(f = 0);`",
    )


def arrows_meet(span: Span, name: str, other: Span) -> Diagnostic:
    """BG408: arrows that meet head to head

    What: two bonds meet at a port without a direction, and both point to it or away from it.

    Why: they are one bond, and it has one direction.

    Example: `port p;` with `hub -> p` inside and `j -> part.p` outside.

    Way out: turn one of the two arrows round.
    """
    return error(
        "BG408",
        f"the bonds on both sides of `{name}` point against each other",
        span,
        labels=[Label(other, "the other one")],
        help="turn one of them round",
    )


def no_element_on_bond(span: Span, name: str) -> Diagnostic:
    """BG409: a bond that leads to no element

    What: following a bond through ports leads round in a circle.

    Why: a bond joins two elements.

    Example: two ports of a part that are bonded with each other outside and inside.

    Way out: put an element or a junction on it.
    """
    return error("BG409", f"the bond `{name}` leads round in a circle of ports", span,
                 help="put a junction or an element on it")  # fmt: skip


def too_many_parts(span: Span, most: int) -> Diagnostic:
    """BG418: more parts than the compiler is made for

    What: a `for` or an array makes more parts than any model needs.

    Why: every part becomes code of its own; this is most often a slip of the keyboard.

    Example: `for i in 1..1000000000 { }`

    Way out: use fewer.
    """
    return error("BG418", f"more than {most} parts or turns of a `for`", span, help="use fewer")


def unknown_port_member(span: Span, owner: str, name: str, have: Sequence[str]) -> Diagnostic:
    """BG419: something that an element or port does not show

    What: the name after an element or port is none of what can be read of it.

    Why: a resistor has no displacement, a 0-junction no one flow.

    Example: `observe junction.f;` of a J0.

    Way out: read one of those that the message lists.
    """
    listing = ", ".join(f"`{h}`" for h in have)
    return error("BG419", f"{owner} has no `{name}`", span, help=f"it has {listing}")


def nobody_writes(span: Span, port: str, signal: str) -> Diagnostic:
    """BG420: a signal along a bond that nobody gives

    What: a signal that the domain carries is read, but nothing up the bond writes it.

    Why: the tail of a bond writes its signals, the head reads them. They pass through ports and
    1-junctions, and end at every other element.

    Example: `output z = frame.r.z;` with nothing but a source at `frame`.

    Way out: write it where the bond starts: `tip.r = ..;` in a model with `port tip out`.
    """
    return error(
        "BG420",
        f"nothing writes `{signal}` along the bond at `{port}`",
        span,
        help=f"write it where the bond starts: `tip.{signal} = ..;`",
    )


def written_twice_over(span: Span, where: str, signal: str, places: Sequence[Span]) -> Diagnostic:
    """BG421: a signal that comes from two sides

    What: two bonds bring the same signal to one junction.

    Why: which of them is meant could not be told.

    Example: two bodies, both writing their pose, bonded into one J1.

    Way out: turn one of the bonds round, or let only one side write the signal.
    """
    return error(
        "BG421",
        f"`{signal}` reaches `{where}` from two sides",
        span,
        labels=[Label(p, "written here") for p in places],
        help="only one bond may bring it in",
    )


def cannot_assign(span: Span, name: str) -> Diagnostic:
    """BG422: a statement that gives a value to something that takes none

    What: the left side of `=` is no output or signal declared without a value, and no signal of
    one of the model's own ports.

    Why: everything has one definition, at its declaration.

    Example: `param k = 2; k = 3;`

    Way out: write the value in the declaration, or declare an `output`; a state is given by
    `der(x) = ..;`
    """
    return error(
        "BG422",
        f"`{name}` cannot be given a value here",
        span,
        help="only an `output` or `signal` declared without a value, or a signal of a port, can",
    )


def nothing_to_compute(span: Span, name: str) -> Diagnostic:
    """BG453: a model without contents

    What: the model of the scene has no element, no state and no equation.

    Why: there is nothing to run.

    Example: `model Empty { }`

    Way out: add parts, or name another model in the scene.
    """
    return error("BG453", f"the model `{name}` has nothing to compute", span,
                 help="add elements, states or equations")  # fmt: skip


def mux_count(span: Span, name: str, expected: int, found: int) -> Diagnostic:
    """BG454: a Mux with more or fewer bonds than widths

    What: the widths in brackets are those of the bonds that a Mux joins, in their order, and
    there are more or fewer bonds.

    Why: each bond needs its place in the wide one.

    Example: `join : Mux[5, 1];` with three bonds coming in.

    Way out: write one width for each bond, all bonds in one statement: `lock, free -> join;`
    """
    return error(
        "BG454",
        f"`{name}` has {expected} widths for {found} bonds",
        span,
        help="write one width for each bond, in their order",
    )
