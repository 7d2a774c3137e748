"""Sparse linear systems whose coefficients are nodes, solved once and for all in the DAG."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from heapq import heapify, heappop, heappush

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.nodes import Node


class SingularSystemError(Exception):
    """The system has no single solution; `rows` are those that became empty."""

    def __init__(self, rows: Sequence[int]) -> None:
        super().__init__("singular system")
        self.rows = tuple(rows)


def solve_definite(
    dag: Dag,
    fingerprints: Fingerprints,
    matrix: Sequence[dict[int, Node]],
    right: Sequence[Sequence[Node]],
) -> list[list[Node]]:
    """Solve a symmetric positive definite system by L D L' in minimum-degree order.

    `matrix[i]` holds the nonzero entries of row i, of which those with column >= i are read;
    `right` is a sequence of right-hand sides. Gives one solution each.

    Raises
    ------
    SingularSystemError
        The matrix is singular for all values of its symbols.
    """
    size = len(matrix)
    rows: list[dict[int, Node]] = [{} for _ in range(size)]
    for i, row in enumerate(matrix):
        for j, node in row.items():
            if j >= i and node != dag.zero:
                rows[i][j] = rows[j][i] = node
    order: list[int] = []
    queue = [(len(row), i) for i, row in enumerate(rows)]
    heapify(queue)
    done = [False] * size
    multipliers: list[list[tuple[int, Node]]] = [[] for _ in range(size)]
    values = [[list(column)[i] for column in right] for i in range(size)]
    diagonal: list[Node] = [dag.zero] * size
    while queue:
        degree, k = heappop(queue)
        if done[k]:
            continue
        if degree != len(rows[k]):
            heappush(queue, (len(rows[k]), k))
            continue
        done[k] = True
        order.append(k)
        diagonal[k] = rows[k].pop(k, dag.zero)
        if fingerprints.is_zero(diagonal[k]):
            raise SingularSystemError([k])
        others = sorted(rows[k])
        for i in others:
            factor = dag.div(rows[k][i], diagonal[k])
            multipliers[k].append((i, factor))
            values[i] = [
                dag.sub(v, dag.mul(factor, w)) for v, w in zip(values[i], values[k], strict=True)
            ]
            for j in others:
                if j >= i:
                    change = dag.mul(factor, rows[k][j])
                    entry = dag.sub(rows[i].get(j, dag.zero), change)
                    rows[i][j] = rows[j][i] = entry
        for i in others:
            del rows[i][k]
            heappush(queue, (len(rows[i]), i))
    for k in reversed(order):
        for c in range(len(right)):
            solved = dag.div(values[k][c], diagonal[k])
            for i, factor in multipliers[k]:
                solved = dag.sub(solved, dag.mul(factor, values[i][c]))
            values[k][c] = solved
    return [[values[i][c] for i in range(size)] for c in range(len(right))]


def solve_general(
    dag: Dag,
    fingerprints: Fingerprints,
    matrix: Sequence[dict[int, Node]],
    right: Sequence[Node],
    preference: Callable[[Node], int],
    note: Callable[[Node, bool], None] = lambda pivot, alone: None,
) -> list[Node]:
    """Solve any regular sparse system; the entry of smallest preference and fill is the pivot.

    `note` is told of every node that is divided by, and whether it is alone in its row or column:
    the system is then singular where that node vanishes, whatever the other pivots are.

    An entry that is zero for all values of its symbols is never a pivot, so a system that is
    always singular is found out.

    Raises
    ------
    SingularSystemError
        No single solution exists.
    """
    rows = [
        {j: node for j, node in row.items() if not fingerprints.is_zero(node)} for row in matrix
    ]
    values = list(right)
    columns: list[set[int]] = [set() for _ in rows]
    for i, row in enumerate(rows):
        for j in row:
            columns[j].add(i)
    open_rows = set(range(len(rows)))
    steps: list[tuple[int, int]] = []
    queue: list[tuple[tuple[int, int, int], int]] = []

    def enqueue(i: int) -> None:
        if rows[i]:
            heappush(queue, (best_of(i)[0], i))

    def best_of(i: int) -> tuple[tuple[int, int, int], int]:
        width = len(rows[i])
        return min(
            (((preference(node), (width - 1) * (len(columns[j]) - 1), int(j != i)), j))
            for j, node in rows[i].items()
        )

    for i in range(len(rows)):
        enqueue(i)
    while queue:
        key, i = heappop(queue)
        if i not in open_rows or not rows[i]:
            continue
        now, j = best_of(i)
        if now > key:
            heappush(queue, (now, i))
            continue
        open_rows.remove(i)
        steps.append((i, j))
        pivot = rows[i][j]
        note(pivot, len(rows[i]) == 1 or len(columns[j]) == 1)
        for other in rows[i]:
            columns[other].discard(i)
        for r in sorted(columns[j]):
            factor = dag.div(rows[r].pop(j), pivot)
            values[r] = dag.sub(values[r], dag.mul(factor, values[i]))
            for other, entry in rows[i].items():
                if other == j:
                    continue
                changed = dag.sub(rows[r].get(other, dag.zero), dag.mul(factor, entry))
                if fingerprints.is_zero(changed):
                    rows[r].pop(other, None)
                    columns[other].discard(r)
                else:
                    rows[r][other] = changed
                    columns[other].add(r)
            enqueue(r)
        columns[j].clear()
    if open_rows:
        raise SingularSystemError(sorted(open_rows))
    solution = [dag.zero] * len(rows)
    for i, j in reversed(steps):
        known = dag.dot(
            (entry for other, entry in rows[i].items() if other != j),
            (solution[other] for other in rows[i] if other != j),
        )
        solution[j] = dag.div(dag.sub(values[i], known), rows[i][j])
    return solution
