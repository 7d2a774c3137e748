"""Linear algebra of a search for rest: scales of rows, ranks, least solutions."""

from __future__ import annotations

import numpy as np

from bgc.runtime.results.arrays import Array

LEAST_RANK = 1e-12  # of the singular values of scaled rows, in terms of the largest


def row_scales(slope: Array) -> Array:
    """The largest entry of each row; 1 for a row of zeros, whose equation nothing can satisfy."""
    largest: Array = np.abs(slope).max(axis=1, initial=0.0)
    return np.where(largest > 0, largest, 1.0)


def svd(matrix: Array, full: bool = True) -> tuple[Array, Array, Array]:
    """Return U, the singular values and V' of a finite matrix.

    Divide and conquer does not converge on few matrices whose entries differ by many orders of
    magnitude, such as slopes from 1e-59 to 1 of a hydraulic crane: QR iterations take its place.
    """
    try:
        found = np.linalg.svd(matrix, full_matrices=full)
    except np.linalg.LinAlgError:
        from scipy.linalg import svd as by_iterations  # slow to import, and seldom needed

        found = by_iterations(matrix, full_matrices=full, lapack_driver="gesvd")
    left, values, right = found
    return left, values, right


def rank_of(values: Array, size: float) -> int:
    """The number of singular values that count, where the residual is `size`."""
    largest = float(values.max(initial=0.0))
    return int((values > largest * max(LEAST_RANK, min(1e-3, size))).sum())


def leading_rows(matrix: Array, count: int) -> list[int]:
    """Rows that span the others, in the order of pivoted QR: the largest part first."""
    left, found = matrix.copy(), list[int]()
    for _ in range(min(count, len(left))):
        sizes = np.linalg.norm(left, axis=1)
        k = int(np.argmax(sizes))
        if sizes[k] == 0:
            break
        found.append(k)
        along = left[k] / sizes[k]
        left -= np.outer(left @ along, along)
        left[k] = 0.0
    return found


def least(matrix: Array, wanted: Array, size: float = 0.0) -> tuple[Array, Array]:
    """The least of the best solutions of `matrix x = wanted`, and a basis of what is free.

    Entries of the matrix have rounding errors of numbers of magnitude `size`.
    """
    left, values, right = svd(matrix)
    count = int((values > 1e-9 * max(size, values.max(initial=0.0))).sum())
    x: Array = right[:count].T @ ((left[:, :count].T @ wanted) / values[:count])
    return x, right[count:].T
