"""Diagnostics of scenes: devices, drives, observed columns, options of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def unknown_scene(name: str, scenes: Sequence[str]) -> Diagnostic:
    """BG600: a scene that the file does not have"""
    listing = ", ".join(f"`{s}`" for s in scenes)
    near = did_you_mean(name, scenes)
    return error(
        "BG600",
        f"there is no scene `{name}`",
        help=near
        or (
            f"name a scene of the file: {listing}"
            if listing
            else "omit `--scene`: the file has no scenes"
        ),
    )


def nothing_to_run(name: str) -> Diagnostic:
    """BG601: a file without a model"""
    return error(
        "BG601", f"`{name}` declares no model and no scene", help="add `scene s of Model { .. }`"
    )


def only_dimensioned(span: Span, name: str) -> Diagnostic:
    """BG602: a model with dimensions and no scene"""
    return error(
        "BG602",
        f"model `{name}` needs dimensions to be run",
        span,
        help=f"write `scene s of {name}[..] {{ .. }}`",
    )


def edit_without_target(
    span: Span, path: str, what: str, found: str = "", way: str = ""
) -> Diagnostic:
    """BG603: a `set`, `use` or `drive` of the wrong kind of target"""
    other = f"{found}, not {what}" if found else f"not {what}"
    return error("BG603", f"`{path}` is {other}", span, help=way or f"name {what} of the model")


def unknown_channel(span: Span, name: str, device: str, have: Iterable[str]) -> Diagnostic:
    """BG610: a channel that the device does not have"""
    have = list(have)
    listing = ", ".join(f"`{h}`" for h in have)
    return error(
        "BG610",
        f"device `{device}` has no channel `{name}` here",
        span,
        help=did_you_mean(name, have) or f"use one of its channels: {listing}",
        edits=respelt(span, name, have),
    )


def device_name_taken(span: Span, name: str, first: Span | None) -> Diagnostic:
    """BG611: a device whose name is already in use"""
    labels = [Label(first, "already declared here")] if first else []
    return error("BG611", f"the name `{name}` is taken", span, labels=labels,
                 help="give the device another name")  # fmt: skip


def device_option(span: Span, name: str, needed: str = "") -> Diagnostic:
    """BG612: an invalid option of a device or solver"""
    return error(
        "BG612",
        f"{name} needs the option `{needed}`"
        if needed
        else f"{name} takes options of the form `name = value`",
        span,
        help='give a number or a quoted text: `trace(file = "hand.csv")`',
    )


def observe_needs_name(span: Span) -> Diagnostic:
    """BG620: an observed expression without a name"""
    return error("BG620", "an observed expression needs a name", span, help="write `.. as name`")


def column_twice(span: Span, name: str, first: Span) -> Diagnostic:
    """BG621: two columns with the same name"""
    return error(
        "BG621",
        f"two columns are called `{name}`",
        span,
        labels=[Label(first, "the first one")],
        help="rename one with `as`",
    )


def unknown_account(span: Span, name: str, have: Sequence[str]) -> Diagnostic:
    """BG622: an energy account that does not exist"""
    listing = ", ".join(f"`energy.{h}`" for h in have)
    return error(
        "BG622",
        f"there is no energy account `{name}`",
        span,
        help=did_you_mean(name, have) or f"use one of {listing}",
        edits=respelt(span, name, have),
    )


def unit_of_column(span: Span, unit: str, quantity: str) -> Diagnostic:
    """BG490: a column in a unit of another quantity"""
    return error(
        "BG490",
        f"a column in `{unit}` cannot hold {quantity}",
        span,
        help="write a unit of the same quantity, or omit `in` for SI units",
    )


def plot_unobserved(span: Span, name: str, columns: Sequence[str]) -> Diagnostic:
    """BG623: a plot of an unobserved quantity"""
    return error(
        "BG623",
        f"`{name}` is plotted, but the scene does not observe it",
        span,
        help=did_you_mean(name, columns) or f"add `observe {name};`",
        edits=respelt(span, name, columns),
    )


def unknown_option(span: Span, name: str, have: Sequence[str]) -> Diagnostic:
    """BG632: an option that solvers do not have"""
    listing = ", ".join(f"`{h}`" for h in have)
    return error(
        "BG632",
        f"solvers have no option `{name}`",
        span,
        help=did_you_mean(name, have) or f"use one of {listing}",
        edits=respelt(span, name, have),
    )


def not_positive(span: Span, what: str, value: float) -> Diagnostic:
    """BG630: a time or tolerance that is not positive"""
    return error(
        "BG630",
        f"{what} is {value:g}, but must be positive",
        span,
        help="give a positive value; a time without a unit is in seconds",
    )


def said_twice(span: Span, what: str, first: Span) -> Diagnostic:
    """BG631: a statement given twice in a scene"""
    return error(
        "BG631",
        f"the scene has two `{what}` statements",
        span,
        labels=[Label(first, "the first one")],
        help="remove one of them",
    )


def hold_without_state(span: Span, path: str) -> Diagnostic:
    """BG465: a value to hold that no state determines"""
    return error(
        "BG465",
        f"`{path}` does not depend on a state, so a start at rest cannot move it",
        span,
        help="hold a value of states, such as the angle of a joint, or omit it",
    )


def vary_without_parameter(span: Span, path: str) -> Diagnostic:
    """BG466: something to vary that is not a parameter"""
    return error(
        "BG466",
        f"`{path}` is not a parameter",
        span,
        help="name a parameter of the model, which the start may change",
    )
