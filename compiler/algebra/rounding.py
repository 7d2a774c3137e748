"""Values of nodes with a running bound of their rounding error.

Each operation passes on the errors of its operands, found by moving each operand by its error, and
adds its own rounding. A value within its bound cannot be told from zero.
"""

from __future__ import annotations

import sys
from math import isqrt
from operator import mul

from bgc.algebra.double_inverse import inverse_in_doubles
from bgc.algebra.evaluate import NodeEvaluator
from bgc.record_class import dataclass

_EPSILON = sys.float_info.epsilon
_MARGIN = 8  # times the bound, which is of first order


@dataclass(frozen=True, slots=True)
class Rounded:
    """A double, and a bound of its distance from the exact value."""

    value: float
    error: float

    @property
    def limits(self) -> tuple[float, float]:
        """Two numbers between which the exact value lies."""
        margin = _MARGIN * self.error
        return self.value - margin, self.value + margin

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

    def _inverted(self, entries: list[Rounded]) -> list[Rounded]:
        """Errors E of A change its inverse X by X E X; rounding is like an E of n eps A."""
        found = inverse_in_doubles([x.value for x in entries])
        size = isqrt(len(entries))
        moved = [x.error + size * _EPSILON * abs(x.value) for x in entries]
        sizes = list(map(abs, found))
        errors = _product(_product(sizes, moved, size), sizes, size)
        return [Rounded(x, error) for x, error in zip(found, errors, strict=True)]


def _product(left: list[float], right: list[float], size: int) -> list[float]:
    """The product of two square matrices, row by row."""
    columns = [right[j::size] for j in range(size)]
    rows = [left[size * i : size * (i + 1)] for i in range(size)]
    return [sum(map(mul, row, column)) for row in rows for column in columns]
