"""Numbers for nodes: plain double arithmetic over the DAG, with C's results at the edges."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction

from bgc.algebra.dag import Dag, Symbol
from bgc.algebra.operations import ROWS


def evaluate_nodes(
    dag: Dag, roots: Iterable[int], leaf_values: Mapping[Symbol, float]
) -> list[float]:
    """The values of the roots for given values of the symbols they need.

    Time is linear in the number of nodes reached. Nothing raises at the edges of arithmetic:
    as in C, `1/0` is infinite and `log(-1)` is not a number.

    Raises
    ------
    KeyError
        A symbol that the roots need has no value.
    """
    roots = list(roots)
    done: dict[int, float] = {}
    for node in dag.reachable(roots):
        exact, symbol = dag.value(node), dag.symbol_of(node)
        if exact is not None:
            done[node] = to_double(exact)
        elif symbol is not None:
            done[node] = leaf_values[symbol]
        else:
            done[node] = apply(dag.op[node], *(done[x] for x in dag.operands(node)))
    return [done[root] for root in roots]


class Evaluator:
    """The values of a graph's nodes at one point, each node visited once however often asked.

    `leaf` gives the value of a symbol; it is asked once for each.
    """

    def __init__(self, dag: Dag, leaf: Callable[[Symbol], float]) -> None:
        self._dag = dag
        self._leaf = leaf
        self._known: dict[int, float] = {}

    def value(self, node: int) -> float:
        """The value of a node."""
        known, dag = self._known, self._dag
        stack = [node]
        while stack:
            top = stack[-1]
            missing = [x for x in dag.operands(top) if x not in known] if top not in known else ()
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            if top not in known:
                known[top] = self._made(top)
        return known[node]

    def _made(self, node: int) -> float:
        dag = self._dag
        exact, symbol = dag.value(node), dag.symbol_of(node)
        if exact is not None:
            return to_double(exact)
        if symbol is not None:
            return self._leaf(symbol)
        return apply(dag.op[node], *(self._known[x] for x in dag.operands(node)))


def to_double(exact: Fraction) -> float:
    """The nearest double, infinite beyond the largest."""
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def apply(op: int, *operands: float) -> float:
    """One operation on doubles, with C's results."""
    return ROWS[op].evaluate(*operands)
