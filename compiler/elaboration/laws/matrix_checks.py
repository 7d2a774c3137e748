"""Check the matrix of a law: skew symmetry, inverse, dependence on other variables."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from bgc.algebra.dag import Dag, Kind, Level, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.fingerprint import Fingerprints
from bgc.elaboration.instances.tree import Element
from bgc.elaboration.instances.world import World
from bgc.elaboration.laws.law_blocks import Laws
from bgc.ir.defaults import default_values
from bgc.ir.graph import EnergyLaw, ExplicitLaw, Law, LinearLaw, Matrix, Node

_ASYMMETRY_TOLERANCE = 1e-9


class LawChecks:
    """Checks matrices by fingerprint, otherwise numerically at the defaults of the parameters."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._fingerprints = Fingerprints(world.dag)
        self._defaults: dict[Symbol, float] | None = None

    def skew_defect(self, matrix: Matrix) -> tuple[int, int] | None:
        """Row and column (from 0) of an entry with `S[i, j] != -S[j, i]`; None if S is skew."""
        add = self._world.dag.add
        size = len(matrix)
        places = [(i, j) for i in range(size) for j in range(i, size)]
        return self._first_nonzero(
            places, [add(matrix[i][j], matrix[j][i]) for i, j in places], matrix
        )

    def inverts(self, inverse: Matrix, matrix: Matrix) -> bool:
        """Return whether `inverse * matrix` is the identity."""
        dag = self._world.dag
        columns = list(zip(*matrix, strict=True))
        if len(inverse) != len(columns) or len(inverse[0]) != len(matrix):
            return False
        differences = [
            dag.sub(dag.dot(row, column), dag.const(int(i == j)))
            for i, row in enumerate(inverse)
            for j, column in enumerate(columns)
        ]
        left = [node for node in differences if not self._fingerprints.is_zero(node)]
        return all(abs(number) <= _ASYMMETRY_TOLERANCE for number in self._numbers(left))

    def is_finite(self, matrix: Matrix) -> bool:
        """Return whether all entries are finite at the defaults of the parameters."""
        return all(map(math.isfinite, self._numbers([node for row in matrix for node in row])))

    def _first_nonzero(
        self, places: list[tuple[int, int]], nodes: list[Node], matrix: Matrix
    ) -> tuple[int, int] | None:
        """The first place with a nonzero node, relative to the entry of the matrix there."""
        doubtful = [
            (place, node)
            for place, node in zip(places, nodes, strict=True)
            if not self._fingerprints.is_zero(node)
        ]
        sizes = self._numbers([matrix[i][j] for (i, j), _ in doubtful])
        numbers = self._numbers([node for _, node in doubtful])
        for (place, _), number, size in zip(doubtful, numbers, sizes, strict=True):
            if not abs(number) <= _ASYMMETRY_TOLERANCE * abs(size):
                return place
        return None

    def _numbers(self, nodes: Sequence[Node]) -> list[float]:
        """Evaluate nodes at the defaults of the parameters and random values of other symbols."""
        if not nodes:
            return []
        dag = self._world.dag
        if self._defaults is None:
            self._defaults = default_values(dag, self._world.quantities.parameters)
        generator = random.Random(20130527)
        leaves = dict(self._defaults)
        for node in dag.reachable(nodes):
            symbol = dag.symbol_of(node)
            if symbol is not None and symbol.kind is not Kind.PARAM:
                leaves[symbol] = generator.uniform(0.1, 0.9)
        return evaluate_nodes(dag, nodes, leaves)


def varies(dag: Dag, matrix: Matrix) -> bool:
    """Return whether an entry depends on time, an input or a state."""
    return any(dag.level[node] > Level.PARAM for row in matrix for node in row)


def depends_on_others(laws: Laws, law: Law, element: Element, own: set[Kind]) -> bool:
    """Return whether the law of an element with ports on one side depends on foreign symbols.

    Parameters and the element's own variables of the kinds `own` are permitted.
    """
    dag = laws.world.dag
    match law:
        case LinearLaw():
            return varies(dag, law.matrix)
        case ExplicitLaw():
            roots = law.nodes
        case EnergyLaw():
            roots = (law.energy,)
    allowed: set[tuple[Kind, int]] = set()
    for k, port in enumerate(laws.ports(element, "all")):
        for kind in own:
            stored = kind in {Kind.DISPLACEMENT, Kind.MOMENTUM}
            allowed.add((kind, element.first_state + k if stored else port.bond))
    symbols = (dag.symbol_of(node) for node in dag.reachable(roots))
    return any(
        symbol.kind is not Kind.PARAM and (symbol.kind, symbol.index) not in allowed
        for symbol in symbols
        if symbol is not None
    )
