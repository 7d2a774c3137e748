"""A layered layout of a directed graph, for machines without Graphviz.

The usual four steps (K. Sugiyama, S. Tagawa, M. Toda, IEEE Trans. SMC 11(2), 1981): edges that
close circles are turned round, layers are longest paths, medians of neighbours reduce crossings,
and nodes are placed beside their neighbours. Long edges pass between nodes through empty ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final, TypeAlias

Point: TypeAlias = tuple[float, float]

_SWEEPS: Final = 12
_BETWEEN_LAYERS: Final = 46.0
_BETWEEN_NODES: Final = 18.0


def layered(
    sizes: Sequence[Point], edges: Sequence[tuple[int, int]]
) -> tuple[list[Point], list[list[Point]]]:
    """Place nodes with their middles, and edges as Bezier curves from border to border.

    `sizes` are widths and heights of the nodes, `edges` pairs of their indices. Layers follow each
    other along x. A curve has 3 n + 1 points. An edge from a node to itself has none.
    """
    forward = _without_circles(len(sizes), edges)
    layer = _layers(len(sizes), forward)
    chains, extended, layer_of = _chains(forward, layer, sizes)
    order = _order(layer_of, chains)
    at = _coordinates(order, extended, chains)
    curves: list[list[Point]] = []
    for (tail, head), chain in zip(edges, chains, strict=True):
        if tail == head:
            curves.append([])
            continue
        stops = [at[node] for node in (chain if chain[0] == tail else chain[::-1])]
        curves.append(_curve(stops, sizes[tail], sizes[head]))
    return at[: len(sizes)], curves


def _without_circles(count: int, edges: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Turn round each edge that leads back on a depth-first walk."""
    after: list[list[int]] = [[] for _ in range(count)]
    for index, (tail, _) in enumerate(edges):
        after[tail].append(index)
    turned = list(edges)
    state = [0] * count  # 1: on the present path, 2: done
    for root in range(count):
        if state[root]:
            continue
        state[root] = 1
        path = [(root, iter(after[root]))]
        while path:
            node, left = path[-1]
            out = next(left, None)
            if out is None:
                state[node] = 2
                path.pop()
                continue
            head = edges[out][1]
            if state[head] == 1:
                turned[out] = (head, node)
            elif state[head] == 0:
                state[head] = 1
                path.append((head, iter(after[head])))
    return turned


