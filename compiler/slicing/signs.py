"""Signs of expressions that hold for all admissible values of the parameters."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.operations import ROWS
from bgc.ir.graph import Node, Parameter

_DEPTH = 16  # of an expression that is looked into


class Signs:
    """Signs of nodes, derived from the ranges of the parameters."""

    def __init__(self, dag: Dag, parameters: Sequence[Parameter]) -> None:
        self._dag = dag
        self._parameters = parameters

    def of(self, node: Node, depth: int = _DEPTH) -> int | None:
        """+1 for a node that is never negative, -1 for one never positive, None if not proven."""
        dag = self._dag
        op = dag.op[node]
        value = dag.value(node)
        if value is not None:
            return 1 if value >= 0 else -1
        if op == Op.SYMBOL:
            return self._of_symbol(node)
        if ROWS[op].never_negative:
            return 1
        if depth == 0 or dag.level[node] > Level.PARAM:
            return None
        signs = [self.of(x, depth - 1) for x in dag.operands(node)]
        match op, signs:
            case (Op.NEG, [int() as sign]):
                return -sign
            case (Op.MUL | Op.DIV, [int() as left, int() as right]):
                return left * right
            case (Op.ADD | Op.MIN | Op.MAX, [int() as left, right]) if left == right:
                return left
            case (Op.SUB, [int() as left, int() as right]) if left != right:
                return left
            case _:
                return None

    def clamped(self, node: Node) -> Node:
        """The operand that a minimum or maximum with zero always equals; other nodes unchanged."""
        dag = self._dag
        if dag.op[node] not in {Op.MIN, Op.MAX} or dag.zero not in dag.operands(node):
            return node
        (other,) = (x for x in dag.operands(node) if x != dag.zero)
        sign = self.of(other)
        if sign is None:
            return node
        return other if (sign > 0) == (dag.op[node] == Op.MAX) else dag.zero

    def _of_symbol(self, node: Node) -> int | None:
        symbol = self._dag.symbol_of(node)
        if symbol is None or symbol.kind is not Kind.PARAM:
            return None
        parameter = self._parameters[symbol.index]
        if parameter.low is not None and parameter.low >= 0:
            return 1
        if parameter.high is not None and parameter.high <= 0:
            return -1
        return None
