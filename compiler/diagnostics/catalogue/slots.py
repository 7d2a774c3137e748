"""Diagnostics: slots and the models that fill them."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, quoted
from bgc.diagnostics.source import Span


@error(
    "BG233: the slot `{name}` has no model",
    "write a default, `{name} : {interface} = ..;`, or `use` in the scene{fitting}",
)
def slot_not_filled(span: Span, name: str, interface: str, models: Sequence[str]) -> Values:
    return {"fitting": f"; these models fit: {quoted(models[:8])}" if models else ""}


@error(
    "BG234: `{model}` is not a `{interface}`", "declare `model {model} is {interface}` if it is one"
)
def does_not_fit(span: Span, model: str, interface: str, models: Sequence[str]) -> Values:
    return {"help": f"use a model that fits: {quoted(models[:8])}" if models else ""}


@error(
    "BG235: `{name}` is {what}, not a slot", "declare it as a slot: `name : Interface = Default;`"
)
def not_a_slot(span: Span, name: str, what: str) -> None: ...
@error(
    "BG236: `{model}` is declared to be a `{interface}`, but has no {missing}",
    "add it to the model",
    labels={"place": "required here"},
)
def interface_misses(span: Span, model: str, interface: str, missing: str, place: Span) -> None: ...
@error(
    "BG265: the interface `{interface}` takes declarations only",
    "move the statement to the models of the interface",
)
def statement_in_interface(span: Span, interface: str) -> None: ...
@error("BG237: `{slot}` is a slot and takes a model", "name a model, as in `{slot} = Rigid[5]`")
def type_expected(span: Span, slot: str) -> None: ...
