"""Diagnostics: bonds and ports."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, quoted
from bgc.diagnostics.source import Span


@error("BG400: `{name}` is {what} and cannot be bonded", "{way}")
def cannot_be_bonded(
    span: Span, name: str, what: str, way: str = "name an element, part or port"
) -> None: ...
@error("BG401: `{part}` is inside `{owner}`", "add a port to the model of `{owner}`")
def bond_to_inner_part(span: Span, part: str, owner: str, ports: Sequence[str]) -> Values:
    listing = quoted(f"{owner}.{port}" for port in ports)
    return {"help": f"bond to a port: {listing}" if ports else ""}


@error("BG402: {count} ports of `{part}` fit an arrow {direction} it", "write {ways:either}")
def which_port(span: Span, part: str, direction: str, ports: Sequence[str]) -> Values:
    return {"count": len(ports), "ways": [f"{part}.{port}" for port in ports]}


@error("BG403: `{part}` has no port for an arrow {direction} it", "add a port to its model")
def no_port(span: Span, part: str, direction: str, ports: Sequence[str]) -> Values:
    way = f"reverse the arrow, or put a junction between; its ports are {quoted(ports)}"
    return {"help": way if ports else ""}


@error(
    "BG404: the arrow runs against the port `{port}`",
    "reverse the arrow{way}",
    labels={"place": "an `{direction}` port: {where}"},
)
def arrow_against_port(span: Span, port: str, direction: str, inside: bool, place: Span) -> Values:
    leaves = inside != (direction == "out")
    where = f"{'inside its model ' if inside else ''}the arrow "
    meeting = "j : J1; a, b -> j;" if direction == "out" else "j : J1; j -> a, b;"
    return {
        "where": where + ("leaves it" if leaves else "points into it"),
        "way": "" if inside else f", or put a J1 between: `{meeting}`",
    }


@error("BG405: an arrow cannot leave `{name}`, {kind:an}", "reverse it: `.. -> {name}`")
def arrow_out_of_element(span: Span, name: str, kind: str) -> None: ...
@error(
    "BG406: `{name}` is bonded twice",
    "put a J0 or J1 between{more}",
    labels={"first": "first bonded here"},
)
def bonded_twice(span: Span, name: str, first: Span, is_port: bool) -> Values:
    return {"more": "" if is_port else ", or give the element a width, as in `C[2]`"}


@error(
    "BG407: {what} `{name}` is not bonded",
    "bond it; for a free end use `free : Se(e = 0);`, for a fixed end `fixed : Sf(f = 0);`",
)
def not_bonded(span: Span, name: str, what: str) -> None: ...
@error(
    "BG408: the arrows on both sides of `{name}` point {way} it",
    "reverse one of them: they are one bond with one direction",
    labels={"other": "the other one"},
)
def arrows_meet(span: Span, name: str, other: Span, *, leave: bool) -> Values:
    return {"way": "out of" if leave else "into"}


@error("BG409: the bond `{name}` runs in a circle of ports", "put a junction or an element on it")
def no_element_on_bond(span: Span, name: str) -> None: ...
@error("BG418: more than {most} parts or iterations of `for`", "use fewer")
def too_many_parts(span: Span, most: int) -> None: ...
@error("BG419: {owner} has no `{name}`", "name an element or port that has it")
def unknown_port_member(span: Span, owner: str, name: str, have: Sequence[str]) -> Values:
    return {"help": f"read one of {quoted(have)}" if have else ""}


@error(
    "BG420: nothing writes `{signal}` along the bond at `{port}`",
    "write it where the bond starts: `tip.{signal} = ..;`",
)
def nobody_writes(span: Span, port: str, signal: str) -> None: ...
@error(
    "BG421: `{signal}` reaches `{where}` from two sides",
    "reverse one of the bonds, or let only one side write the signal",
    labels={"places": "written here"},
)
def written_twice_over(span: Span, where: str, signal: str, places: Sequence[Span]) -> None: ...
@error(
    "BG422: `{name}` cannot be assigned here",
    "write the value in its declaration; only an `output` or `signal` declared without a "
    "value, or a signal of a port, is assigned",
)
def cannot_assign(span: Span, name: str) -> None: ...
@error("BG453: the model `{name}` has nothing to compute", "add elements, states or equations")
def nothing_to_compute(span: Span, name: str) -> None: ...
@error(
    "BG454: `{name}` has {expected} widths for {found} bonds",
    "write one width for each bond, in the same order",
)
def mux_count(span: Span, name: str, expected: int, found: int) -> None: ...
