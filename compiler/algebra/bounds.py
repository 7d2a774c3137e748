"""Proofs that a node is bounded away from zero for all values of states, time and inputs.

A node is classified by its sign, and by whether its absolute value stays above a positive number:
sums of terms of one sign, products and quotients, squares, and functions without negative values.
Anything else is not classified: a failure to prove says nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from enum import IntEnum
from fractions import Fraction

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.nodes import Node

_FACTORS = 50  # of a product, at most, that are compared with each other


class Bound(IntEnum):
    """A proven range of values."""

    BELOW = -2  # at most a negative number
    NOT_POSITIVE = -1
    UNKNOWN = 0
    NOT_NEGATIVE = 1
    ABOVE = 2  # at least a positive number


class Bounds:
    """Proven ranges of the nodes of a DAG; nodes of parameters have the signs of their defaults."""

    def __init__(self, dag: Dag, default: Callable[[Node], float]) -> None:
        self._dag = dag
        self._default = default
        self._known: dict[Node, Bound] = {}

    def is_bounded_away(self, node: Node) -> bool:
        """Test whether the absolute value of a node is proven to stay above a positive number."""
        known = self._known
        if node not in known:
            for part in self._dag.reachable([node]):  # operands come before their results
                if part not in known:
                    known[part] = self._bound(part)
        return abs(known[node]) == 2

    def _bound(self, node: Node) -> Bound:
        dag, known = self._dag, self._known
        if dag.level[node] <= Level.PARAM:
            value = self._default(node)
            return Bound(2 * ((value > 0) - (value < 0)))
        parts = [known[operand] for operand in dag.operands(node)]
        op = Op(dag.op[node])
        match op, parts:
            case Op.NEG, [a]:
                return Bound(-a)
            case Op.ADD, [a, b]:
                return _sum(a, b)
            case Op.SUB, [a, b]:
                return _sum(a, Bound(-b))
            case Op.DIV, [a, b] if dag.level[dag.operands(node)[1]] > Level.PARAM:
                return _product(a, Bound((b > 0) - (b < 0)))
            case Op.MUL | Op.DIV, _:
                return self._product_of(node)
            case Op.POW, [a, _]:
                exponent = dag.value(dag.operands(node)[1])
                return _power(a, exponent)
            case Op.ABS, [a]:
                return Bound(abs(a) or 1)
            case Op.SQRT, [a]:
                return Bound.ABOVE if a is Bound.ABOVE else Bound.NOT_NEGATIVE
            case Op.SELECT, [_, a, b]:
                return min(a, b, key=abs) if a * b > 0 else Bound.UNKNOWN
            case _:
                return Bound.NOT_NEGATIVE if op.row.never_negative else Bound.UNKNOWN

    def _product_of(self, node: Node) -> Bound:
        """The bound of a product; factors that appear an even number of times are squares.

        A divisor of parameters counts as a factor, of the same sign.
        """
        dag = self._dag
        factors: Counter[Node] = Counter()
        stack = [node]
        while stack and len(stack) < _FACTORS:
            top = stack.pop()
            parts = dag.operands(top)
            fixed = dag.op[top] == Op.DIV and dag.level[parts[1]] <= Level.PARAM
            if dag.op[top] == Op.MUL or fixed:
                stack.extend(parts)
            else:
                factors[top] += 1
        bound = Bound.ABOVE
        for factor, count in (factors + Counter(stack)).items():
            known = self._known[factor]
            bound = _product(bound, known if count % 2 else Bound(abs(known) or 1))
        return bound


def _sum(a: Bound, b: Bound) -> Bound:
    """The bound of a sum: only terms of one sign have one."""
    return max(a, b, key=abs) if a * b > 0 else Bound.UNKNOWN


def _product(a: Bound, b: Bound) -> Bound:
    """The bound of a product: away from zero if both factors are."""
    sign = (a * b > 0) - (a * b < 0)
    return Bound(sign * min(abs(a), abs(b)))


def _power(base: Bound, exponent: Fraction | None) -> Bound:
    """The bound of a power with a constant positive exponent."""
    if exponent is None or exponent <= 0:
        return Bound.UNKNOWN
    if exponent.denominator == 1 and exponent % 2 == 0:
        return Bound(abs(base) or 1)
    return base if base > 0 else Bound.UNKNOWN
