"""The inverse of a matrix of doubles, as `runtime/c/bgc_inverse.h` computes it."""

from __future__ import annotations

import math
from collections.abc import Sequence

_ROUNDING = 2.0**-48  # a pivot below this share of the terms that it is the sum of is zero


def inverse_in_doubles(entries: Sequence[float]) -> list[float]:
    """The inverse of a square matrix, given and returned row by row.

    Gauss-Jordan elimination in place; the pivot is the largest entry of a column in terms of its
    row's largest entry. All entries are NaN where the matrix is singular but for rounding.
    """
    size = math.isqrt(len(entries))
    table = [list(entries[size * i : size * (i + 1)]) for i in range(size)]
    terms = [list(map(abs, row)) for row in table]
    scale = [max(row) for row in terms]
    order = list(range(size))
    for k in range(size):
        chosen = max(range(k, size), key=lambda i: _share(table[i][k], scale[i]))
        if not abs(table[chosen][k]) > _ROUNDING * terms[chosen][k]:
            return [math.nan] * len(entries)
        table[k], table[chosen] = table[chosen], table[k]
        terms[k], terms[chosen] = terms[chosen], terms[k]
        scale[k], scale[chosen] = scale[chosen], scale[k]
        order[k], order[chosen] = order[chosen], order[k]
        pivot, row = table[k][k], table[k]
        row[k] = 1.0
        row[:] = [x / pivot for x in row]
        sizes = list(map(abs, row))
        for i, other in enumerate(table):
            factor = other[k]
            if i != k and factor != 0:
                other[k] = 0.0
                other[:] = [x - factor * y for x, y in zip(other, row, strict=True)]
                if i > k:
                    grown = abs(factor)
                    terms[i] = [t + grown * y for t, y in zip(terms[i], sizes, strict=True)]
    result = [0.0] * len(entries)
    for i, row in enumerate(table):
        for j, column in enumerate(order):
            result[size * i + column] = row[j]
    return result


def _share(entry: float, scale: float) -> float:
    """The size of an entry in terms of its row's largest."""
    return abs(entry) / scale if scale > 0 else 0.0
