"""What rounding may have made of a number: values with a running bound of their error.

Each operation passes on what its operands may be wrong by, found by moving them by as much, and
adds its own rounding. A value within its bound is zero for all that can be told.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

from bgc.algebra.dag import Dag, Symbol
from bgc.algebra.evaluate import apply, to_double

_EPSILON = sys.float_info.epsilon
_MARGIN = 8  # times the bound, which is of first order


@dataclass(frozen=True, slots=True)
class Rounded:
    """A double, and a bound of its distance from what it stands for."""

    value: float
    error: float

    @property
    def is_noise(self) -> bool:
        """Whether it may be zero but for rounding."""
        return abs(self.value) <= _MARGIN * self.error


class RoundedEvaluator:
    """The values of a graph's nodes at one point, each with its error; each is visited once.

    `leaf` gives the value of a symbol. Whole numbers are exact, others as wrong as a double.
    """

    def __init__(self, dag: Dag, leaf: Callable[[Symbol], float]) -> None:
        self._dag = dag
        self._leaf = leaf
        self._known: dict[int, Rounded] = {}

    def value(self, node: int) -> Rounded:
        """The value of a node and its error."""
        for other in self._missing(node):
            self._known[other] = self._made(other)
        return self._known[node]

    def _missing(self, node: int) -> list[int]:
        """What a node needs and is not known yet, in topological order."""
        dag, known = self._dag, self._known
        seen, stack = set[int](), [node]
        while stack:
            top = stack.pop()
            if top not in known and top not in seen:
                seen.add(top)
                stack.extend(dag.operands(top))
        return sorted(seen)

    def _made(self, node: int) -> Rounded:
        dag = self._dag
        exact, symbol = dag.value(node), dag.symbol_of(node)
        if exact is not None:
            return _rounded(to_double(exact))
        if symbol is not None:
            return _rounded(self._leaf(symbol))
        op, operands = dag.op[node], [self._known[x] for x in dag.operands(node)]
        values = [x.value for x in operands]
        result = apply(op, *values)
        error = _EPSILON * abs(result)
        for place, operand in enumerate(operands):
            if operand.error:
                error += max(
                    abs(apply(op, *values[:place], moved, *values[place + 1 :]) - result)
                    for moved in (operand.value - operand.error, operand.value + operand.error)
                )
        return Rounded(result, error)


def _rounded(value: float) -> Rounded:
    return Rounded(value, 0.0 if value.is_integer() else _EPSILON * abs(value))
