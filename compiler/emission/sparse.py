"""Plan the pivots and fill of the LU factorisation of `W = c M - J` from its pattern.

Pivots are chosen at compile time. A row has its pivot on the diagonal where the pattern has an
entry there; the other rows (algebraic equations) get theirs from a matching of rows and columns,
entries of M first. The order of elimination is greedy, by the bound of Markowitz (1957) on fill,
(entries in the row - 1) (entries in the column - 1); for small models also by the exact fill, which
is more expensive to compute, and the order with fewer operations is kept. The priority queue may
hold stale costs, which are updated when they reach its head. The factorisation is up-looking: row k
follows from the rows above it, each entry a single sum of products.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from heapq import heapify, heappop, heappush
from typing import TypeAlias

from bgc.algebra.matching import Matching
from bgc.ir.lowered import Jacobian, LuPlan
from bgc.ir.program import Program

_HUB = 64  # entries of a column from which on its fill is counted only when its turn may have come
_MAX_FOR_EXACT_FILL = 5_000  # operations of a factorisation up to which exact fill is tried

_Cost: TypeAlias = Callable[[Sequence[set[int]], Sequence[set[int]], int], int | tuple[int, int]]


def plan_lu(program: Program, jacobian: Jacobian) -> LuPlan:
    """Plan the factorisation of the iteration matrix of a program."""
    if jacobian.pivots:
        places = zip(jacobian.rows, jacobian.columns, strict=True)
        plan = plan_in_order(jacobian.size, places, jacobian.pivots)
        return with_units(plan, program, jacobian)
    places = zip(jacobian.rows, jacobian.columns, strict=True)
    return plan_pattern(jacobian.size, mass_places(program), places)


def entries_of_matrix(program: Program, jacobian: Jacobian) -> set[tuple[int, int]]:
    """The positions of the entries of the iteration matrix of a program."""
    return mass_places(program).union(zip(jacobian.rows, jacobian.columns, strict=True))


def mass_places(program: Program) -> set[tuple[int, int]]:
    """The positions of the entries of M."""
    if program.mass is None:
        return {(i, i) for i in range(len(program.states))}
    return {(entry.row, entry.column) for entry in program.mass}


def plan_pattern(
    size: int, preferred: Iterable[tuple[int, int]], others: Iterable[tuple[int, int]]
) -> LuPlan:
    """Plan the factorisation of a pattern: positions in `preferred` (those of M) and `others`.

    Pivots are on the diagonal where possible, then at preferred positions.
    """
    preferred_columns: list[set[int]] = [set() for _ in range(size)]
    pattern: list[set[int]] = [set() for _ in range(size)]
    for row, column in preferred:
        preferred_columns[row].add(column)
        pattern[row].add(column)
    for row, column in others:
        pattern[row].add(column)
    column_of = _match(preferred_columns, pattern)
    plan = _eliminate(pattern, column_of, _product_count)
    if plan.operations > _MAX_FOR_EXACT_FILL:
        return plan
    by_fill = _eliminate(pattern, column_of, _fill_count, _least_fill)
    return min(plan, by_fill, key=lambda p: p.operations)


def plan_in_order(size: int, places: Iterable[tuple[int, int]], order: Sequence[int]) -> LuPlan:
    """Plan the factorisation of a pattern with pivots on the diagonal, in a given order."""
    pattern: list[set[int]] = [{k} for k in range(size)]
    for row, column in places:
        pattern[row].add(column)
    rank = {pivot: place for place, pivot in enumerate(order)}
    return _eliminate(pattern, range(size), lambda rows, columns, pivot: rank[pivot])


def with_units(plan: LuPlan, program: Program, jacobian: Jacobian) -> LuPlan:
    """Find the entries of the factors that are always 1 or -1, and count operations without them.

    These are entries of W that elimination leaves as they are. M is the identity.
    """
    value, states = program.dag.value, len(program.states)
    known = {
        (row, column): -int(number)
        for row, column, entry in zip(
            jacobian.rows, jacobian.columns, jacobian.entries, strict=True
        )
        if (number := value(entry)) in (1, -1) and not (row == column and row < states)
    }
    units: dict[tuple[int, int], int] = {}
    operations = 0
    for k, (lower, upper) in enumerate(zip(plan.lower, plan.upper, strict=True)):
        filled: set[int] = set()
        row = plan.rows[k]
        for j in lower:
            sign = known.get((row, plan.columns[j])) if j not in filled else None
            pivot = units.get((j, j))
            if sign is not None and pivot is not None:
                units[k, j] = sign * pivot
            operations += pivot is None
            for i in plan.upper[j]:
                filled.add(i)
                operations += 2 - ((k, j) in units or (j, i) in units)
        for j in (k, *upper):
            sign = known.get((row, plan.columns[j])) if j not in filled else None
            if sign is not None:
                units[k, j] = sign
        operations += (k, k) not in units
    return replace(plan, units=units, operations=operations)


def _match(preferred: Sequence[set[int]], pattern: Sequence[set[int]]) -> list[int]:
    """Match every row of a pattern with a column, its own where possible.

    Rows without a diagonal entry are matched by augmenting paths, over the `preferred` part of the
    pattern before the whole pattern.
    """
    size = len(pattern)
    own = {k: k for k in range(size) if k in pattern[k]}
    matching = Matching(own)
    for row in range(size):
        if row in own or matching.augment(row, lambda k: sorted(preferred[k])):
            continue
        if not matching.augment(row, lambda k: sorted(pattern[k])):
            raise AssertionError(f"no pivot for row {row}: the equations are singular")
    return [matching.column_of[row] for row in range(size)]


def _product_count(rows: Sequence[set[int]], columns: Sequence[set[int]], pivot: int) -> int:
    """The number of products of a pivot's row and column, a bound on its fill."""
    return (len(rows[pivot]) - 1) * (len(columns[pivot]) - 1)


