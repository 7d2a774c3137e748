"""Diagnostics: scenes."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from bgc.diagnostics.catalogue import Values, error, nearest, quoted
from bgc.diagnostics.source import Span


@error("BG600: there is no scene `{name}`", "{there}")
def unknown_scene(name: str, scenes: Sequence[str]) -> Values:
    there = f"name a scene of the file: {quoted(scenes)}"
    if not scenes:
        there = "omit `--scene`: the file has no scenes"
    return {"there": there, **nearest(name, scenes)}


@error("BG601: `{name}` declares no model and no scene", "add `scene s of Model { .. }`")
def nothing_to_run(name: str) -> None: ...
@error("BG602: model `{name}` needs dimensions to be run", "write `scene s of {name}[..] { .. }`")
def only_dimensioned(span: Span, name: str) -> None: ...
@error("BG603: `{path}` is {but}not {what}", "name {what} of the model")
def edit_without_target(
    span: Span, path: str, what: str, found: str = "", help: str = ""
) -> Values:
    return {"but": f"{found}, " if found else ""}


@error(
    "BG610: device `{device}` has no channel `{name}` here",
    "use one of its channels: {have:quoted}",
)
def unknown_channel(span: Span, name: str, device: str, have: Collection[str]) -> Values:
    return nearest(name, have, span)


@error(
    "BG611: the name `{name}` is taken",
    "give the device another name",
    labels={"first": "already declared here"},
)
def device_name_taken(span: Span, name: str, first: Span | None) -> None: ...
@error("BG612: {name} {wants}", 'give a number or a quoted text: `trace(file = "hand.csv")`')
def device_option(span: Span, name: str, needed: str = "") -> Values:
    if needed:
        return {"wants": f"needs the option `{needed}`"}
    return {"wants": "takes options of the form `name = value`"}


@error("BG620: an observed expression needs a name", "write `.. as name`")
def observe_needs_name(span: Span) -> None: ...
@error(
    "BG621: two columns are called `{name}`",
    "rename one with `as`",
    labels={"first": "the first one"},
)
def column_twice(span: Span, name: str, first: Span) -> None: ...
@error("BG622: there is no energy account `{name}`", "use one of {accounts:quoted}")
def unknown_account(span: Span, name: str, have: Sequence[str]) -> Values:
    return {"accounts": [f"energy.{each}" for each in have], **nearest(name, have, span)}


@error(
    "BG490: a column in `{unit}` cannot hold {quantity}",
    "write a unit of the same quantity, or omit `in` for SI units",
)
def unit_of_column(span: Span, unit: str, quantity: str) -> None: ...
@error("BG623: `{name}` is plotted, but the scene does not observe it", "add `observe {name};`")
def plot_unobserved(span: Span, name: str, columns: Sequence[str]) -> Values:
    return nearest(name, columns, span)


@error("BG632: solvers have no option `{name}`", "use one of {have:quoted}")
def unknown_option(span: Span, name: str, have: Sequence[str]) -> Values:
    return nearest(name, have, span)


@error(
    "BG630: {what} is {value:g}, but must be positive",
    "give a positive value; a time without a unit is in seconds",
)
def not_positive(span: Span, what: str, value: float) -> None: ...
@error(
    "BG631: the scene has two `{what}` statements",
    "remove one of them",
    labels={"first": "the first one"},
)
def said_twice(span: Span, what: str, first: Span) -> None: ...
@error(
    "BG465: `{path}` does not depend on a state, so a start at rest cannot move it",
    "hold a value of states, such as the angle of a joint, or omit it",
)
def hold_without_state(span: Span, path: str) -> None: ...
@error(
    "BG466: `{path}` is not a parameter",
    "name a parameter of the model, which the start may change",
)
def vary_without_parameter(span: Span, path: str) -> None: ...
