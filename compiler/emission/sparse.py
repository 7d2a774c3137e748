"""The order of elimination and the fill of `W = c M - J`, from its pattern alone.

Pivots are fixed at compile time. Where M has a diagonal entry the pivot is on the diagonal; a
row without one (an algebraic equation) gets an entry of its own by a matching of rows to
columns. Among these pivots the next is always one that fills in least, found with a heap that is
allowed to be stale: by the bound of Markowitz (1957), entries in its row times entries in its
column, and of small models by the count of entries that it fills, which takes longer to make out.
The order with fewer operations is kept.
The factors are kept up-looking: row k from rows above it, each entry one sum of products.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from heapq import heapify, heappop, heappush

from bgc.algebra.matching import Matching
from bgc.ir.lowered import Jacobian, LuPlan
from bgc.ir.program import Program

_COUNTED = 5_000  # operations of a factorisation up to which fill is counted


def plan_lu(program: Program, jacobian: Jacobian) -> LuPlan:
    """Pivots and fill for the iteration matrix of a program."""
    size = len(program.states)
    sure = (
        {(i, i) for i in range(size)}
        if program.mass is None
        else {(m.row, m.column) for m in program.mass}
    )
    return plan_pattern(size, sure, zip(jacobian.rows, jacobian.columns, strict=True))


def plan_pattern(
    size: int, sure: Iterable[tuple[int, int]], others: Iterable[tuple[int, int]]
) -> LuPlan:
    """Pivots and fill of a pattern; pivots are taken among `sure` positions where possible."""
    first: list[set[int]] = [set() for _ in range(size)]
    pattern: list[set[int]] = [set() for _ in range(size)]
    for row, column in sure:
        first[row].add(column)
        pattern[row].add(column)
    for row, column in others:
        pattern[row].add(column)
    column_of = _match(first, pattern)
    plan = _eliminate(pattern, column_of, _products)
    if plan.operations > _COUNTED:
        return plan
    return min(plan, _eliminate(pattern, column_of, _filled), key=lambda p: p.operations)


def _match(first: Sequence[set[int]], pattern: Sequence[set[int]]) -> list[int]:
    """Match every row of a pattern with a column, its own where possible; `first` is part of it.

    Diagonal entries are taken where there are any; then augmenting paths, over `first` before the
    whole pattern, complete the matching.
    """
    size = len(pattern)
    own = {k: k for k in range(size) if k in pattern[k]}
    matching = Matching(own)
    for row in range(size):
        if row in own or matching.augment(row, lambda k: sorted(first[k])):
            continue
        if not matching.augment(row, lambda k: sorted(pattern[k])):
            raise AssertionError(f"no pivot for row {row}: the equations are singular")
    return [matching.column_of[row] for row in range(size)]


def _products(rows: Sequence[set[int]], columns: Sequence[set[int]], pivot: int) -> int:
    """The products of a pivot's row and column."""
    return (len(rows[pivot]) - 1) * (len(columns[pivot]) - 1)


def _filled(rows: Sequence[set[int]], columns: Sequence[set[int]], pivot: int) -> tuple[int, int]:
    """The entries that a pivot fills, and its products."""
    across = rows[pivot]
    filled = sum(len(across - rows[row]) for row in columns[pivot])
    return filled, _products(rows, columns, pivot)


def _eliminate(
    pattern: Sequence[set[int]],
    column_of: Sequence[int],
    cost_of: Callable[[Sequence[set[int]], Sequence[set[int]], int], int | tuple[int, int]],
) -> LuPlan:
    """Eliminates symbolically. Columns are renamed after the row whose pivot they hold."""
    size = len(pattern)
    named = [0] * size
    for row, column in enumerate(column_of):
        named[column] = row
    rows = [{named[column] for column in entries} for entries in pattern]
    columns: list[set[int]] = [set() for _ in range(size)]
    for row, entries in enumerate(rows):
        for column in entries:
            columns[column].add(row)
    queue = [(cost_of(rows, columns, k), k) for k in range(size)]
    heapify(queue)
    order: list[int] = []
    place = [-1] * size
    right: list[set[int]] = []  # of each pivot: the columns right of it
    lower: list[list[int]] = [[] for _ in range(size)]
    operations = 0
    while queue:
        cost, pivot = heappop(queue)
        if place[pivot] >= 0:
            continue
        across, down = rows[pivot], columns[pivot]
        if cost != (now := cost_of(rows, columns, pivot)):
            heappush(queue, (now, pivot))
            continue
        across.discard(pivot)
        down.discard(pivot)
        place[pivot] = len(order)
        for column in across:
            columns[column].discard(pivot)
        for row in down:
            entries = rows[row]
            entries.discard(pivot)
            lower[row].append(place[pivot])
            for column in across - entries:
                entries.add(column)
                columns[column].add(row)
        for k in across | down:
            heappush(queue, (cost_of(rows, columns, k), k))
        operations += 1 + len(down) * (1 + 2 * len(across))
        order.append(pivot)
        right.append(across)
    return LuPlan(
        rows=tuple(order),
        columns=tuple(column_of[row] for row in order),
        lower=tuple(tuple(lower[row]) for row in order),
        upper=tuple(tuple(sorted(place[k] for k in across)) for across in right),
        operations=operations,
    )
