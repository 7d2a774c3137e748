"""Symmetry and definiteness of small matrices of numbers.

Matrices of mechanics mix units (N s/m beside N m s), so they are first scaled by a congruence to a
unit diagonal. It preserves the signs of the eigenvalues and makes one tolerance meaningful.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import mul
from typing import TypeAlias

from bgc.algebra.disjoint_sets import groups_sharing
from bgc.record_class import dataclass

Numbers: TypeAlias = Sequence[Sequence[float]]

_LOOPED_PORTS = 64  # ports of a field that plain loops are quick enough for
TOLERANCE = 1e-9  # of entries and eigenvalues, where the diagonal is scaled to one


@dataclass(frozen=True, slots=True)
class Asymmetry:
    """An entry above the diagonal that differs from its mirror image; places count from 1."""

    row: int
    column: int
    entry: float
    mirror: float


@dataclass(frozen=True, slots=True)
class Pair:
    """An entry beyond what the two on the diagonal allow: `|S[i, j]| > limit`."""

    row: int
    column: int
    entry: float
    limit: float


@dataclass(frozen=True, slots=True)
class Indefinite:
    """The smallest eigenvalue of a symmetric part that is negative, or not positive.

    `direction` is its eigenvector, the largest component 1. `count` is the number of eigenvalues
    at fault. `pair` is the entry that alone makes the matrix indefinite, where there is one.
    """

    eigenvalue: float
    direction: tuple[float, ...]
    count: int
    pair: Pair | None


def find_asymmetry(matrix: Numbers) -> Asymmetry | None:
    """The entry that differs most from its mirror image, relative to the two diagonals."""
    worst, found = TOLERANCE, None
    for i, row in enumerate(matrix):
        for j in range(i + 1, len(row)):
            entry, mirror = row[j], matrix[j][i]
            difference = abs(entry - mirror)
            if difference == 0 or not math.isfinite(difference):
                continue
            size = max(math.sqrt(abs(row[i] * matrix[j][j])), abs(entry), abs(mirror))
            if difference > worst * size:
                worst, found = difference / size, Asymmetry(i + 1, j + 1, entry, mirror)
    return found


def find_indefinite(matrix: Numbers, *, strictly: bool = False) -> Indefinite | None:
    """Find the reason why the symmetric part of a matrix is not positive semidefinite, if any.

    `strictly` requires a positive definite matrix, but allows rows of zeros: they belong to ports
    without storage. The result is None where entries are not finite.
    """
    if not all(math.isfinite(entry) for row in matrix for entry in row):
        return None
    found = [
        bad
        for places in _blocks(matrix)
        if (bad := _of_block(matrix, places, strictly)) is not None
    ]
    if not found:
        return None
    worst = min(found, key=lambda bad: bad.eigenvalue)
    count = sum(bad.count for bad in found)
    return Indefinite(worst.eigenvalue, worst.direction, count, worst.pair)


def _blocks(matrix: Numbers) -> list[list[int]]:
    """Index sets that off-diagonal entries connect."""
    return groups_sharing(
        [{i, *(j for j, x in enumerate(row) if x != 0)} for i, row in enumerate(matrix)]
    )


def _of_block(matrix: Numbers, places: Sequence[int], strictly: bool) -> Indefinite | None:
    if len(places) == 1:
        entry = matrix[places[0]][places[0]]
        return (
            Indefinite(entry, _spread([1.0], places, len(matrix)), 1, None) if entry < 0 else None
        )
    limit = TOLERANCE if strictly else -TOLERANCE
    if len(places) <= _LOOPED_PORTS and _is_above(matrix, places, limit):
        return None
    import numpy as np  # takes longer to load than most models to check

    block = np.array([[matrix[i][j] for j in places] for i in places])
    block = (block + block.T) / 2
    sizes = np.abs(block)
    scale = np.sqrt(np.where(np.diag(sizes) > 0, np.diag(sizes), sizes.max(axis=1)))
    scale[scale == 0] = 1
    scaled = block / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(scaled)
    if values[0] >= limit:
        return None
    own_values, own_vectors = np.linalg.eigh(block)
    eigenvalue, direction = float(own_values[0]), own_vectors[:, 0]
    if eigenvalue >= 0 and values[0] < -TOLERANCE:  # lost beside much larger ones
        direction = vectors[:, 0] / scale
        eigenvalue = float(direction @ block @ direction / (direction @ direction))
    direction = direction / direction[np.argmax(np.abs(direction))]
    count = int((values < limit).sum())
    pair = _worst_pair(block.tolist(), places)
    return Indefinite(eigenvalue, _spread(direction.tolist(), places, len(matrix)), count, pair)


def _is_above(matrix: Numbers, places: Sequence[int], limit: float) -> bool:
    """Return whether Cholesky factors prove all eigenvalues of the scaled block above a limit."""
    scale = [math.sqrt(matrix[i][i]) if matrix[i][i] > 0 else 0.0 for i in places]
    if 0.0 in scale:
        return False
    rows: list[list[float]] = []
    for a, i in enumerate(places):
        row: list[float] = []
        for b, j in enumerate(places[:a]):
            entry = (matrix[i][j] + matrix[j][i]) / 2 / (scale[a] * scale[b])
            row.append((entry - math.fsum(map(mul, row, rows[b]))) / rows[b][b])
        square = 1 - limit - math.fsum(x * x for x in row)
        if square <= 0:
            return False
        rows.append([*row, math.sqrt(square)])
    return True


def _worst_pair(block: Numbers, places: Sequence[int]) -> Pair | None:
    """The entry that is largest against the root of its two diagonals, if that is not allowed."""
    worst, found = 1 + TOLERANCE, None
    for i, row in enumerate(block):
        for j in range(i + 1, len(row)):
            if row[j] == 0 or min(row[i], block[j][j]) < 0:
                continue
            limit = math.sqrt(row[i] * block[j][j])
            excess = abs(row[j]) / limit if limit else math.inf
            if excess > worst:
                worst, found = excess, Pair(places[i] + 1, places[j] + 1, row[j], limit)
    return found


def _spread(values: Sequence[float], places: Sequence[int], size: int) -> tuple[float, ...]:
    """The components of a block among zeros."""
    found = [0.0] * size
    for place, value in zip(places, values, strict=True):
        found[place] = value
    return tuple(found)
