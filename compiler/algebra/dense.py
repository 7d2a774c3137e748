"""Small dense matrices of numbers: solutions, ranks, least changes, soft motions.

They are lists: importing NumPy takes twice as long as importing all that derives equations, and a
model of usual size has few such systems.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

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


def solve_dense(slopes: Sequence[Sequence[float]], residual: Sequence[float]) -> list[float] | None:
    """`-slopes^-1 residual` by elimination with scaled pivots; None where that is not finite."""
    rows = [[*row, -value] for row, value in zip(slopes, residual, strict=True)]
    sizes = [max(map(abs, row[:-1])) for row in rows]
    for k in range(len(rows)):
        best = max(range(k, len(rows)), key=lambda i: abs(rows[i][k]) / (sizes[i] or 1.0))
        if rows[best][k] == 0 or not math.isfinite(rows[best][k]):
            return None
        rows[k], rows[best] = rows[best], rows[k]
        sizes[k], sizes[best] = sizes[best], sizes[k]
        for row in rows[k + 1 :]:
            if row[k] != 0:
                factor = row[k] / rows[k][k]
                row[k:] = [x - factor * y for x, y in zip(row[k:], rows[k][k:], strict=True)]
    x = [0.0] * len(rows)
    for k in reversed(range(len(rows))):
        known = sum(a * b for a, b in zip(rows[k][k + 1 : -1], x[k + 1 :], strict=True))
        x[k] = (rows[k][-1] - known) / rows[k][k]
    return x if all(map(math.isfinite, x)) else None


def soft_motion(
    matrix: Sequence[Sequence[float]], sizes: Sequence[float], least: float, none: float
) -> list[float] | None:
    """A motion along which a matrix, scaled by the roots of `sizes`, has at most the value `least`.

    So has one whose own size is at most `none`. None where all eigenvalues are larger, which a
    Cholesky factorisation of the scaled matrix minus `least` times the identity proves. Where the
    factorisation breaks down, the rows up to there give the motion.
    """
    scale = [size**0.5 if size > none else 0.0 for size in sizes]
    factors: list[list[float]] = []
    for i, row in enumerate(matrix):
        if scale[i] == 0:
            return [float(j == i) for j in range(len(matrix))]
        line: list[float] = []
        for j in range(i):
            known = sum(x * y for x, y in zip(line, factors[j], strict=False))
            line.append((row[j] / (scale[i] * scale[j]) - known) / factors[j][j])
        pivot = row[i] / scale[i] ** 2 - least - sum(x * x for x in line)
        if not pivot > 0:
            for j in reversed(range(i)):
                line[j] /= factors[j][j]
                for m in range(j):
                    line[m] -= factors[j][m] * line[j]
            scaled = [*(-x for x in line), 1.0]
            found = [x / s for x, s in zip(scaled, scale, strict=False)]
            return found + [0.0] * (len(matrix) - len(found))
        factors.append([*line, pivot**0.5])
    return None
