"""The models that fill slots, as arguments and statements name them."""

from __future__ import annotations

from bgc.diagnostics.catalogue import names, slots
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.tree import Environment, Given, Pending
from bgc.grammar import syntax
from bgc.language.elements import ELEMENTS
from bgc.resolution.modules import Declared, ancestors, fitting_models


def choose_fill(
    pending: Pending, interface: Declared[syntax.Model], used: Given | None
) -> tuple[syntax.TypeUse, Environment, Declared[syntax.Model]]:
    """Choose the type that fills a slot, the environment of its arguments, and its model.

    `used`, from a `use` of the scene, takes precedence over an argument, an argument over the
    default. BgError if nothing fills the slot, or if what does is not a model of the interface.
    """
    part, env = pending.part, pending.env
    fill, fill_env = part.default, env
    for given in (pending.fill, used):
        if given is not None:
            fill, fill_env = as_type_use(given, part.name), given.env
    if fill is None:
        fitting = fitting_models(interface.syntax, env.module.models)
        raise BgError([slots.slot_not_filled(part.name_span, part.name, part.type.name, fitting)])
    model = fill_env.module.models.get(fill.name)
    if model is None and fill.name not in ELEMENTS:
        raise BgError([names.unknown_type(fill.name_span, fill.name, fill_env.module.models)])
    if (
        model is None
        or model.syntax.interface
        or all(a.syntax is not interface.syntax for a in ancestors(model))
    ):
        fitting = fitting_models(interface.syntax, fill_env.module.models)
        raise BgError([slots.does_not_fit(fill.name_span, fill.name, part.type.name, fitting)])
    return fill, fill_env, model


def as_type_use(given: Given, slot: str) -> syntax.TypeUse:
    """Convert an argument to a type: `Rigid`, `Rigid[5]`, `Rigid()`, `Rigid[5](k = 3)`."""
    expr = given.value
    match expr:
        case syntax.TypeUse():
            return expr
        case syntax.Name():
            return syntax.TypeUse(expr.name, (), (), expr.span, expr.span)
        case syntax.Index(base=syntax.Name() as base) if not any(
            isinstance(i, syntax.Range) for i in expr.indices
        ):
            dims = tuple(i for i in expr.indices if not isinstance(i, syntax.Range))
            return syntax.TypeUse(base.name, dims, (), expr.span, base.span)
        case syntax.Call():
            arguments = tuple(syntax.Argument(None, a, a.span) for a in expr.arguments)
            return syntax.TypeUse(expr.function, (), arguments, expr.span, expr.span)
        case _:
            raise BgError([slots.type_expected(given.span, slot)])
