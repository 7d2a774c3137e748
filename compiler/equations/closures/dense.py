"""Ranks and least changes of small dense matrices of numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bgc.algebra.newton import solve_dense

Rows = Sequence[Sequence[float]]

_EMPTY = 1e-9  # beside the longest row: a row of this length or less is zero but for rounded data


def independent_rows(matrix: Rows, tolerance: float, empty: float = _EMPTY) -> list[int]:
    """The rows of a maximal independent set, the best one first.

    A row is dependent where the part of it that is orthogonal to the others is at most
    `tolerance` of its length, or where its length is at most `empty` of the longest.
    """
    lengths = [math.hypot(*row) for row in matrix]
    least = empty * max(lengths, default=0.0)
    left = {k: list(row) for k, row in enumerate(matrix) if lengths[k] > least}
    sizes = {k: math.hypot(*row) for k, row in left.items()}
    found: list[int] = []
    while left:
        best = max(left, key=lambda k: math.hypot(*left[k]) / sizes[k])
        row = left.pop(best)
        length = math.hypot(*row)
        if length <= tolerance * sizes[best]:
            break
        found.append(best)
        for other in left.values():
            orthogonalise(other, row, length)
    return found


def orthogonalise(row: list[float], other: Sequence[float], length: float) -> None:
    """Remove from a row its part along another one, twice, since the first time leaves rounding."""
    for _ in range(2):
        share = sum(a * b for a, b in zip(row, other, strict=True)) / length**2
        row[:] = [a - share * b for a, b in zip(row, other, strict=True)]


def damped_change(matrix: Rows, right: Sequence[float], damping: float) -> list[float]:
    """`A' (A A' + damping I)^-1 b`; zeros where it does not exist.

    It equals `(A' A + damping I)^-1 A' b`, whose matrix is smaller where A has more rows.
    """
    columns = list(zip(*matrix, strict=True))
    if len(matrix) > len(columns):
        moments = [sum(a * b for a, b in zip(column, right, strict=True)) for column in columns]
        return _damped_solution(columns, moments, damping) or [0.0] * len(columns)
    weights = _damped_solution(matrix, right, damping)
    if weights is None:
        return [0.0] * len(columns)
    return [sum(a * w for a, w in zip(column, weights, strict=True)) for column in columns]


def _damped_solution(
    matrix: Sequence[Sequence[float]], right: Sequence[float], damping: float
) -> list[float] | None:
    """`(A A' + damping I)^-1 b`; None where it does not exist."""
    table = [
        [sum(a * b for a, b in zip(row, other, strict=True)) for other in matrix] for row in matrix
    ]
    for k, row in enumerate(table):
        row[k] += damping
    return solve_dense(table, [-x for x in right])


def independent_in(matrix: Rows, whole: Sequence[float], tolerance: float) -> list[int]:
    """The rows of a positive semidefinite matrix that Cholesky's pivots choose, largest first.

    Pivots count relative to `whole`.
    """
    work = [list(row) for row in matrix]
    found: list[int] = []
    waiting = list(range(len(matrix)))
    while waiting:
        parts = {k: work[k][k] / whole[k] if whole[k] > 0 else 0.0 for k in waiting}
        best = max(waiting, key=lambda k: parts[k])
        waiting.remove(best)
        if not parts[best] > tolerance:
            break
        found.append(best)
        pivot = list(work[best])
        for k in waiting:
            factor = work[k][best] / pivot[best]
            work[k] = [a - factor * b for a, b in zip(work[k], pivot, strict=True)]
    return found
