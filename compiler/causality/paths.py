"""How two elements meet: the rigid connections between them, in the order of the way."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable

from bgc.causality.regions import ports_of
from bgc.grammar.catalogue.causality import Connection
from bgc.graph import Element, FlatGraph, Gyrator, Junction, Source, Transformer


def rigid_path(graph: FlatGraph, start: int, end: int, bonds: Collection[int]) -> list[int]:
    """The elements between two others on a shortest way along bonds; empty where there is none.

    The way runs through junctions, transformers and gyrators, and along `bonds` where it can.
    """
    return _search(graph, start, end, bonds) or _search(graph, start, end, None) or []


def _search(
    graph: FlatGraph, start: int, end: int, bonds: Collection[int] | None
) -> list[int] | None:
    on_bond: dict[int, list[int]] = {}
    for index, element in enumerate(graph.elements):
        for port in ports_of(element):
            on_bond.setdefault(port.bond, []).append(index)
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
    way: list[int] = []
    here = came_from[end]
    while here != start:
        way.append(here)
        here = came_from[here]
    return way[::-1]


def holding(graph: FlatGraph, bonds: Collection[int]) -> list[int]:
    """The junctions and sources on some bonds, which hold the variables there."""
    return [
        index
        for index, element in enumerate(graph.elements)
        if isinstance(element, Junction | Source)
        and any(port.bond in bonds for port in ports_of(element))
    ]


def _is_rigid(element: Element) -> bool:
    return isinstance(element, Junction | Transformer | Gyrator)


def connections(graph: FlatGraph, elements: Iterable[int]) -> list[Connection]:
    """What messages say of some elements."""
    return [
        Connection(element.name, element.kind, element.span)
        for element in (graph.elements[index] for index in elements)
    ]
