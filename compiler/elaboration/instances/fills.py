"""The models that fill slots, as arguments and statements name them."""

from __future__ import annotations

from bgc.diagnostics.catalogue import slots
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.tree import Given
from bgc.grammar import syntax


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
