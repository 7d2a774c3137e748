"""Values of nodes with a running bound of their rounding error.

Each operation passes on the errors of its operands, found by moving each operand by its error, and
adds its own rounding. A value within its bound cannot be told from zero.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

from bgc.algebra.evaluate import NodeEvaluator

_EPSILON = sys.float_info.epsilon
_MARGIN = 8  # times the bound, which is of first order


@dataclass(frozen=True, slots=True)
class Rounded:
    """A double, and a bound of its distance from the exact value."""

    value: float
    error: float

    @property
    def is_noise(self) -> bool:
        """True if the exact value may be zero."""
        return abs(self.value) <= _MARGIN * self.error


class RoundedEvaluator(NodeEvaluator[Rounded]):
    """The values of a graph's nodes at one point, each with its error.

    Whole numbers are exact; others carry the rounding error of a double.
    """

    def _from_leaf(self, value: float) -> Rounded:
        return Rounded(value, 0.0 if value.is_integer() else _EPSILON * abs(value))

    def _from_operands(self, op: int, operands: list[Rounded]) -> Rounded:
        values = [x.value for x in operands]
        result = self._apply(op, values)
        error = _EPSILON * abs(result)
        for place, operand in enumerate(operands):
            if operand.error:
                error += max(
                    abs(self._apply(op, [*values[:place], moved, *values[place + 1 :]]) - result)
                    for moved in (operand.value - operand.error, operand.value + operand.error)
                )
        return Rounded(result, error)
