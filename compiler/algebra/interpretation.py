"""Proven intervals of nodes, whose ends are numbers or nodes of parameters.

`2 + sin(x)` is in [1, 3] whatever x is, and `r + a*sin(x)` in [min(r - a, r + a), max(..)]. So a
lever's ratio can be proven never to vanish, for all values of the parameters that keep one end on
its side of zero. A failure to prove says nothing.
"""

from __future__ import annotations

import math
import operator
import sys
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Generic, TypeVar

from bgc.algebra import doubles
from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.evaluate import apply, to_double
from bgc.algebra.fold import Fold
from bgc.algebra.intervals import Ends, Interval, numbers_of, within
from bgc.algebra.nodes import Node
from bgc.algebra.operation import Lanes
from bgc.algebra.operations import ROWS

_FACTORS = 50  # of a product, at most, that are compared with each other
_ERROR = 4 * sys.float_info.epsilon  # of the C library's functions, relative to the result
_LIBRARY = frozenset(
    op for op in Op if op is Op.POW or op.row.lanes in {Lanes.LIBMVEC, Lanes.LIBMVEC_2_35}
)

_PRODUCTS = frozenset(map(int, (Op.MUL, Op.DIV)))

End = TypeVar("End")


def _with_errors(op: int, found: Interval[float]) -> Interval[float]:
    """An interval with the errors of the C library, without ends that are not finite."""
    error = _ERROR if op in _LIBRARY else 0.0
    low = None if found.low is None else found.low - error * abs(found.low)
    high = None if found.high is None else found.high + error * abs(found.high)
    return Interval(
        low if low is not None and math.isfinite(low) else None,
        high if high is not None and math.isfinite(high) else None,
    )


_DOUBLES = Ends(
    const=to_double,
    add=operator.add,
    mul=operator.mul,
    div=doubles.divide,
    neg=operator.neg,
    least=min,
    greatest=max,
    call=apply,
    outwards=_with_errors,
    numbers=lambda end: (end, end),
)


def _nodes(dag: Dag) -> Ends[Node]:
    """Ends that are nodes of parameters, between the numbers that hold for all parameters."""
    return Ends(
        const=dag.const,
        add=dag.add,
        mul=dag.mul,
        div=dag.div,
        neg=dag.neg,
        least=partial(dag.call, Op.MIN),
        greatest=partial(dag.call, Op.MAX),
        call=lambda op, *operands: dag.apply(op, operands),
        outwards=lambda op, found: found,
        numbers=Intervals(dag).limits,
    )


class _Interpretation(Fold[Interval[End]], Generic[End]):
    """The intervals of a graph's nodes with ends of one kind.

    `leaf` gives what is known of a node without its operands, None where they have to tell.
    """

    def __init__(
        self, dag: Dag, ends: Ends[End], leaf: Callable[[Node], Interval[End] | None]
    ) -> None:
        super().__init__(dag)
        self._ends, self._leaf = ends, leaf

    def _of(self, node: Node) -> Interval[End]:
        dag, ends, known = self._dag, self._ends, self._known
        found = self._leaf(node)
        if found is not None:
            return found
        op, operands = dag.op[node], dag.operands(node)
        row = ROWS[op]
        parts = [within(ends, known[x], row.domain) for x in operands]
        found = ends.outwards(op, row.bounds.rule(ends, partial(ends.call, op), *parts))
        if op in _PRODUCTS:
            return self._of_one_sign(node, found)
        return within(ends, found, row.image)

    def _of_one_sign(self, node: Node, found: Interval[End]) -> Interval[End]:
        """The interval of a product, with its sign where factors of unknown sign stand in pairs."""
        counts = self._factors(node)
        if len(counts) == counts.total():
            return found
        sign = 1
        for factor in (factor for factor, count in counts.items() if count % 2):
            least, most = numbers_of(self._ends, self._known[factor])
            sign *= 1 if least >= 0 else -1 if most <= 0 else 0
        if sign == 0:
            return found
        return within(self._ends, found, (0, None) if sign > 0 else (None, 0))

    def _factors(self, node: Node) -> Counter[Node]:
        """Count each factor of a product; divisors count as factors."""
        dag, stack, found = self._dag, [node], Counter[Node]()
        while stack and len(stack) < _FACTORS:
            top = stack.pop()
            if dag.op[top] in _PRODUCTS:
                stack.extend(dag.operands(top))
            else:
                found[top] += 1
        found.update(stack)
        return found


class Intervals(_Interpretation[float]):
    """Intervals with doubles as ends; of a symbol nothing is known but by `leaf`.

    Parameters
    ----------
    leaf
        Limits of the values of a node, or None where its operands have to tell.
    """

    def __init__(
        self, dag: Dag, leaf: Callable[[Node], tuple[float, float] | None] = lambda node: None
    ) -> None:
        def known(node: Node) -> Interval[float] | None:
            limits, exact = leaf(node), dag.value(node)
            if limits is None and exact is not None:
                limits = (to_double(exact),) * 2
            if limits is None:
                return Interval() if dag.op[node] == Op.SYMBOL else None
            return _with_errors(Op.SYMBOL, Interval(*limits))

        super().__init__(dag, _DOUBLES, known)

    def limits(self, node: Node) -> tuple[float, float]:
        """The least and the largest value of a node; infinite where none is proven."""
        return numbers_of(self._ends, self.value(node))

    def sign(self, node: Node) -> int:
        """1 for a node never negative, -1 for one never positive, 0 if neither is proven."""
        least, most = self.limits(node)
        return 1 if least >= 0 else -1 if most <= 0 else 0

    def excludes_zero(self, node: Node) -> bool:
        """Test whether the absolute value of a node is proven to stay above a positive number."""
        least, most = self.limits(node)
        return least > 0 or most < 0


class NodeIntervals(_Interpretation[Node]):
    """Intervals with nodes of parameters as ends, which are added to the graph."""

    def __init__(self, dag: Dag) -> None:
        def known(node: Node) -> Interval[Node] | None:
            if dag.level[node] <= Level.PARAM:
                return Interval(node, node)
            return Interval() if dag.op[node] == Op.SYMBOL else None

        super().__init__(dag, _nodes(dag), known)
