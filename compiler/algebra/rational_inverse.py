"""The inverse of a matrix of rational numbers, each entry exact or its nearest double.

Gauss-Jordan elimination in fractions is exact, but the length of its numbers grows with each pivot:
for a full matrix of n rows of decimals it takes nearly n^5. From `_MODULAR_ROWS` rows on,
elimination therefore ends where its numbers exceed `_MOST_BITS` bits. The inverse is then found in
numbers of fixed length by Newton's iteration (Schulz 1933)

    X := X + X (I - A X),

which doubles the correct bits, in n^3 products a round. The residual R = I - A X bounds the error:
`|X - A^-1| <= |X| |R| / (1 - |R|)` in the norm of the largest sum of a row. Where it does not
certify each entry to much more than a double, elimination is finished in fractions.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from fractions import Fraction
from operator import mul
from typing import TypeAlias

from bgc.algebra.evaluate import to_double

Rows: TypeAlias = Sequence[Sequence[Fraction]]

_MODULAR_ROWS = 8  # rows
_MOST_BITS = 512  # bits of a numerator and denominator
_BITS = 384  # of the fixed-point numbers, behind the point
_ROUNDS = 9  # from a residual of 1/2 to one of 2^-256
_CERTAIN = 60  # bits of an entry that its error leaves


class SingularRowsError(Exception):
    """The matrix is singular."""


def inverse_of(matrix: Rows) -> list[list[Fraction]]:
    """The inverse of a square matrix; entries of a long calculation are the nearest doubles.

    Raises
    ------
    SingularRowsError
        The matrix is singular.
    """
    if len(matrix) < _MODULAR_ROWS:
        return _eliminated(matrix, None)
    try:
        return _eliminated(matrix, _MOST_BITS)
    except _LongError:
        return _by_newton(matrix) or _eliminated(matrix, None)


class _LongError(Exception):
    """The numbers of an elimination are longer than allowed."""


def _eliminated(matrix: Rows, longest: int | None) -> list[list[Fraction]]:
    """Gauss-Jordan in fractions; raises as soon as a pivot's row has more bits than `longest`."""
    size = len(matrix)
    table = [[*row, *(Fraction(int(i == j)) for j in range(size))] for i, row in enumerate(matrix)]
    for k in range(size):
        chosen = next((i for i in range(k, size) if table[i][k] != 0), None)
        if chosen is None:
            raise SingularRowsError
        table[k], table[chosen] = table[chosen], table[k]
        pivot = table[k][k]
        table[k] = [entry / pivot for entry in table[k]]
        if longest is not None and any(_bits(entry) > longest for entry in table[k]):
            raise _LongError
        for i in range(size):
            factor = table[i][k]
            if i != k and factor != 0:
                table[i] = [x - factor * y for x, y in zip(table[i], table[k], strict=True)]
    return [row[size:] for row in table]


def _bits(value: Fraction) -> int:
    return value.numerator.bit_length() + value.denominator.bit_length()


# --- Newton's iteration -------------------------------------------------------------------------


def _by_newton(matrix: Rows) -> list[list[Fraction]] | None:
    """The inverse as doubles; None where its entries are not certified or no normal doubles."""
    size = range(len(matrix))
    rows, columns = _scales(matrix)
    scaled = [[matrix[i][j] * _power(-rows[i] - columns[j]) for j in size] for i in size]
    fixed = [[round(entry * 2**_BITS) for entry in row] for row in scaled]
    first = _in_doubles([[to_double(entry) for entry in row] for row in scaled])
    if first is None:
        return None
    solution = _refined(fixed, [[round(Fraction(x) * 2**_BITS) for x in row] for row in first])
    if solution is None:
        return None
    found, error = solution
    result = [[Fraction(0)] * len(matrix) for _ in size]
    symmetric = all(matrix[i][j] == matrix[j][i] for i in size for j in range(i))
    for i in size:
        for j in size:
            if symmetric and j < i:
                result[i][j] = result[j][i]
                continue
            if abs(found[i][j]) < error << _CERTAIN:
                return None  # zero, or too small beside the others
            exact = Fraction(found[i][j], 2**_BITS) * _power(-columns[i] - rows[j])
            double = to_double(exact)
            if not sys.float_info.min <= abs(double) < math.inf:
                return None
            result[i][j] = Fraction(double)
    return result


def _power(exponent: int) -> Fraction:
    """A power of two."""
    return Fraction(2**exponent) if exponent >= 0 else Fraction(1, 2**-exponent)


def _scales(matrix: Rows) -> tuple[list[int], list[int]]:
    """Exponents of two of rows and columns, without which all entries are near or below one.

    Those of a matrix with a full diagonal make its diagonal one, as a matrix of inertias in
    different units needs it; of any other, the largest of each row and column.
    """
    size = range(len(matrix))
    if all(matrix[k][k] != 0 for k in size):
        own = [_exponent(matrix[k][k]) for k in size]
        return [each // 2 for each in own], [each - each // 2 for each in own]
    rows = [max((_exponent(x) for x in row if x != 0), default=0) for row in matrix]
    columns = [
        max((_exponent(matrix[i][j]) - rows[i] for i in size if matrix[i][j] != 0), default=0)
        for j in size
    ]
    return rows, columns


def _exponent(value: Fraction) -> int:
    return value.numerator.bit_length() - value.denominator.bit_length()


def _in_doubles(matrix: Sequence[Sequence[float]]) -> list[list[float]] | None:
    """The inverse by Gauss-Jordan with the largest pivot of each column; None if one is zero."""
    size = len(matrix)
    table = [[*row, *(float(i == j) for j in range(size))] for i, row in enumerate(matrix)]
    for k in range(size):
        chosen = max(range(k, size), key=lambda i: abs(table[i][k]))
        table[k], table[chosen] = table[chosen], table[k]
        pivot = table[k][k]
        if pivot == 0:
            return None
        table[k] = [entry / pivot for entry in table[k]]
        for i in range(size):
            factor = table[i][k]
            if i != k and factor != 0:
                table[i] = [x - factor * y for x, y in zip(table[i], table[k], strict=True)]
    result = [row[size:] for row in table]
    return result if all(math.isfinite(x) for row in result for x in row) else None


def _refined(
    matrix: Sequence[Sequence[int]], start: list[list[int]]
) -> tuple[list[list[int]], int] | None:
    """The inverse in fixed-point numbers with a bound on its error; None if it does not converge.

    The bound includes the rounding of the entries of the matrix to fixed-point numbers.
    """
    found, one = start, 1 << _BITS
    for _ in range(_ROUNDS):
        residual = _product(matrix, found)
        for i, row in enumerate(residual):
            row[:] = [(one if i == j else 0) - entry for j, entry in enumerate(row)]
        size = _norm(found)
        rounding = len(matrix) * (size + 2 * one >> _BITS) + 1
        left = _norm(residual) + rounding
        if 2 * left >= one:
            return None
        if left <= 4 * rounding or left < one >> 2 * _BITS // 3:
            return found, (2 * size * left >> _BITS) + 1
        change = _product(found, residual)
        found = [
            [x + y for x, y in zip(row, more, strict=True)]
            for row, more in zip(found, change, strict=True)
        ]
    return None


def _product(left: Sequence[Sequence[int]], right: Sequence[Sequence[int]]) -> list[list[int]]:
    columns = list(zip(*right, strict=True))
    return [[sum(map(mul, row, column)) >> _BITS for column in columns] for row in left]


def _norm(matrix: Sequence[Sequence[int]]) -> int:
    """The largest sum of the absolute values of a row."""
    return max(sum(map(abs, row)) for row in matrix)
