"""The inverse of a matrix of residues."""

from __future__ import annotations

from collections.abc import Sequence


def inverse_of_residues(entries: Sequence[int], modulus: int) -> list[int] | None:
    """The inverse of a square matrix, given and returned row by row; None if it is singular.

    Gauss-Jordan elimination in place. The modulus is a prime, or a product of large primes: an
    entry that only one of them divides counts as zero.
    """
    size = next(n for n in range(len(entries) + 1) if n * n == len(entries))
    table = [list(entries[size * i : size * (i + 1)]) for i in range(size)]
    order = list(range(size))
    for k in range(size):
        chosen, reciprocal = _pivot(table, k, modulus)
        if reciprocal == 0:
            return None
        table[k], table[chosen] = table[chosen], table[k]
        order[k], order[chosen] = order[chosen], order[k]
        row = table[k]
        row[k] = 1
        table[k] = row = [x * reciprocal % modulus for x in row]
        for i, other in enumerate(table):
            factor = other[k]
            if i != k and factor:
                other[k] = 0
                table[i] = [(x - factor * y) % modulus for x, y in zip(other, row, strict=True)]
    result = [0] * len(entries)
    for i, row in enumerate(table):
        for j, column in enumerate(order):
            result[size * i + column] = row[j]
    return result


def _pivot(table: Sequence[Sequence[int]], k: int, modulus: int) -> tuple[int, int]:
    """The first row from k on with an entry of column k that has a reciprocal, and that; else 0."""
    for i in range(k, len(table)):
        try:
            return i, pow(table[i][k], -1, modulus)
        except ValueError:  # zero modulo one of the primes
            continue
    return k, 0
