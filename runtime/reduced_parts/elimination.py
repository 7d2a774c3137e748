"""Solve a set of homogeneous linear equations for all variables but some, by priority."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array

_SWEEPS = 8  # of the equilibration
_ZERO = 1e-11  # of a pivot, where the entries of rows and columns are about one


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """All variables by the free ones: `x = by_free @ x[free]`."""

    free: tuple[int, ...]
    by_free: Array


def solve_for(equations: Array, order: Sequence[int]) -> Solution:
    """Solve `equations @ x = 0`; a variable that is late in `order` stays free if it can.

    Gauss-Jordan elimination, column by column in that order, on rows and columns that are scaled
    to entries about one; the pivot is the largest entry of its column in the rows that are left.
    """
    scaled, by_column = _equilibrated(equations)
    rows = scaled[:, list(order)]
    done, pivots = 0, list[int]()
    for column in range(rows.shape[1]):
        if done == len(rows):
            break
        pivot = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[pivot, column]) <= _ZERO:
            rows[done:, column] = 0.0
            continue
        rows[[done, pivot]] = rows[[pivot, done]]
        rows[done, column:] /= rows[done, column]
        others = np.flatnonzero(rows[:, column])
        others = others[others != done]
        rows[others, column:] -= np.outer(rows[others, column], rows[done, column:])
        rows[others, column] = 0.0
        pivots.append(column)
        done += 1
    free = [k for k in range(rows.shape[1]) if k not in set(pivots)]
    by_free = np.zeros((rows.shape[1], len(free)))
    by_free[free, range(len(free))] = 1.0
    by_free[pivots] = -rows[: len(pivots), free]
    found = np.zeros_like(by_free)
    found[list(order)] = by_free
    names = [order[k] for k in free]
    return Solution(tuple(names), by_column[:, None] * found / by_column[names])


def _equilibrated(equations: Array) -> tuple[Array, Array]:
    """Scale rows and columns to largest entries of one, by powers of two; with the columns' scales.

    Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices (2001).
    """
    scaled = equations.copy()
    by_column = np.ones(scaled.shape[1])
    for _ in range(_SWEEPS):
        for axis in (1, 0):
            largest = np.abs(scaled).max(axis=axis, initial=0.0)
            factor = np.exp2(-np.round(np.log2(np.where(largest > 0, largest, 1.0)) / 2))
            scaled = scaled * (factor[:, None] if axis else factor)
            if not axis:
                by_column = by_column * factor
    return scaled, by_column
