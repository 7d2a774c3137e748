"""Diagnostics of bonds and ports."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def cannot_be_bonded(
    span: Span, name: str, what: str, way: str = "name an element, part or port"
) -> Diagnostic:
    """BG400: an end of a bond that is not an element, part or port"""
    return error(
        "BG400",
        f"`{name}` is {what} and cannot be bonded",
        span,
        help=way,
    )


def bond_to_inner_part(span: Span, part: str, owner: str, ports: Sequence[str]) -> Diagnostic:
    """BG401: a bond to the inside of a part"""
    listing = ", ".join(f"`{owner}.{p}`" for p in ports)
    return error(
        "BG401",
        f"`{part}` is inside `{owner}`",
        span,
        help=f"bond to a port: {listing}" if listing else f"add a port to the model of `{owner}`",
    )


def which_port(span: Span, part: str, direction: str, ports: Sequence[str]) -> Diagnostic:
    """BG402: a part with several ports that fit"""
    listing = " or ".join(f"`{part}.{p}`" for p in ports)
    return error(
        "BG402",
        f"{len(ports)} ports of `{part}` fit an arrow {direction} it",
        span,
        help=f"write {listing}",
    )


def no_port(span: Span, part: str, direction: str, ports: Sequence[str]) -> Diagnostic:
    """BG403: a part without a port that fits"""
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
    """BG404: an arrow against the direction of a port"""
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
    """BG405: an arrow out of a C, I or R"""
    return error(
        "BG405",
        f"an arrow cannot leave `{name}`, {with_article(kind)}",
        span,
        help=f"reverse it: `.. -> {name}`",
    )


def bonded_twice(span: Span, name: str, first: Span, is_port: bool) -> Diagnostic:
    """BG406: two bonds on a port that takes one"""
    more = "" if is_port else ", or give the element a width, as in `C[2]`"
    return error(
        "BG406",
        f"`{name}` is bonded twice",
        span,
        labels=[Label(first, "first bonded here")],
        help=f"put a J0 or J1 between{more}",
    )


def not_bonded(span: Span, name: str, what: str) -> Diagnostic:
    """BG407: an element or port without a bond"""
    return error(
        "BG407",
        f"{what} `{name}` is not bonded",
        span,
        help="bond it; for a free end use `free : Se(e = 0);`, for a fixed end `fixed : Sf(f = "
        "0);`",
    )


def arrows_meet(span: Span, name: str, other: Span, *, leave: bool) -> Diagnostic:
    """BG408: arrows in opposite directions"""
    return error(
        "BG408",
        f"the arrows on both sides of `{name}` point {'out of' if leave else 'into'} it",
        span,
        labels=[Label(other, "the other one")],
        help="reverse one of them: they are one bond with one direction",
    )


def no_element_on_bond(span: Span, name: str) -> Diagnostic:
    """BG409: a bond that leads to no element"""
    return error("BG409", f"the bond `{name}` runs in a circle of ports", span,
                 help="put a junction or an element on it")  # fmt: skip


def too_many_parts(span: Span, most: int) -> Diagnostic:
    """BG418: too many parts"""
    return error("BG418", f"more than {most} parts or iterations of `for`", span, help="use fewer")


def unknown_port_member(span: Span, owner: str, name: str, have: Sequence[str]) -> Diagnostic:
    """BG419: a variable that an element or port does not have"""
    listing = ", ".join(f"`{h}`" for h in have)
    return error("BG419", f"{owner} has no `{name}`", span, help=f"read one of {listing}")


def nobody_writes(span: Span, port: str, signal: str) -> Diagnostic:
    """BG420: a signal that nothing writes"""
    return error(
        "BG420",
        f"nothing writes `{signal}` along the bond at `{port}`",
        span,
        help=f"write it where the bond starts: `tip.{signal} = ..;`",
    )


def written_twice_over(span: Span, where: str, signal: str, places: Sequence[Span]) -> Diagnostic:
    """BG421: a signal that comes from two sides"""
    return error(
        "BG421",
        f"`{signal}` reaches `{where}` from two sides",
        span,
        labels=[Label(p, "written here") for p in places],
        help="reverse one of the bonds, or let only one side write the signal",
    )


def cannot_assign(span: Span, name: str) -> Diagnostic:
    """BG422: a value for a name that cannot be assigned"""
    return error(
        "BG422",
        f"`{name}` cannot be assigned here",
        span,
        help="write the value in its declaration; only an `output` or `signal` declared without a "
        "value, or a signal of a port, is assigned",
    )


def nothing_to_compute(span: Span, name: str) -> Diagnostic:
    """BG453: a model without contents"""
    return error("BG453", f"the model `{name}` has nothing to compute", span,
                 help="add elements, states or equations")  # fmt: skip


def mux_count(span: Span, name: str, expected: int, found: int) -> Diagnostic:
    """BG454: a Mux with the wrong number of bonds"""
    return error(
        "BG454",
        f"`{name}` has {expected} widths for {found} bonds",
        span,
        help="write one width for each bond, in the same order",
    )
