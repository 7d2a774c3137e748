"""BG23x: slots, and the models that fill them."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def slot_not_filled(span: Span, name: str, interface: str, models: Sequence[str]) -> Diagnostic:
    """BG233: a slot without a model in it"""
    fitting = ", ".join(f"`{m}`" for m in models[:8])
    return error(
        "BG233",
        f"the slot `{name}` has no model",
        span,
        help=f"write a default, `{name} : {interface} = ..;`, or `use` in the scene"
        + (f"; these models fit: {fitting}" if fitting else ""),
    )


def does_not_fit(span: Span, model: str, interface: str, models: Sequence[str]) -> Diagnostic:
    """BG234: a model that does not fit its slot"""
    fitting = ", ".join(f"`{m}`" for m in models[:8])
    return error(
        "BG234",
        f"`{model}` is not a `{interface}`",
        span,
        help=f"use a model that fits: {fitting}"
        if fitting
        else f"declare `model {model} is {interface}` if it is one",
    )


def not_a_slot(span: Span, name: str, what: str) -> Diagnostic:
    """BG235: `use` of something that is not a slot"""
    return error(
        "BG235",
        f"`{name}` is {what}, not a slot",
        span,
        help="declare it as a slot: `name : Interface = Default;`",
    )


def interface_misses(
    span: Span, model: str, interface: str, missing: str, place: Span
) -> Diagnostic:
    """BG236: a model without a member of its interface"""
    return error(
        "BG236",
        f"`{model}` is declared to be a `{interface}`, but has no {missing}",
        span,
        labels=[Label(place, "required here")],
        help="add it to the model",
    )


def statement_in_interface(span: Span, interface: str) -> Diagnostic:
    """BG265: a statement in an interface"""
    return error(
        "BG265",
        f"the interface `{interface}` takes declarations only",
        span,
        help="move the statement to the models of the interface",
    )


def type_expected(span: Span, slot: str) -> Diagnostic:
    """BG237: something other than a type given to a slot"""
    return error(
        "BG237",
        f"`{slot}` is a slot and takes a model",
        span,
        help=f"name a model, as in `{slot} = Rigid[5]`",
    )
