"""Sparse linear systems whose coefficients are nodes, solved symbolically in the DAG."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from heapq import heapify, heappop, heappush

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.nodes import Node


class SingularSystemError(Exception):
    """The system has no unique solution; `rows` are those that became empty."""

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

    `matrix[i]` holds the nonzero entries of row i; only those with column >= i are read. Returns
    one solution for each right-hand side in `right`.

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
    """Solve a regular sparse system; the pivot is the entry of least `preference`, then fill.

    `note` is called with every pivot, and with whether it is the only entry of its row or column:
    the system is then singular where that pivot vanishes, whatever the other pivots are.

    An entry that is zero for all values of its symbols is never a pivot, so a system that is always
    singular is detected.

    Raises
    ------
    SingularSystemError
        The solution is not unique or does not exist.
    """
    work = _Elimination(dag, fingerprints, matrix, right)
    while (pivot := work.next_pivot(preference)) is not None:
        work.take(*pivot, note)
    return work.solution()


class _Elimination:
    """A sparse system during elimination; the steps are the (row, column) of the pivots."""

    def __init__(
        self,
        dag: Dag,
        fingerprints: Fingerprints,
        matrix: Sequence[dict[int, Node]],
        right: Sequence[Node],
    ) -> None:
        self._dag = dag
        self._is_zero = fingerprints.is_zero
        self._rows = [{j: x for j, x in row.items() if not self._is_zero(x)} for row in matrix]
        self._values = list(right)
        self._columns: list[set[int]] = [set() for _ in self._rows]  # open rows with each
        for i, row in enumerate(self._rows):
            for j in row:
                self._columns[j].add(i)
        self._open = set(range(len(self._rows)))
        self._steps: list[tuple[int, int]] = []
        self._queue: list[tuple[tuple[int, int, int], int]] = []
        self._changed = list(self._open)

    def next_pivot(self, preference: Callable[[Node], int]) -> tuple[int, int] | None:
        """The next pivot; None if no open row has an entry."""
        for i in self._changed:
            if self._rows[i]:
                heappush(self._queue, (self._best_of(i, preference)[0], i))
        self._changed = []
        while self._queue:
            key, i = heappop(self._queue)
            if i not in self._open or not self._rows[i]:
                continue
            now, j = self._best_of(i, preference)
            if now <= key:
                return i, j
            heappush(self._queue, (now, i))
        return None

    def _best_of(
        self, i: int, preference: Callable[[Node], int]
    ) -> tuple[tuple[int, int, int], int]:
        """The key of the best pivot of a row, and its column."""
        width = len(self._rows[i])
        return min(
            ((preference(node), (width - 1) * (len(self._columns[j]) - 1), int(j != i)), j)
            for j, node in self._rows[i].items()
        )

    def take(self, i: int, j: int, note: Callable[[Node, bool], None]) -> None:
        """Eliminate a column by one of its rows."""
        self._open.remove(i)
        self._steps.append((i, j))
        source, column = self._rows[i], self._columns[j]
        note(source[j], len(source) == 1 or len(column) == 1)
        for other in source:
            self._columns[other].discard(i)
        for r in sorted(column):
            self._subtract(r, i, j)
        self._changed = sorted(column)
        column.clear()

    def _subtract(self, target: int, source: int, column: int) -> None:
        dag, row = self._dag, self._rows[target]
        factor = dag.div(row.pop(column), self._rows[source][column])
        taken = dag.mul(factor, self._values[source])
        self._values[target] = dag.sub(self._values[target], taken)
        for j, entry in self._rows[source].items():
            if j == column:
                continue
            changed = dag.sub(row.get(j, dag.zero), dag.mul(factor, entry))
            if self._is_zero(changed):
                row.pop(j, None)
                self._columns[j].discard(target)
            else:
                row[j] = changed
                self._columns[j].add(target)

    def solution(self) -> list[Node]:
        """Substitute back; SingularSystemError if rows are left open."""
        if self._open:
            raise SingularSystemError(sorted(self._open))
        dag, found = self._dag, [self._dag.zero] * len(self._rows)
        for i, j in reversed(self._steps):
            row = self._rows[i]
            others = [k for k in row if k != j]
            known = dag.dot((row[k] for k in others), (found[k] for k in others))
            found[j] = dag.div(dag.sub(self._values[i], known), row[j])
        return found
