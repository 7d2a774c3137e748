"""Scalars, vectors and matrices of flat expressions, as nested lists."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flat_expressions import ZERO, evaluate
from program_text import whole
from program_tree import (
    Apply,
    End,
    Expr,
    Num,
    Own,
    Read,
    Step,
    read,
)

Flat: TypeAlias = "Expr | list[Flat]"


def step_name(step: Step) -> str:
    if step.index is None:
        return step.name
    return f"{step.name}[{whole(step.index, {})}]"


def chosen(end: End, width: int) -> range:
    first, last = end.slice or (1, width)
    return range(first - 1, last)


def items_of(found: Flat) -> list[Expr]:
    return [found] if isinstance(found, Expr) else list(found)  # type: ignore[arg-type]


def slim(items: list[Expr]) -> Flat:
    """A vector of one component counts as a scalar."""
    return items[0] if len(items) == 1 else list(items)


def only(found: Flat) -> Expr:
    (only,) = items_of(found)
    return only


def mapped(found: Flat, function) -> Flat:  # type: ignore[no-untyped-def]
    if isinstance(found, list):
        return [mapped(x, function) for x in found]
    return function(found)


def sum_of(terms: Sequence[Expr]) -> Expr:
    total: Expr = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


def own_variables(e: Expr) -> list[Own]:
    if isinstance(e, Own):
        return [e]
    return [x for a in e.args for x in own_variables(a)] if isinstance(e, Apply) else []


def with_loop_numbers(e: Expr, loops: dict[str, int]) -> Expr:
    """The expression with the numbers of loops, for it is read outside of them."""
    match e:
        case Read(path=(Step(name=name, index=None),), component=None) if name in loops:
            return Num(Fraction(loops[name]))
        case Read(path=path, component=component):
            steps = tuple(
                Step(s.name, None if s.index is None else with_loop_numbers(s.index, loops))
                for s in path
            )
            inner = None if component is None else with_loop_numbers(component, loops)
            return read(*steps, component=inner)
        case Apply(op=op, args=args):
            return Apply(op, tuple(with_loop_numbers(a, loops) for a in args))
    return e


def as_matrix(found: Flat, rows: int, columns: int | None = None) -> list[list[Expr]]:
    """A scalar or vector as a diagonal matrix."""
    columns = rows if columns is None else columns
    if not isinstance(found, list):
        found = [found] * rows
    if not isinstance(found[0], list):
        return [[found[i] if i == j else ZERO for j in range(columns)] for i in range(rows)]  # type: ignore[misc]
    return found  # type: ignore[return-value]


def inverse(m: list[list[Expr]]) -> list[list[Expr]]:
    numbers = np.array([[evaluate(x, {}, 0.0) for x in row] for row in m])
    return [[Num(Fraction(float(x))) for x in row] for row in np.linalg.inv(numbers)]


def applied(op: str, args: list[Flat]) -> Flat:
    """An operator on scalars, vectors and matrices."""
    if not any(isinstance(a, list) for a in args):
        return Apply(op, tuple(args))  # type: ignore[arg-type]
    if op == "*":
        a, b = args
        if isinstance(a, list) and isinstance(b, list):
            assert isinstance(a[0], list), "product of two vectors"
            if isinstance(b[0], list):
                columns = list(zip(*b, strict=True))
                return [
                    [sum_of([x * y for x, y in zip(r, c, strict=True)]) for c in columns] for r in a
                ]  # type: ignore[union-attr,operator,misc]
            return [sum_of([x * y for x, y in zip(r, b, strict=True)]) for r in a]  # type: ignore[union-attr,operator,misc]
        if isinstance(a, list):
            return [applied(op, [x, b]) for x in a]
        return [applied(op, [a, x]) for x in b]  # type: ignore[union-attr]
    if op in ("+", "-"):
        a, b = args
        return [applied(op, [x, y]) for x, y in zip(a, b, strict=True)]  # type: ignore[arg-type]
    if op == "/":
        return [applied(op, [x, args[1]]) for x in args[0]]  # type: ignore[union-attr]
    return [applied(op, [x]) for x in args[0]]  # type: ignore[union-attr]
