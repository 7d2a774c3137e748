"""Mounts that contradict each other, so that a chain is held where it should move.

A planar linkage in space moves because the axes of its joints are parallel, one on a sphere because
they meet. Mounts that are wrong by a little take that motion away: the chain cannot be closed, or
cannot move. The first body whose motion leaves the directions of such a chain tells where.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.dense import independent_rows, orthogonalise
from bgc.algebra.evaluate import Evaluator
from bgc.causality.assign import assign
from bgc.diagnostics.diagnostic import Refused
from bgc.equations.closures.manifold import ROUNDED, Conditions, Point
from bgc.ir.causal import BasisKind, CausalGraph, Role
from bgc.ir.defaults import default_values
from bgc.ir.graph import FlatGraph, Source

_WRONG = 0.03  # directions that differ by more are not meant to be the same
_CLEAR = 0.02  # of the largest difference: less is a consequence of rounded data
_CONFIGURATIONS = 5


def is_within_reach(dag: Dag, conditions: Conditions, point: Point) -> bool:
    """Test whether a position is not one where a chain ends, as with two bars in one line.

    There the states move the conditions in fewer directions than in other positions.
    """
    rng = random.Random("reach")
    ranks = []
    for spread in (0.0, 0.3, 0.3, 0.6):
        near = dict(point)
        for k in conditions.moved:
            near[Symbol(Kind.STATE, k)] += spread * rng.uniform(-1, 1)
        _, table = conditions.at(dag, near)
        columns = [_unit(column) for column in zip(*table, strict=True)]
        ranks.append(len(independent_rows(columns, _WRONG)))
    return ranks[0] == max(ranks)


def body_aside(graph: FlatGraph) -> str | None:
    """The first body of an open tree that moves a little aside of the directions of its joints.

    The flows of each body by the rates of the joints are taken at random configurations, in the
    axes of the body. Where they have fewer dimensions than the body, but for parts below `_WRONG`,
    these parts are aside. None where no body has any.
    """
    causal = assign(graph, opened=True)
    if isinstance(causal, Refused):
        return None
    places = [_entries_at(causal, seed) for seed in range(_CONFIGURATIONS)]
    free = _free_flows(causal)
    found: list[tuple[int, float, str]] = []
    for element, numbers in _bodies(causal).items():
        held = {k for number in numbers for k in places[0][number] if k in free}
        columns = [_unit([at[n].get(k, 0.0) for n in numbers]) for at in places for k in held]
        name = graph.elements[element].name
        found.append((len(held), _largest_part_aside(columns), name.rpartition(".")[0] or name))
    largest = max((aside for _, aside, _ in found), default=0.0)
    if largest <= ROUNDED:
        return None
    return min((count, name) for count, aside, name in found if aside > _CLEAR * largest)[1]


def _free_flows(causal: CausalGraph) -> set[int]:
    """The independent flows that inertias determine, or sources other than zero."""
    zero, found = causal.graph.dag.zero, set()
    for k, basis in enumerate(causal.basis):
        members = causal.classes[basis.bond_class]
        elements = [causal.graph.elements[causal.ports[p].element] for p in members.ports]
        if basis.kind is BasisKind.INERTIA or any(
            isinstance(e, Source) and e.kind == "Sf" and e.value != zero for e in elements
        ):
            found.add(k)
    return found


def _bodies(causal: CausalGraph) -> dict[int, list[int]]:
    """The classes that each element's inertias are in."""
    classes: dict[int, list[int]] = {}
    for number, members in enumerate(causal.classes):
        for port in (causal.ports[k] for k in members.ports):
            if port.role is Role.INERTIA:
                classes.setdefault(port.element, []).append(number)
    return classes


def _entries_at(causal: CausalGraph, seed: int) -> list[dict[int, float]]:
    """The rows of N at a random configuration, with the parameters' defaults."""
    dag = causal.graph.dag
    rng = random.Random(f"configuration {seed}")
    known = default_values(dag, causal.graph.parameters)

    def value(symbol: Symbol) -> float:
        if symbol.kind is not Kind.PARAM:
            known.setdefault(symbol, rng.uniform(-1, 1))
        return known[symbol]

    numbers = Evaluator(dag, value)
    return [{k: numbers.value(node) for k, node in row} for row in causal.flows]


def _unit(column: Sequence[float]) -> list[float]:
    length = math.hypot(*column)
    return [x / length if length else 0.0 for x in column]


def _largest_part_aside(columns: Sequence[list[float]]) -> float:
    """The largest part of a column outside the directions that the columns are meant to have."""
    rows = [list(column) for column in columns]
    for k in independent_rows(columns, _WRONG):
        direction = _unit(rows[k])
        for row in rows:
            orthogonalise(row, direction, 1.0)
    return max((math.hypot(*row) for row in rows), default=0.0)
