"""Derivatives by elimination of vertices from the graph of partial derivatives.

Every edge of the graph carries the derivative of a node by one of its operands. A node between
is taken out by multiplying its edges in with its edges out; what is left in the end leads from
symbols to outputs and is the Jacobian. Taking nodes out from the symbols on is forward
differentiation, from the outputs on reverse differentiation; taken out first here is always the
node with the fewest products (Markowitz 1957; Griewank and Reese 1991), of equals the last one.
On chains of rigid joints that takes a third less than either.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.derivatives import CHOICES, choice, partials
from bgc.ir.graph import Node

TIME = -1  # the column of df/dt

Row = dict[int, Node]  # column -> derivative, zeros left out
_Edges = dict[int, Node]  # vertex -> derivative


def by_state_and_time(symbol: Symbol) -> int | None:
    """The column of a symbol's derivatives, None where it is held constant."""
    match symbol.kind:
        case Kind.STATE:
            return symbol.index
        case Kind.TIME:
            return TIME
        case _:
            return None


def eliminated_rows(dag: Dag, outputs: Sequence[Node], budget: int) -> list[Row] | None:
    """The derivatives of each output by states and time; None beyond `budget` nodes."""
    graph = _Graph(dag, outputs)
    return graph.rows() if graph.eliminate(budget) else None


class _Graph:
    """The graph while nodes are taken out of it.

    Vertices are nodes and, with numbers below zero, sinks: one for every output, and two for
    every choice. Of a choice only what is chosen may count, also where the derivative of the
    other is no number, so its two operands are differentiated by the symbols to the end, as
    outputs are, before one of the two derivatives is chosen.
    """

    def __init__(self, dag: Dag, outputs: Sequence[Node]) -> None:
        self._dag = dag
        self._outputs = outputs
        self._column: dict[Node, int] = {}  # of the symbols
        self._into: dict[int, _Edges] = {}
        self._out_of: dict[int, _Edges] = {}
        self._choice_of: dict[int, Node] = {}  # of the sinks of choices
        self._sinks: dict[Node, tuple[int, int]] = {}  # of the choices, in the order of operands
        self._queue: list[tuple[int, int]] = []
        self._number = 0
        for node in dag.reachable(outputs):
            self._add(node)
        self._of_output = [self._sink(output) for output in outputs]

    def _add(self, node: Node) -> None:
        """Adds a node if it depends on a symbol that counts."""
        dag = self._dag
        if (symbol := dag.symbol_of(node)) is not None:
            column = by_state_and_time(symbol)
            if column is not None:
                self._column[node] = column
                self._out_of[node] = {}
            return
        if self._out_of.keys().isdisjoint(dag.operands(node)):
            return
        edges: _Edges = {}
        self._into[node], self._out_of[node] = edges, {}
        if dag.op[node] in CHOICES:
            _, yes, no = choice(dag, node)
            self._sinks[node] = sinks = (self._sink(yes), self._sink(no))
            self._choice_of.update(dict.fromkeys(sinks, node))
            return
        for operand, partial in partials(dag, node):
            if operand in self._out_of and partial != dag.zero:
                edges[operand] = dag.add(edges.get(operand, dag.zero), partial)
        for operand, partial in edges.items():
            self._out_of[operand][node] = partial

    def _sink(self, node: Node) -> int:
        """A new sink, which is the node."""
        self._number -= 1
        self._into[self._number] = {}
        if node in self._out_of:
            self._into[self._number][node] = self._dag.one
            self._out_of[node][self._number] = self._dag.one
        return self._number

    def rows(self) -> list[Row]:
        """What leads from the symbols to the outputs."""
        column = self._column
        return [
            {column[symbol]: edge for symbol, edge in self._into[sink].items()}
            for sink in self._of_output
        ]

    def eliminate(self, budget: int) -> bool:
        """Takes all nodes out but the symbols; False if that makes more nodes than `budget`."""
        for node in list(self._sinks):
            self._choose(node)
        queue, into, out_of = self._queue, self._into, self._out_of
        queue += [(self._cost(v), -v) for v in into if v >= 0 and v not in self._sinks]
        heapify(queue)
        while queue:
            cost, place = heappop(queue)
            vertex = -place
            if vertex not in into:
                continue
            present = len(into[vertex]) * len(out_of[vertex])
            if cost != present:
                heappush(queue, (present, place))
                continue
            self._take_out(vertex)
            if len(self._dag) > budget:
                return False
        return True

    def _cost(self, vertex: int) -> int:
        """The number of products that it takes to take a vertex out."""
        return len(self._into[vertex]) * len(self._out_of[vertex])

    def _take_out(self, vertex: int) -> None:
        dag, into, out_of = self._dag, self._into, self._out_of
        before, behind = into.pop(vertex), out_of.pop(vertex)
        for source in before:
            del out_of[source][vertex]
        for target in behind:
            del into[target][vertex]
        for target, outer in behind.items():
            edges = into[target]
            for source, inner in before.items():
                edge = dag.mul(inner, outer)
                if source in edges:
                    edge = dag.add(edges[source], edge)
                if edge != dag.zero:
                    edges[source] = out_of[source][target] = edge
                elif source in edges:
                    del edges[source], out_of[source][target]
        for other in (*before, *behind):
            if other in self._choice_of:
                self._choose(self._choice_of[other])
            elif other >= 0 and other in into and other not in self._sinks:
                heappush(self._queue, (self._cost(other), -other))

    def _choose(self, node: Node) -> None:
        """Makes an ordinary vertex of a choice whose operands are differentiated by now."""
        if node not in self._sinks:
            return
        of_yes, of_no = (self._into[sink] for sink in self._sinks[node])
        if not self._column.keys() >= of_yes.keys() | of_no.keys():
            return
        dag, zero = self._dag, self._dag.zero
        condition, _, _ = choice(dag, node)
        edges = self._into[node]
        for symbol in {**of_yes, **of_no}:
            edge = dag.select(condition, of_yes.get(symbol, zero), of_no.get(symbol, zero))
            if edge != zero:
                edges[symbol] = self._out_of[symbol][node] = edge
        for sink in self._sinks.pop(node):
            for symbol in self._into.pop(sink):
                del self._out_of[symbol][sink]
        heappush(self._queue, (self._cost(node), -node))
