"""Proof that the reduced mass of merged inertias is regular at all states.

The reduced mass `N' M N` is singular only where the columns of N depend on each other. They never
do where N has a triangular part with constant, nonzero entries on its diagonal: rows that add one
independent flow each. Chains of joints have one, since the rate of a body's own joint enters the
twist of the body, in its own frame, with constants.
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Level
from bgc.equations.inertias.groups import Group, inertias_of
from bgc.equations.storage.kinds import StorageElement
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node


def has_constant_rank(variables: Variables, group: Group) -> bool:
    """Test whether the independent flows of a group are proven to move its inertias always."""
    own = set(group.flows)
    rows = [
        {k: node for k, node in port.flow.items() if k in own}
        for element in group.elements
        if _has_constant_law(variables, element)
        for port in inertias_of(element)
    ]
    return _flows_left(variables, rows, own) == set()


def _has_constant_law(variables: Variables, element: StorageElement) -> bool:
    capacity = element.law.capacity
    level = variables.dag.level
    return capacity is not None and all(level[x] <= Level.PARAM for row in capacity for x in row)


def _flows_left(variables: Variables, rows: Sequence[dict[int, Node]], flows: set[int]) -> set[int]:
    """The flows that no row determines once the flows before it are known."""
    left = set(flows)
    using: dict[int, list[int]] = {k: [] for k in flows}
    for number, row in enumerate(rows):
        for k in row:
            using[k].append(number)
    unknown = [len(row) for row in rows]
    ready = [number for number, count in enumerate(unknown) if count == 1]
    while ready:
        row = rows[ready.pop()]
        for k in left.intersection(row):  # one, or none where another row came first
            if variables.certificate(row[k]) is not None:
                left.remove(k)
                for number in using[k]:
                    unknown[number] -= 1
                    if unknown[number] == 1:
                        ready.append(number)
    return left
