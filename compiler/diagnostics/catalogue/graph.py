"""Diagnostics of bonds and ports."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def cannot_be_bonded(
    span: Span, name: str, what: str, way: str = "name an element, part or port"
) -> Diagnostic:
    """BG400: an end of a bond that is not an element, part or port

    What: a chain of bonds names a value, or something else without a power port.

    Why: a bond connects two power ports.

    Example: `supply -> loop -> resistance;` where `param resistance`.

    Way out: name the element, part or port; give a value as an argument of a source.
    """
    return error(
        "BG400",
        f"`{name}` is {what} and cannot be bonded",
        span,
        help=way,
    )


def bond_to_inner_part(span: Span, part: str, owner: str, ports: Sequence[str]) -> Diagnostic:
    """BG401: a bond to the inside of a part

    What: a chain of bonds names something inside a part that is not one of the part's ports.

    Why: a model is bonded only at its ports, so that another model can replace it. Its values can
    be read from anywhere.

    Example: `crane.boom.hub -> load;`

    Way out: bond to a port of the part, or add a port to its model.
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

    What: a part's bare name appears in a chain, and several of its ports fit the arrow.

    Why: a bare name means the only port of that direction, or the one marked `main`.

    Example: `a -> gearbox;` where gearbox has two `in` ports.

    Way out: name the port: `a -> gearbox.shaft;`
    """
    listing = " or ".join(f"`{part}.{p}`" for p in ports)
    return error(
        "BG402",
        f"{len(ports)} ports of `{part}` fit an arrow {direction} it",
        span,
        help=f"write {listing}",
    )


def no_port(span: Span, part: str, direction: str, ports: Sequence[str]) -> Diagnostic:
    """BG403: a part without a port that fits

    What: an arrow points into a part that has only `out` ports, or out of one that has only `in`
    ports, or the part has no ports.

    Why: the arrow is the direction of positive power, and `in` or `out` fixes the direction of the
    port's bond.

    Example: `load -> crane;` where crane has only `port tip out`.

    Way out: reverse the arrow, or put a junction between.
    """
    listing = ", ".join(f"`{p}`" for p in ports)
    return error(
        "BG403",
        f"`{part}` has no port for an arrow {direction} it",
        span,
        help=f"reverse the arrow, or put a junction between; its ports are {listing}"
        if ports
        else "add a port to its model",
    )


def arrow_against_port(
    span: Span, port: str, direction: str, inside: bool, place: Span
) -> Diagnostic:
    """BG404: an arrow against the direction of a port

    What: an arrow points out of an `in` port or into an `out` port. (Inside the model it is the
    other way round: `base -> hub` continues the bond that enters at `base`.)

    Why: reversing the arrow silently would change the sign of a flow.

    Example: `port base in; hub -> base;`

    Way out: reverse the arrow. Two `out` ports, such as those of a force and of the last mass of a
    chain, are joined at a junction that both arrows enter: `force -> tip; mass -> tip;`.
    """
    where = "inside its model the arrow leaves it" if inside else "the arrow points into it"
    if direction == "out":
        where = "inside its model the arrow points into it" if inside else "the arrow leaves it"
    meeting = "j : J1; a, b -> j;" if direction == "out" else "j : J1; j -> a, b;"
    return error(
        "BG404",
        f"the arrow runs against the port `{port}`",
        span,
        labels=[Label(place, f"an `{direction}` port: {where}")],
        help="reverse the arrow"
        if inside
        else f"reverse the arrow, or put a J1 between: `{meeting}`",
    )


def arrow_out_of_element(span: Span, name: str, kind: str) -> Diagnostic:
    """BG405: an arrow out of a C, I or R

    What: a bond's half arrow points out of a storage element or a resistor.

    Why: power into these elements is positive; an arrow out of them would change the sign of the
    law.

    Example: `spring -> node;`

    Way out: reverse the arrow: `node -> spring;`
    """
    return error(
        "BG405",
        f"an arrow cannot leave `{name}`, {with_article(kind)}",
        span,
        help=f"reverse it: `.. -> {name}`",
    )


def bonded_twice(span: Span, name: str, first: Span, is_port: bool) -> Diagnostic:
    """BG406: two bonds on a port that takes one

    What: a port or a one-port element has a second bond.

    Why: power divides at a junction, and the result depends on which kind: J0 or J1.

    Example: `loop -> coil; other -> coil;`

    Way out: put a J0 (common effort) or J1 (common flow) between. An element with several ports
    needs its width in brackets: `field : C[2](..);`
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

    What: an element, or a port (outside or inside its model), has no bond; or a component of a wide
    junction has none, and the junction's effort or flow is read.

    Why: nothing is assumed about an open end.

    Example: `tip : J1;` and no bond that names it.

    Way out: bond it. For a free end (zero effort) write `free : Se(e = 0); part.port -> free;`, for
    a fixed end (zero flow) `fixed : Sf(f = 0);`.
    """
    return error(
        "BG407",
        f"{what} `{name}` is not bonded",
        span,
        help="bond it; for a free end use `free : Se(e = 0);`, for a fixed end `fixed : Sf(f = "
        "0);`",
    )


def arrows_meet(span: Span, name: str, other: Span, *, leave: bool) -> Diagnostic:
    """BG408: arrows in opposite directions

    What: a port without a direction has two bonds, inside and outside, and both point into it or
    both out of it.

    Why: inside and outside are one bond with one direction.

    Example: `port p;` with `hub -> p` inside and `j -> part.p` outside; or `p -> hub` and
    `part.p -> j`.

    Way out: reverse one of the two arrows. With `port p in;` the message comes at the arrow that is
    wrong.
    """
    return error(
        "BG408",
        f"the arrows on both sides of `{name}` point {'out of' if leave else 'into'} it",
        span,
        labels=[Label(other, "the other one")],
        help="reverse one of them: they are one bond with one direction",
    )


def no_element_on_bond(span: Span, name: str) -> Diagnostic:
    """BG409: a bond that leads to no element

    What: a bond passes only through ports and returns to its start.

    Why: a bond connects two elements.

    Example: two ports of a part that are bonded to each other both outside and inside.

    Way out: put an element or a junction on it.
    """
    return error("BG409", f"the bond `{name}` runs in a circle of ports", span,
                 help="put a junction or an element on it")  # fmt: skip


def too_many_parts(span: Span, most: int) -> Diagnostic:
    """BG418: too many parts

    What: a `for` or an array makes more parts than the compiler supports.

    Why: each part becomes separate code; such a number is usually a typing error.

    Example: `for i in 1..1000000000 { }`

    Way out: use fewer parts.
    """
    return error("BG418", f"more than {most} parts or iterations of `for`", span, help="use fewer")


def unknown_port_member(span: Span, owner: str, name: str, have: Sequence[str]) -> Diagnostic:
    """BG419: a variable that an element or port does not have

    What: the name after an element or port is not one of its readable variables.

    Why: a resistor has no displacement, and the bonds of a J0 have no common flow.

    Example: `observe junction.f;` of a J0.

    Way out: read one of the variables that the help lists.
    """
    listing = ", ".join(f"`{h}`" for h in have)
    return error("BG419", f"{owner} has no `{name}`", span, help=f"read one of {listing}")


def nobody_writes(span: Span, port: str, signal: str) -> Diagnostic:
    """BG420: a signal that nothing writes

    What: a signal that the domain carries is read, but nothing upstream on the bond writes it.

    Why: the tail of a bond writes its signals and the head reads them. They pass through ports and
    1-junctions, and end at every other element.

    Example: `output z = frame.r.z;` with only a source at `frame`.

    Way out: write the signal where the bond starts: `tip.r = ..;` in a model with `port tip out`.
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

    Why: the signal would have two values.

    Example: two bodies, both writing their pose, bonded to one J1.

    Way out: reverse one of the bonds, or let only one side write the signal.
    """
    return error(
        "BG421",
        f"`{signal}` reaches `{where}` from two sides",
        span,
        labels=[Label(p, "written here") for p in places],
        help="reverse one of the bonds, or let only one side write the signal",
    )


def cannot_assign(span: Span, name: str) -> Diagnostic:
    """BG422: a value for a name that cannot be assigned

    What: the left side of `=` is neither an `output` or `signal` declared without a value, nor a
    signal of one of the model's own ports.

    Why: each value is defined once, at its declaration.

    Example: `param k = 2; k = 3;`

    Way out: write the value in the declaration, or declare an `output`; a state is defined by
    `der(x) = ..;`.
    """
    return error(
        "BG422",
        f"`{name}` cannot be assigned here",
        span,
        help="write the value in its declaration; only an `output` or `signal` declared without a "
        "value, or a signal of a port, is assigned",
    )


def nothing_to_compute(span: Span, name: str) -> Diagnostic:
    """BG453: a model without contents

    What: the scene's model has no elements, states or equations.

    Why: there is nothing to run.

    Example: `model Empty { }`

    Way out: add parts, or name another model in the scene.
    """
    return error("BG453", f"the model `{name}` has nothing to compute", span,
                 help="add elements, states or equations")  # fmt: skip


def mux_count(span: Span, name: str, expected: int, found: int) -> Diagnostic:
    """BG454: a Mux with the wrong number of bonds

    What: a Mux has one width in brackets for each bond that it joins, in order; here the numbers
    differ.

    Why: the widths divide the wide bond among the joined bonds.

    Example: `join : Mux[5, 1];` with three incoming bonds.

    Way out: write one width for each bond, all bonds in one statement: `lock, free -> join;`
    """
    return error(
        "BG454",
        f"`{name}` has {expected} widths for {found} bonds",
        span,
        help="write one width for each bond, in the same order",
    )
