"""Numbers for nodes: double arithmetic over the DAG, with C's results at the edges."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Generic, TypeVar

from bgc.algebra.dag import TABLE_OPS, Dag, Op, Symbol
from bgc.algebra.double_inverse import inverse_in_doubles
from bgc.algebra.nodes import Node
from bgc.algebra.operations import ROWS
from bgc.algebra.table import Grid, base_of, orders_of

_Number = TypeVar("_Number")


def evaluate_nodes(
    dag: Dag, roots: Iterable[Node], leaf_values: Mapping[Symbol, float]
) -> list[float]:
    """Evaluate nodes for given values of the symbols they need.

    Takes time linear in the number of nodes reached. Nothing raises at the edges of arithmetic:
    as in C, `1/0` is infinite and `log(-1)` is NaN.

    Raises
    ------
    KeyError
        A symbol that the roots need has no value.
    """
    return Evaluator(dag, leaf_values.__getitem__).values(roots)


class NodeEvaluator(ABC, Generic[_Number]):
    """Base of evaluators at one point: each node is computed at most once.

    `leaf` gives the value of a symbol; it is called once for each.
    """

    def __init__(self, dag: Dag, leaf: Callable[[Symbol], float]) -> None:
        self._dag = dag
        self._leaf = leaf
        self._known: dict[Node, _Number] = {}
        self._inverses: dict[Node, list[_Number]] = {}  # by the end of the list of the matrix

    def value(self, node: Node) -> _Number:
        """The value of a node."""
        if node not in self._known:
            self.values([node])
        return self._known[node]

    def values(self, roots: Iterable[Node]) -> list[_Number]:
        """The values of several nodes."""
        dag, known, roots = self._dag, self._known, list(roots)
        for node in self._missing(roots):
            exact, symbol = dag.value(node), dag.symbol_of(node)
            if exact is not None:
                known[node] = self._from_leaf(to_double(exact))
            elif symbol is not None:
                known[node] = self._from_leaf(self._leaf(symbol))
            elif dag.op[node] == Op.LISTED:
                known[node] = self._from_leaf(math.nan)  # read by nobody
            elif dag.op[node] == Op.INVERTED:
                known[node] = self._inverse(dag.a[node])[dag.place_in_inverse(node)]
            else:
                known[node] = self._from_operands(
                    dag.op[node], [known[x] for x in dag.operands(node)]
                )
        return [known[root] for root in roots]

    def _inverse(self, listed: Node) -> list[_Number]:
        """The inverse of a matrix whose entries are known, row by row."""
        if listed not in self._inverses:
            entries = [self._known[x] for x in self._dag.listed(listed)]
            self._inverses[listed] = self._inverted(entries)
        return self._inverses[listed]

    def _apply(self, op: int, operands: list[float]) -> float:
        """One operation on doubles, or a look-up in a table of the graph."""
        if op not in TABLE_OPS:
            return ROWS[op].evaluate(*operands)
        number = int(operands[0])
        table, orders = self._dag.tables[base_of(number)], orders_of(number)
        if isinstance(table, Grid):
            return table.value(orders, *operands[1:])
        match op:
            case Op.PLACE:
                return table.place(operands[1])
            case Op.PIECE:
                return table.piece(orders[0], *operands[1:])
            case _:
                return table.value(orders[0], operands[1])

    def _missing(self, roots: Iterable[Node]) -> list[Node]:
        """The nodes that the roots need and that are not known yet, in topological order."""
        dag, known = self._dag, self._known
        seen = {root for root in roots if root not in known}
        stack = list(seen)
        while stack:
            for operand in dag.operands(stack.pop()):
                if operand not in known and operand not in seen:
                    seen.add(operand)
                    stack.append(operand)
        return sorted(seen)

    @abstractmethod
    def _from_leaf(self, value: float) -> _Number:
        """The number of a symbol with this value."""

    @abstractmethod
    def _from_operands(self, op: int, operands: list[_Number]) -> _Number:
        """The number of an operation, given those of its operands."""

    @abstractmethod
    def _inverted(self, entries: list[_Number]) -> list[_Number]:
        """The inverse of a square matrix, given and returned row by row."""


class Evaluator(NodeEvaluator[float]):
    """The values of a graph's nodes at one point, as doubles."""

    def _from_leaf(self, value: float) -> float:
        return value

    def _from_operands(self, op: int, operands: list[float]) -> float:
        return self._apply(op, operands)

    def _inverted(self, entries: list[float]) -> list[float]:
        return inverse_in_doubles(entries)


def to_double(exact: Fraction) -> float:
    """The nearest double, infinite beyond the largest."""
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def apply(op: int, *operands: float) -> float:
    """One operation on doubles, with C's results."""
    return ROWS[op].evaluate(*operands)
