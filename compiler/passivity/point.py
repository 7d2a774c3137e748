"""The point at which laws are checked: parameters at their values, states at the start."""

from __future__ import annotations

import random
from collections import ChainMap
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from bgc.algebra.dag import Dag, Kind, Level, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.ir.defaults import default_values
from bgc.ir.graph import FlatGraph, Matrix, Node, Storage

_RANDOM_STATES = 3


class StartPoint:
    """Numbers of the symbols of a flat graph at the start of a run.

    Parameters have the values the model gives them, devices are at rest, the time is 0, a
    storage element without a given `q0` or `p0` is empty. Variables that only the equations
    determine (efforts, flows, unknowns, charges given by an effort) have no number here.
    """

    def __init__(self, graph: FlatGraph) -> None:
        self._graph = graph

    @cached_property
    def dag(self) -> Dag:
        """A copy of the graph's DAG, for derivatives; later passes own the original."""
        return self._graph.dag.copy()

    @cached_property
    def values(self) -> dict[Symbol, float]:
        """The symbols that have a number."""
        graph = self._graph
        found = dict(default_values(graph.dag, graph.parameters))
        found[Symbol(Kind.TIME, 0)] = 0.0
        for device in graph.devices:
            for k in range(len(device.inputs)):
                found[Symbol(Kind.INPUT, device.first_input + k)] = 0.0
        found.update((Symbol(Kind.INPUT, held.index), 0.0) for held in graph.held)
        starts = {Symbol(Kind.STATE, state.index): state.initial for state in graph.states}
        for element in graph.elements:
            if isinstance(element, Storage):
                starts |= _starts_of(graph.dag, element)
        unknown = _unknown(graph.dag, list(starts.values()), found)
        known = [symbol for symbol, node in starts.items() if node not in unknown]
        numbers = evaluate_nodes(graph.dag, [starts[symbol] for symbol in known], found)
        return found | dict(zip(known, numbers, strict=True))

    def numbers(
        self, nodes: Sequence[Node], at: dict[Symbol, float] | None = None
    ) -> list[float] | None:
        """The nodes at the start, with other values of the symbols in `at`.

        None when a symbol has no number.
        """
        values: Mapping[Symbol, float] = ChainMap(at, self.values) if at else self.values
        if not _unknown(self.dag, nodes, values).isdisjoint(nodes):
            return None
        return evaluate_nodes(self.dag, nodes, values)

    def matrix(
        self, matrix: Matrix, at: dict[Symbol, float] | None = None
    ) -> list[list[float]] | None:
        """The same for the entries of a square matrix."""
        flat = self.numbers([node for row in matrix for node in row], at)
        if flat is None:
            return None
        size = len(matrix)
        return [flat[k * size : (k + 1) * size] for k in range(size)]

    def states_near(self, symbols: Sequence[Symbol]) -> list[dict[Symbol, float]]:
        """The start, and a few random values of these symbols about it, within one SI unit."""
        rng = random.Random(len(symbols))
        moved = [
            {s: self.values.get(s, 0.0) + rng.uniform(-1, 1) for s in symbols}
            for _ in range(_RANDOM_STATES)
        ]
        return [{}, *moved]

    def phrase(self, nodes: Iterable[Node]) -> str:
        """Name the point that a number depends on: the parameters' values, the start or none."""
        level = max(self.dag.level[node] for node in nodes)
        if level == Level.CONST:
            return ""
        return " at the parameters' values" if level == Level.PARAM else " at the start"


def _starts_of(dag: Dag, element: Storage) -> dict[Symbol, Node]:
    """The displacements and momenta of an element: as given, else none; not those by e0 or f0."""
    given = {(start.port, start.variable): start.value for start in element.initial}
    found: dict[Symbol, Node] = {}
    for k in range(len(element.ports)):
        index = element.first_state + k
        if element.kind != "I" and (k, "e") not in given:
            found[Symbol(Kind.DISPLACEMENT, index)] = given.get((k, "q"), dag.zero)
        if element.kind != "C" and (k, "f") not in given:
            found[Symbol(Kind.MOMENTUM, index)] = given.get((k, "p"), dag.zero)
    return found


def _unknown(dag: Dag, nodes: Sequence[Node], values: Mapping[Symbol, float]) -> set[Node]:
    """The nodes, among these and their operands, that depend on a symbol without a number."""
    unknown: set[Node] = set()
    for node in dag.reachable(nodes):
        symbol = dag.symbol_of(node)
        if symbol is None:
            if not unknown.isdisjoint(dag.operands(node)):
                unknown.add(node)
        elif symbol not in values:
            unknown.add(node)
    return unknown
