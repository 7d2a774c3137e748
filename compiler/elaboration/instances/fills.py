"""The models that fill slots, as arguments and statements name them."""

from __future__ import annotations

from collections.abc import Iterator

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


def former_fill(
    fill: syntax.TypeUse, env: Environment, pending: Pending
) -> tuple[syntax.TypeUse, Environment] | None:
    """The type that a `use` replaces: that of another `use`, else an argument's, else the default.

    `env` is the environment of `fill`. None where nothing filled the slot before.
    """
    if fill.replaced is not None:
        return fill.replaced, env
    if pending.fill is not None:
        return as_type_use(pending.fill, pending.part.name), pending.fill.env
    return None if pending.part.default is None else (pending.part.default, pending.env)


def given_arguments(
    fill: syntax.TypeUse, env: Environment, pending: Pending
) -> Iterator[tuple[str, Given]]:
    """Yield the named arguments of a type in a slot, then those that it keeps of the one before."""
    for argument in fill.arguments:
        if argument.name is not None:
            yield argument.name, Given(argument.value, env, argument.span)
    former = former_fill(fill, env, pending) if fill.keeps else None
    if former is not None:
        yield from given_arguments(*former, pending)


def takes(model: Declared[syntax.Model], name: str) -> bool:
    """Return whether a model, or one that it extends, can be given an argument."""
    return any(
        _can_be_given(item, name, each) for each in ancestors(model) for item in each.syntax.items
    )


def _can_be_given(item: syntax.Item, name: str, declared: Declared[syntax.Model]) -> bool:
    match item:
        case syntax.Value(kind="param" | "const" | "input"):
            return item.name == name
        case syntax.Part():
            found = declared.module.models.get(item.type.name)
            is_slot = item.default is not None or (found is not None and found.syntax.interface)
            return item.name == name and is_slot
        case _:
            return False


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
