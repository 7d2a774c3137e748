"""Choose the values that stay unknowns of the linear systems, and the order of pivots.

On a chain of bodies every state reaches the rows of all others, through velocities, orientations
and forces. Accumulated derivatives are dense, O(n^2), though the chain is narrow. So some vertices
of the graph of partial derivatives are kept as unknowns v of the linear systems, with the row
0 = sum e ds - dv, and eliminated between the states, whose factorisation follows the chain.

A static order has to be safe. The rule: an unknown k (a state or a speed) may be eliminated only
when no vertex is left on any path from column k to row k. Then

- no vertex gets a loop, so its pivot is exactly 1: a loop on v needs a path k -> v -> row k;
- the pivots of the unknowns are those of the accumulated matrix in the same order.

So an order is as safe as pivots on the diagonal are without vertices. Unknowns come in groups, a
speed with the states that belong to it: the momentum that its row reads, and the coordinate whose
rate reads it. Before a group is eliminated, the vertices on the paths between its columns and rows
are. The groups come in the order of the longest paths from the columns of their speeds, shortest
first: a chain from its tip, a tree from its leaves. (The number of vertices that a speed reaches
does not follow a chain: a slide turns nothing, so it reaches fewer than a hinge further out.)
Vertices that add few edges are eliminated at once, and the vertices of a group in the order of the
edges that they add, as in `vertices.py`.

Everything here is done on patterns. A vertex is accumulated (its edges multiplied symbolically,
`vertices.py`) if no unknown has been eliminated on its edges before; the others are kept.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from heapq import heapify, heappop, heappush

from bgc.record_class import dataclass

Edges = Mapping[int, Collection[int]]
Settings = tuple[int, int]
"""Limits for a cheap vertex, growth of the number of edges: at the start, and after each group."""


@dataclass(frozen=True, slots=True)
class Order:
    """An order of elimination.

    `accumulated` are the vertices to eliminate from the graph, in order. `pivots` are the unknowns
    (their numbers) and the kept vertices (~ their node) in the order of the pivots. `products` is
    a measure of the cost.
    """

    accumulated: tuple[int, ...]
    pivots: tuple[int, ...]
    products: int

    @property
    def kept(self) -> list[int]:
        """The kept vertices, in the order of their nodes: operands first."""
        return sorted(~pivot for pivot in self.pivots if pivot < 0)


def order_elimination(into: Edges, speeds: Collection[int], settings: Settings) -> Order:
    """Order the vertices and unknowns of a graph.

    `into` maps each vertex v to the sources of its edges, and each row k, as ~k, to those of its
    own; sources are vertices, and columns k as ~k. Of the unknowns, `speeds` have no rate.
    """
    elimination = _Elimination(into)
    length = elimination.path_lengths(speeds)
    first, later = settings
    elimination.take_cheap(elimination.vertices(), first)
    for group in _groups(elimination, sorted(speeds, key=lambda k: (length[k], k))):
        elimination.take_cheap(elimination.take_group(group), later)
    assert not elimination.vertices(), "a vertex is on no path between unknowns"
    return Order(tuple(elimination.accumulated), tuple(elimination.pivots), elimination.products)


class _Elimination:
    """The edges of a graph, by targets and by sources; the row and the column of k are ~k."""

    def __init__(self, into: Edges) -> None:
        self.into = {target: set(sources) for target, sources in into.items()}
        self.out_of: dict[int, set[int]] = {key: set() for key in into}
        for target, sources in into.items():
            for source in sources:
                self.out_of[source].add(target)
        self.unknowns = sorted(~key for key in into if key < 0)
        self.accumulated: list[int] = []
        self.pivots: list[int] = []
        self.products = 0
        self._changed: set[tuple[int, int]] = set()  # edges that hold a pivot of an unknown

    def vertices(self) -> list[int]:
        """The vertices that are left."""
        return [vertex for vertex in self.into if vertex >= 0]

    def reached(self, columns: Iterable[int]) -> set[int]:
        """The vertices on paths from columns (as ~k)."""
        return _spread(self.out_of, columns)

    def reaching(self, rows: Iterable[int]) -> set[int]:
        """The vertices on paths to rows (as ~k)."""
        return _spread(self.into, rows)

    def path_lengths(self, unknowns: Iterable[int]) -> dict[int, int]:
        """For each unknown the vertices on the longest path from its column.

        Operands have smaller numbers than the vertices that use them, so the graph has to be
        that of the DAG, before the first unknown is eliminated.
        """
        length = dict.fromkeys(self.into, 0)  # a path ends at a row
        for vertex in sorted(self.vertices(), reverse=True):
            length[vertex] = 1 + max((length[x] for x in self.out_of[vertex]), default=0)
        return {k: max((length[x] for x in self.out_of[~k]), default=0) for k in unknowns}

    def take_cheap(self, vertices: Iterable[int], slack: int) -> None:
        """Eliminate vertices that add hardly any edges."""
        for vertex, queue in self._in_order(vertices):
            if self._growth(vertex) <= slack:
                for other in self._take_vertex(vertex):
                    heappush(queue, (self._growth(other), -other))

    def take_group(self, group: Sequence[int]) -> set[int]:
        """Eliminate the vertices on the paths of a group, then its unknowns.

        Returns the vertices whose edges have changed.
        """
        ends = [~k for k in group]
        path = self.reached(ends) & self.reaching(ends)
        touched: set[int] = set()
        for vertex, queue in self._in_order(path):
            neighbours = self._take_vertex(vertex)
            touched |= neighbours
            for other in neighbours & path:
                heappush(queue, (self._growth(other), -other))
        for k in group:
            touched |= self._take_unknown(k)
        return touched & self.into.keys()

    def _in_order(self, vertices: Iterable[int]) -> Iterable[tuple[int, list[tuple[int, int]]]]:
        """Vertices by the edges that they add, of equal ones the last first, and the queue.

        A vertex whose edges change has to be added to the queue again. Edges between its neighbours
        may make what it adds less in the meantime: the order is that of the least only nearly.
        """
        queue = [(self._growth(v), -v) for v in vertices if v in self.into]
        heapify(queue)
        while queue:
            growth, place = heappop(queue)
            if -place not in self.into:
                continue
            if growth != (now := self._growth(-place)):
                heappush(queue, (now, place))
                continue
            yield -place, queue

    def _growth(self, vertex: int) -> int:
        """The growth of the number of edges in the elimination of a vertex."""
        sources, targets = self.into[vertex], self.out_of[vertex]
        new = sum(len(sources - self.into[target]) for target in targets)
        return new - len(sources) - len(targets)

    def _take_vertex(self, vertex: int) -> set[int]:
        edges = [(source, vertex) for source in self.into[vertex]]
        edges += [(vertex, target) for target in self.out_of[vertex]]
        keep = not self._changed.isdisjoint(edges)
        self._changed.difference_update(edges)
        if keep:
            self.pivots.append(~vertex)
        else:
            self.accumulated.append(vertex)
        return self._take(vertex, keep)

    def _take_unknown(self, k: int) -> set[int]:
        self.pivots.append(k)
        return self._take(~k, True)

    def _take(self, key: int, keep: bool) -> set[int]:
        """Eliminate a row and its column; returns the vertices whose edges have changed."""
        sources, targets = self.into.pop(key), self.out_of.pop(key)
        sources.discard(key)
        targets.discard(key)
        self.products += (1 + keep) * len(sources) * len(targets)
        for source in sources:
            self.out_of[source].discard(key)
        for target in targets:
            edges = self.into[target]
            edges.discard(key)
            for source in sources - edges:
                self.out_of[source].add(target)
            edges |= sources
        if keep:
            self._changed.update((source, target) for source in sources for target in targets)
        return {x for x in (*sources, *targets) if x >= 0}


def _spread(edges: Mapping[int, Collection[int]], starts: Iterable[int]) -> set[int]:
    """The vertices that edges reach from some starts, through vertices."""
    found: set[int] = set()
    stack = list(starts)
    while stack:
        for other in edges[stack.pop()]:
            if other >= 0 and other not in found:
                found.add(other)
                stack.append(other)
    return found


def _groups(elimination: _Elimination, speeds: Sequence[int]) -> list[tuple[int, ...]]:
    """Each speed after the states that belong to it, in the order of the speeds; then the others.

    Of several speeds that a state belongs to, it is given to the first.
    """
    before: dict[int, list[int]] = {k: [] for k in speeds}
    after: dict[int, list[int]] = {k: [] for k in speeds}
    alone: list[tuple[int, ...]] = []
    for k in elimination.unknowns:
        if k in before:
            continue
        targets = elimination.out_of[~k]
        direct = [u for u in speeds if ~u in targets]
        if direct and all(target < 0 for target in targets):
            before[direct[0]].append(k)
            continue
        read = set(elimination.into[~k])
        for vertex in elimination.reaching([~k]):
            read |= elimination.into[vertex]
        owners = [u for u in speeds if ~u in read] or direct
        if owners:
            after[owners[0]].append(k)
        else:
            alone.append((k,))
    return [(*before[u], *after[u], u) for u in speeds] + alone
