"""Strong components (Tarjan, SIAM J. Comput. 1, 1972) and cycles of a directed graph."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator
from typing import TypeVar

Vertex = TypeVar("Vertex", bound=Hashable)


def strong_components(
    root: Vertex, needs: Callable[[Vertex], Iterable[Vertex]], is_done: Callable[[Vertex], bool]
) -> Iterator[tuple[list[Vertex], bool]]:
    """Yield the components that a vertex reaches, each after those it needs.

    Each is paired with a flag, whether it contains a cycle (a component of one vertex need not).
    The search is lazy: it asks for the next of a vertex's `needs` after it has yielded the
    component of the previous one, so `needs` may use the caller's results for that component. It
    skips vertices for which `is_done` holds; the caller lets it hold for the members of each
    component before it takes the next one.
    """
    order: dict[Vertex, int] = {root: 0}
    lowest: dict[Vertex, int] = {root: 0}
    open_vertices: list[Vertex] = [root]
    is_open = {root}
    stack: list[tuple[Vertex, Iterator[Vertex]]] = [(root, iter(needs(root)))]
    needs_itself: set[Vertex] = set()
    while stack:
        vertex, rest = stack[-1]
        for needed in rest:
            if is_done(needed):
                continue
            if needed not in order:
                order[needed] = lowest[needed] = len(order)
                open_vertices.append(needed)
                is_open.add(needed)
                stack.append((needed, iter(needs(needed))))
                break
            if needed in is_open:
                lowest[vertex] = min(lowest[vertex], order[needed])
                if needed == vertex:
                    needs_itself.add(vertex)
        else:
            stack.pop()
            if stack:
                above = stack[-1][0]
                lowest[above] = min(lowest[above], lowest[vertex])
            if lowest[vertex] == order[vertex]:
                members: list[Vertex] = []
                while not members or members[-1] != vertex:
                    members.append(open_vertices.pop())
                    is_open.remove(members[-1])
                yield members, len(members) > 1 or vertex in needs_itself


def all_components(
    vertices: Iterable[Vertex], needs: Callable[[Vertex], Iterable[Vertex]]
) -> Iterator[list[Vertex]]:
    """Yield the components of a whole graph, each after those it needs."""
    done: set[Vertex] = set()
    for root in vertices:
        if root not in done:
            for component, _ in strong_components(root, needs, done.__contains__):
                done.update(component)
                yield component


def vertices_on_cycles(
    candidates: Collection[Vertex],
    needs: Callable[[Vertex], Iterable[Vertex]],
    chosen: Iterable[Vertex],
) -> set[Vertex]:
    """The vertices that are chosen, with candidates so that one is on every cycle.

    Every cycle has to contain a candidate. A depth-first search takes the last candidate on each
    cycle that it closes, and leaves its path up to there. What lies beyond is visited again from
    elsewhere, at most once for each vertex taken.
    """
    taken, done, known = set(chosen), set[Vertex](), set(candidates)
    for start in candidates:
        if start in done or start in taken:
            continue
        path: dict[Vertex, Iterator[Vertex]] = {start: iter(needs(start))}
        while path:
            vertex, rest = next(reversed(path.items()))
            for needed in rest:
                if needed in taken or needed in done:
                    continue
                if needed in path:
                    while vertex not in known:
                        assert vertex != needed, "a cycle without a candidate"
                        path.pop(vertex)
                        vertex = next(reversed(path))
                    path.pop(vertex)
                    taken.add(vertex)
                else:
                    path[needed] = iter(needs(needed))
                break
            else:
                path.pop(vertex)
                done.add(vertex)
    return taken
