"""Proven ranges of nodes that vary during a run, with ends that are nodes of parameters.

Interval arithmetic on the DAG (Moore 1966): `2 + sin(x)` is in [1, 3] whatever x is, and
`r + a*sin(x)` in [r - |a|, r + |a|]. So a lever's ratio can be proven never to vanish, for all
values of the parameters that keep one end on its side of zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bgc.algebra.dag import Dag, Level, Op

_UNIT = frozenset({Op.SIN, Op.COS, Op.TANH, Op.ERF, Op.SIGN})  # in [-1, 1]
_TRUTH = frozenset({Op.LT, Op.LE, Op.EQ, Op.AND, Op.OR, Op.NOT})  # in [0, 1]
_RISING = frozenset({Op.ATAN, Op.ASINH, Op.SINH, Op.CBRT, Op.EXP, Op.TANH, Op.ERF})


@dataclass(frozen=True, slots=True)
class Range:
    """The ends of a range as nodes of parameters; None where there is none."""

    low: int | None = None
    high: int | None = None


class Ranges:
    """Ranges of the nodes of one DAG, to which the nodes of their ends are added."""

    def __init__(self, dag: Dag) -> None:
        self._dag = dag
        self._known: dict[int, Range] = {}

    def of(self, node: int) -> Range:
        """The range of a node, as narrow as its operands' ranges prove."""
        for part in self._dag.reachable([node]):  # operands come before their results
            if part not in self._known:
                self._known[part] = self._range(part)
        return self._known[node]

    def _range(self, node: int) -> Range:
        dag = self._dag
        if dag.level[node] <= Level.PARAM:
            return Range(node, node)
        op, parts = Op(dag.op[node]), [self._known[x] for x in dag.operands(node)]
        match op, parts:
            case Op.NEG, [a]:
                return self._negative(a)
            case Op.ADD, [a, b]:
                return Range(self._both(dag.add, a.low, b.low), self._both(dag.add, a.high, b.high))
            case Op.SUB, [a, b]:
                return Range(self._both(dag.sub, a.low, b.high), self._both(dag.sub, a.high, b.low))
            case Op.MUL, [a, b]:
                if len(set(dag.operands(node))) == 1:
                    return self._square(a)
                return self._product(a, b)
            case Op.DIV, [a, Range(low=low, high=high)] if low is not None and low == high:
                return self._product(a, Range(*[dag.div(dag.one, low)] * 2))
            case Op.POW, [a, _] if self._is_even(dag.operands(node)[1]):
                return self._square(a, dag.operands(node)[1])
            case Op.SELECT, [_, a, b]:
                return self._hull(a, b)
            case Op.MAX, [a, b]:
                low = self._either(Op.MAX, a.low, b.low)
                return Range(low, self._extreme(Op.MAX, a.high, b.high))
            case Op.MIN, [a, b]:
                high = self._either(Op.MIN, a.high, b.high)
                return Range(self._extreme(Op.MIN, a.low, b.low), high)
            case Op.ABS, [a]:
                return self._magnitude(a)
            case Op.SQRT, [a]:
                low = dag.zero if a.low is None else dag.call(Op.MAX, a.low, dag.zero)
                high = None if a.high is None else dag.call(Op.MAX, a.high, dag.zero)
                return Range(
                    dag.call(Op.SQRT, low), None if high is None else dag.call(Op.SQRT, high)
                )
            case Op.HYPOT, _:
                return Range(dag.zero, None)
            case Op.COSH, _:
                return Range(dag.one, None)
            case _ if op in _UNIT or op in _TRUTH:
                low, high = dag.const(-1) if op in _UNIT else dag.zero, dag.one
                if op in _RISING and parts[0] != Range():
                    (a,) = parts
                    low = low if a.low is None else dag.call(op, a.low)
                    high = high if a.high is None else dag.call(op, a.high)
                return Range(low, high)
            case _ if op in _RISING:
                (a,) = parts
                low = None if a.low is None else dag.call(op, a.low)
                if op is Op.EXP:
                    low = dag.zero if low is None else low
                if op is Op.ATAN and a == Range():
                    return Range(dag.const(-2), dag.const(2))
                return Range(low, None if a.high is None else dag.call(op, a.high))
            case _:
                return Range(dag.zero, None) if op.row.never_negative else Range()

    # --- arithmetic -----------------------------------------------------------------------------

    def _negative(self, a: Range) -> Range:
        dag = self._dag
        return Range(
            None if a.high is None else dag.neg(a.high), None if a.low is None else dag.neg(a.low)
        )

    def _product(self, a: Range, b: Range) -> Range:
        """The product of ranges: of two with all ends, or of one end and a fixed sign."""
        dag = self._dag
        first = [end for end in (a.low, a.high) if end is not None]
        second = [end for end in (b.low, b.high) if end is not None]
        if len(first) == len(second) == 2:
            whole = [dag.mul(x, y) for x in first for y in second]
            low = high = whole[0]
            for other in dict.fromkeys(whole[1:]):
                low, high = dag.call(Op.MIN, low, other), dag.call(Op.MAX, high, other)
            return Range(low, high)
        if self._is_not_negative(a) and self._is_not_negative(b):
            return Range(self._both(dag.mul, a.low, b.low), None)
        return Range()

    def _square(self, a: Range, exponent: int | None = None) -> Range:
        dag = self._dag
        size = self._magnitude(a)

        def power(x: int) -> int:
            return dag.mul(x, x) if exponent is None else dag.pow(x, exponent)

        assert size.low is not None
        return Range(power(size.low), None if size.high is None else power(size.high))

    def _magnitude(self, a: Range) -> Range:
        dag = self._dag
        low, high = dag.zero, None
        for end in (a.low, None if a.high is None else dag.neg(a.high)):
            if end is not None:
                low = dag.call(Op.MAX, low, end)
        if a.low is not None and a.high is not None:
            high = dag.call(Op.MAX, dag.call(Op.ABS, a.low), dag.call(Op.ABS, a.high))
        return Range(low, high)

    def _hull(self, a: Range, b: Range) -> Range:
        return Range(
            self._extreme(Op.MIN, a.low, b.low),
            self._extreme(Op.MAX, a.high, b.high),
        )

    def _both(self, compute: Callable[[int, int], int], a: int | None, b: int | None) -> int | None:
        return None if a is None or b is None else compute(a, b)

    def _extreme(self, op: Op, a: int | None, b: int | None) -> int | None:
        return None if a is None or b is None else self._dag.call(op, a, b)

    def _either(self, op: Op, a: int | None, b: int | None) -> int | None:
        return b if a is None else a if b is None else self._dag.call(op, a, b)

    def _is_even(self, exponent: int) -> bool:
        value = self._dag.value(exponent)
        return value is not None and value.denominator == 1 and value > 0 and value % 2 == 0

    def _is_not_negative(self, a: Range) -> bool:
        """Return whether the lower end is never negative, by its form."""
        if a.low is None:
            return False
        dag, value = self._dag, self._dag.value(a.low)
        if value is not None:
            return value >= 0
        return dag.op[a.low] == Op.MAX and dag.zero in dag.operands(a.low)