def _layers(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """Give each node the length of the longest path to it."""
    waiting = [0] * count
    after: list[list[int]] = [[] for _ in range(count)]
    for tail, head in edges:
        if tail != head:
            waiting[head] += 1
            after[tail].append(head)
    layer = [0] * count
    ready = [node for node in range(count) if not waiting[node]]
    for node in ready:
        for head in after[node]:
            layer[head] = max(layer[head], layer[node] + 1)
            waiting[head] -= 1
            if not waiting[head]:
                ready.append(head)
    # A source stands right before the first node that it leads to.
    for node in reversed(ready):
        if after[node] and not any(head == node for _, head in edges):
            layer[node] = min(layer[head] for head in after[node]) - 1
    return layer


def _chains(
    edges: Sequence[tuple[int, int]], layer: Sequence[int], sizes: Sequence[Point]
) -> tuple[list[list[int]], list[Point], list[int]]:
    """Divide long edges by empty nodes, one a layer."""
    extended, layers = list(sizes), list(layer)
    chains = []
    for tail, head in edges:
        chain = [tail]
        for between in range(layer[tail] + 1, layer[head]):
            chain.append(len(extended))
            extended.append((1.0, 1.0))
            layers.append(between)
        chains.append([*chain, head])
    return chains, extended, layers


def _order(layer: Sequence[int], chains: Sequence[Sequence[int]]) -> list[list[int]]:
    """Order the nodes of each layer by the medians of their neighbours, to and fro."""
    order: list[list[int]] = [[] for _ in range(max(layer, default=0) + 1)]
    for node, place in enumerate(layer):
        order[place].append(node)
    before, after = _neighbours(len(layer), chains)
    for sweep in range(_SWEEPS):
        beside = after if sweep % 2 else before
        row = {node: float(k) for nodes in order for k, node in enumerate(nodes)}
        for nodes in reversed(order) if sweep % 2 else order:
            wanted = {n: _median([row[m] for m in beside[n]], row[n]) for n in nodes}
            nodes.sort(key=wanted.__getitem__)
            row.update((node, float(k)) for k, node in enumerate(nodes))
    return order


def _neighbours(
    count: int, chains: Sequence[Sequence[int]]
) -> tuple[list[list[int]], list[list[int]]]:
    before: list[list[int]] = [[] for _ in range(count)]
    after: list[list[int]] = [[] for _ in range(count)]
    for chain in chains:
        for a, b in pairwise(chain):
            if a != b:
                after[a].append(b)
                before[b].append(a)
    return before, after


def _median(values: list[float], otherwise: float) -> float:
    values.sort()
    middle = len(values) // 2
    if not values:
        return otherwise
    return values[middle] if len(values) % 2 else (values[middle - 1] + values[middle]) / 2


def _coordinates(
    order: Sequence[Sequence[int]], sizes: Sequence[Point], chains: Sequence[Sequence[int]]
) -> list[Point]:
    """Place layers along x, and nodes beside their neighbours, as near as the others allow."""
    xs, right = [0.0] * len(sizes), 0.0
    for nodes in order:
        width = max((sizes[node][0] for node in nodes), default=0.0)
        for node in nodes:
            xs[node] = right + width / 2
        right += width + _BETWEEN_LAYERS
    before, after = _neighbours(len(sizes), chains)
    ys = [0.0] * len(sizes)
    for nodes in order:
        _spread(nodes, [0.0] * len(nodes), sizes, ys)
    for sweep in range(_SWEEPS):
        beside = after if sweep % 2 else before
        for nodes in reversed(order) if sweep % 2 else order:
            wanted = [_median([ys[m] for m in beside[n]], ys[n]) for n in nodes]
            _spread(nodes, wanted, sizes, ys)
    low = min((ys[n] - sizes[n][1] / 2 for n in range(len(sizes))), default=0.0)
    return [(x, y - low) for x, y in zip(xs, ys, strict=True)]


def _spread(
    nodes: Sequence[int], wanted: Sequence[float], sizes: Sequence[Point], ys: list[float]
) -> None:
    """Put a layer's nodes where they are wanted; those that would overlap are moved as one."""
    groups: list[tuple[list[int], float, float]] = []  # nodes, mean of the wanted, height
    for node, y in zip(nodes, wanted, strict=True):
        group, mean, height = [node], y, sizes[node][1] + _BETWEEN_NODES
        while groups and groups[-1][1] + groups[-1][2] / 2 > mean - height / 2:
            others, other, above = groups.pop()
            mean = (other * len(others) + mean * len(group)) / (len(others) + len(group))
            group, height = [*others, *group], above + height
        groups.append((group, mean, height))
    for group, mean, height in groups:
        top = mean - height / 2
        for node in group:
            own = sizes[node][1] + _BETWEEN_NODES
            ys[node] = top + own / 2
            top += own


def _curve(stops: Sequence[Point], tail: Point, head: Point) -> list[Point]:
    """A smooth curve through the stops, cut at the borders of the first and the last node."""
    first = _border(stops[0], stops[1], tail)
    last = _border(stops[-1], stops[-2], head)
    through = [first, *stops[1:-1], last]
    points = [first]
    for a, b in pairwise(through):
        bend = (b[0] - a[0]) / 2
        points += [(a[0] + bend, a[1]), (b[0] - bend, b[1]), b]
    return points


def _border(at: Point, other: Point, size: Point) -> Point:
    """Return the point at a node's left or right side where the line to another point begins."""
    side = 1.0 if other[0] >= at[0] else -1.0
    return at[0] + side * (size[0] / 2 + 4.0), at[1]
