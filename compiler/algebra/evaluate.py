"""Numbers for nodes: double arithmetic over the DAG, with C's results at the edges."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import TypeVar

from bgc.algebra.dag import TABLE_OPS, Dag, Level, Op, Symbol
from bgc.algebra.double_inverse import inverse_in_doubles
from bgc.algebra.fold import Fold
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


class NodeEvaluator(Fold[_Number]):
    """Base of evaluators at one point.

    `leaf` gives the value of a symbol; it is called once for each.
    """

    def __init__(self, dag: Dag, leaf: Callable[[Symbol], float]) -> None:
        super().__init__(dag)
        self._leaf = leaf
        self._inverses: dict[Node, list[_Number]] = {}  # by the end of the list of the matrix

    def _of(self, node: Node) -> _Number:
        dag, known = self._dag, self._known
        exact, symbol = dag.value(node), dag.symbol_of(node)
        if exact is not None:
            return self._from_leaf(to_double(exact))
        if symbol is not None:
            return self._from_leaf(self._leaf(symbol))
        if dag.op[node] == Op.LISTED:
            return self._from_leaf(math.nan)  # read by nobody
        if dag.op[node] == Op.INVERTED:
            return self._inverse(dag.a[node])[dag.place_in_inverse(node)]
        return self._from_operands(dag.op[node], [known[x] for x in dag.operands(node)])

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


class Repeated(Evaluator):
    """The values of some nodes at one point after another: their order is found once."""

    def __init__(self, dag: Dag, roots: Iterable[Node]) -> None:
        super().__init__(dag, dict[Symbol, float]().__getitem__)
        self._roots = list(roots)
        order = dag.reachable(self._roots)
        self.values(node for node in order if dag.level[node] == Level.CONST)
        self._constants = self._known
        self._steps = [
            (node, self._function(dag.op[node]), dag.operands(node))
            for node in order
            if node not in self._constants
        ]

    def _function(self, op: int) -> Callable[..., float] | None:
        """The function of an operation of its operands alone, None of any other."""
        other = op in {Op.SYMBOL, Op.LISTED, Op.INVERTED} or op in TABLE_OPS
        return None if other else ROWS[op].evaluate

    def at(self, leaf_values: Mapping[Symbol, float]) -> list[float]:
        """The values of the roots, as `evaluate_nodes` gives them."""
        known = self._known = dict(self._constants)
        self._leaf = leaf_values.__getitem__
        self._inverses = {}
        for node, function, operands in self._steps:
            known[node] = function(*[known[x] for x in operands]) if function else self._of(node)
        return [known[root] for root in self._roots]


def to_double(exact: Fraction) -> float:
    """The nearest double, infinite beyond the largest."""
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def apply(op: int, *operands: float) -> float:
    """One operation on doubles, with C's results."""
    return ROWS[op].evaluate(*operands)