def _fill_count(
    rows: Sequence[set[int]], columns: Sequence[set[int]], pivot: int
) -> tuple[int, int]:
    """The fill of a pivot, and its number of products."""
    across = rows[pivot]
    filled = sum(len(across - rows[row]) for row in columns[pivot])
    return filled, _product_count(rows, columns, pivot)


def _least_fill(
    rows: Sequence[set[int]], columns: Sequence[set[int]], pivot: int
) -> tuple[int, int]:
    """A lower bound of `_fill_count`; it is not counted for a pivot with many neighbours."""
    if len(columns[pivot]) <= _HUB:
        return _fill_count(rows, columns, pivot)
    return 0, _product_count(rows, columns, pivot)


def _with_diagonal_pivots(
    pattern: Sequence[set[int]], column_of: Sequence[int]
) -> tuple[list[set[int]], list[set[int]]]:
    """The pattern by rows and by columns, columns renumbered such that pivots are diagonal."""
    size = len(pattern)
    row_of = [0] * size
    for row, column in enumerate(column_of):
        row_of[column] = row
    rows = [{row_of[column] for column in entries} for entries in pattern]
    columns: list[set[int]] = [set() for _ in range(size)]
    for row, entries in enumerate(rows):
        for column in entries:
            columns[column].add(row)
    return rows, columns


def _eliminate(
    pattern: Sequence[set[int]],
    column_of: Sequence[int],
    cost_of: _Cost,
    least_of: _Cost | None = None,
) -> LuPlan:
    """Eliminate symbolically, each time the pivot with the least `cost_of`.

    A pivot whose cost has changed waits by `least_of`, a lower bound that may take less time.
    """
    size, least_of = len(pattern), least_of or cost_of
    rows, columns = _with_diagonal_pivots(pattern, column_of)
    queue = [(cost_of(rows, columns, k), k) for k in range(size)]
    heapify(queue)
    order: list[int] = []
    place = [-1] * size
    right: list[set[int]] = []  # for each pivot: the columns right of it
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
            heappush(queue, (least_of(rows, columns, k), k))
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
