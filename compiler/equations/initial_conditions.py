"""Conditions that given initial values put on what is stored, each linear.

They are inserted one at a time: one that already follows from those before must agree with them,
or it is named as the culprit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from bgc.algebra.solving import SingularSystemError, solve_general
from bgc.equations.storage import StorageElement
from bgc.equations.variables import Variables
from bgc.grammar.catalogue import causality as catalogue
from bgc.grammar.diagnostics import BgError
from bgc.graph import Initial, Node

Row: TypeAlias = dict[int, Node]
NEGLIGIBLE = 1e-9  # of a condition's coefficients, or of its value


@dataclass(frozen=True, slots=True)
class Condition:
    """`sum row * unknown = value`, from an initial value of an element."""

    row: Row
    value: Node
    element: StorageElement
    initial: Initial | None  # None of a value that nothing was said about


def independent_conditions(
    variables: Variables,
    conditions: Sequence[Condition],
    balances: Sequence[tuple[Row, Node]] = (),
) -> list[Condition]:
    """Insert conditions one at a time; one that follows from others has to agree.

    Both are judged in numbers, at the start and the parameters' default values. The balances,
    as rows and right-hand sides, hold in any case and come first.
    """
    if not conditions:
        return []
    equations = [*balances, *((c.row, c.value) for c in conditions)]
    columns = sorted({j for row, _ in equations for j in row})
    width = len(columns) + 1
    nodes = [
        node
        for row, value in equations
        for node in (*(row.get(j, variables.dag.zero) for j in columns), value)
    ]
    values = variables.at_start(nodes)
    if values is None or not all(map(math.isfinite, values)):
        raise unusable(conditions[0])
    reduced: list[tuple[int, list[float]]] = []  # pivot, row with its value
    chosen: list[Condition] = []
    for k in range(len(equations)):
        condition = conditions[k - len(balances)] if k >= len(balances) else None
        row = values[k * width : (k + 1) * width]
        size = max(map(abs, row[:-1]), default=0.0)
        for pivot, other in reduced:
            factor = row[pivot] / other[pivot]
            row = [x - factor * y for x, y in zip(row, other, strict=True)]
        pivot = max(range(width - 1), key=lambda j: abs(row[j]), default=-1)
        if pivot >= 0 and abs(row[pivot]) > NEGLIGIBLE * size:
            reduced.append((pivot, row))
            if condition is not None:
                chosen.append(condition)
        elif condition is not None and abs(row[-1]) > NEGLIGIBLE * max(
            1.0, abs(values[(k + 1) * width - 1])
        ):
            raise contradiction(condition, chosen)
    return chosen


def contradiction(condition: Condition, others: Sequence[Condition]) -> BgError:
    """The error for a value that does not agree with others."""
    names = list(dict.fromkeys(other.element.storage.name for other in others))
    assert condition.initial is not None, "what nothing was said about contradicts nothing"
    variable, span = f"{condition.initial.variable}0", condition.initial.span
    name = condition.element.storage.name
    return BgError([catalogue.initial_conflict(span, name, variable, names)])


def solve_conditions(
    variables: Variables, matrix: Sequence[Row], right: Sequence[Node]
) -> list[Node]:
    """The unknowns of as many conditions, which are independent."""
    dag = variables.dag
    try:
        return solve_general(
            dag, variables.causal.fingerprints, matrix, right, lambda node: dag.level[node]
        )
    except SingularSystemError:
        raise AssertionError("conditions that were inserted one by one are dependent") from None


def unusable(condition: Condition) -> BgError:
    """The error for a value that the state cannot be found from."""
    initial, name = condition.initial, condition.element.storage.name
    assert initial is not None, "values that are given come first"
    return BgError([catalogue.initial_unusable(initial.span, name, f"{initial.variable}0")])
