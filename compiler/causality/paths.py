"""Paths of rigid connections between elements, for messages."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TypeAlias

from bgc.diagnostics.catalogue.causality import Connection
from bgc.ir.graph import (
    Element,
    FlatGraph,
    Gyrator,
    Junction,
    Source,
    Transformer,
    port_ends,
    ports_of,
)


def rigid_path(graph: FlatGraph, start: int, end: int, bonds: Collection[int]) -> list[int]:
    """The elements between two others on a shortest path along bonds; empty if there is none.

    The path runs through junctions, transformers and gyrators, and if possible only along `bonds`.
    """
    return _search(graph, start, end, bonds) or _search(graph, start, end, None) or []


def _search(
    graph: FlatGraph, start: int, end: int, bonds: Collection[int] | None
) -> list[int] | None:
    on_bond = _elements_on_bonds(graph)
    came_from = {start: start}
    queue = deque([start])
    while queue and end not in came_from:
        here = queue.popleft()
        if here != start and not _is_rigid(graph.elements[here]):
            continue
        for port in ports_of(graph.elements[here]):
            if bonds is not None and port.bond not in bonds:
                continue
            for other in on_bond[port.bond]:
                if other not in came_from:
                    came_from[other] = here
                    queue.append(other)
    if end not in came_from:
        return None
    path: list[int] = []
    here = came_from[end]
    while here != start:
        path.append(here)
        here = came_from[here]
    return path[::-1]


def gyrators_around(graph: FlatGraph, closing: Iterable[int]) -> list[int]:
    """The gyrators of the odd loops that the given gyrators close, in the order of the graph."""
    on_bond = _elements_on_bonds(graph)
    return sorted({k for gyrator in closing for k in _odd_loop(graph, on_bond, gyrator)})


_Place: TypeAlias = tuple[int, bool]  # a bond, and whether the number of gyrators passed is odd


def _odd_loop(
    graph: FlatGraph, on_bond: Mapping[int, Sequence[int]], closing: int
) -> Iterable[int]:
    """The gyrators of a shortest odd loop: back to a gyrator past an even number of others."""
    gyrator = graph.elements[closing]
    if not isinstance(gyrator, Gyrator):
        return [closing]  # a law with a skew part, which is a gyrator by itself
    starts = [(port.bond, False) for port in gyrator.ports2]
    came_from: dict[_Place, tuple[_Place, int] | None] = dict.fromkeys(starts)
    queue = deque(starts)
    while queue:
        here = queue.popleft()
        bond, odd = here
        if not odd and any(port.bond == bond for port in gyrator.ports1):
            path = [closing]
            while step := came_from[here]:
                here, passed = step
                path.append(passed)
            return [index for index in path if isinstance(graph.elements[index], Gyrator)]
        for index in on_bond[bond]:
            new = [
                x for x in _beyond(graph, index, here) if index != closing and x not in came_from
            ]
            came_from |= dict.fromkeys(new, (here, index))
            queue.extend(new)
    return [closing]


def _beyond(graph: FlatGraph, index: int, place: _Place) -> list[_Place]:
    """The places beyond an element, if it passes a variable on."""
    bond, odd = place
    element = graph.elements[index]
    if not _is_rigid(element):
        return []
    now = odd != isinstance(element, Gyrator)
    return [(end, now) for end in _other_ends(element, bond)]


def _other_ends(element: Element, bond: int) -> list[int]:
    """The other bonds of an element; for a gyrator, those of its other side."""
    if not isinstance(element, Gyrator):
        return [port.bond for port in ports_of(element) if port.bond != bond]
    first = any(port.bond == bond for port in element.ports1)
    return [port.bond for port in (element.ports2 if first else element.ports1)]


def holding(graph: FlatGraph, bonds: Collection[int]) -> list[int]:
    """The junctions and sources on some bonds, which constrain the variables there."""
    return [
        index
        for index, element in enumerate(graph.elements)
        if isinstance(element, Junction | Source)
        and any(port.bond in bonds for port in ports_of(element))
    ]


def _elements_on_bonds(graph: FlatGraph) -> dict[int, list[int]]:
    found: dict[int, list[int]] = {}
    for bond, _, index in port_ends(graph):
        found.setdefault(bond, []).append(index)
    return found


def _is_rigid(element: Element) -> bool:
    return isinstance(element, Junction | Transformer | Gyrator)


def connections(graph: FlatGraph, elements: Iterable[int]) -> list[Connection]:
    """Name, kind and place of some elements, for messages."""
    return [
        Connection(element.name, element.kind, element.span)
        for element in (graph.elements[index] for index in elements)
    ]
