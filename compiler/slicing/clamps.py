"""Minima and maxima with zero that are certain for all admissible values of the parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.interpretation import Intervals
from bgc.ir.graph import Node, Parameter


class Clamps:
    """Folds clamps, by the intervals of nodes that follow from the ranges of the parameters."""

    def __init__(self, dag: Dag, parameters: Sequence[Parameter]) -> None:
        self._dag = dag
        self._parameters = parameters
        self._intervals = Intervals(dag, self._range)

    def folded(self, node: Node) -> Node:
        """The operand that a minimum or maximum with zero always equals; other nodes unchanged."""
        dag = self._dag
        if dag.op[node] not in {Op.MIN, Op.MAX} or dag.zero not in dag.operands(node):
            return node
        (other,) = (x for x in dag.operands(node) if x != dag.zero)
        sign = self._intervals.sign(other)
        if sign == 0:
            return node
        return other if (sign > 0) == (dag.op[node] == Op.MAX) else dag.zero

    def _range(self, node: Node) -> tuple[float, float] | None:
        """The range of a parameter."""
        symbol = self._dag.symbol_of(node)
        if symbol is None or symbol.kind is not Kind.PARAM:
            return None
        parameter = self._parameters[symbol.index]
        low = -math.inf if parameter.low is None else parameter.low
        return low, math.inf if parameter.high is None else parameter.high
