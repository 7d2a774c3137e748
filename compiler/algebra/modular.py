"""Solvability of linear systems of nodes, decided by their fingerprints.

A matrix that is singular for all values of its symbols is singular in residues. Any other matrix is
regular in residues, except with a probability of about its size in 2^61.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

from bgc.algebra.fingerprint import PRIME


class Solutions(Enum):
    """Number of solutions of a linear system."""

    ONE = "one"
    NONE = "none"
    MANY = "many"


def solutions_of(rows: Sequence[Sequence[int]], right: Sequence[int]) -> Solutions:
    """Count the solutions of a square system of residues by Gaussian elimination modulo `PRIME`."""
    open_rows = [[*row, value] for row, value in zip(rows, right, strict=True)]
    for column in range(len(right)):
        chosen = next((k for k, row in enumerate(open_rows) if row[column]), None)
        if chosen is None:
            continue
        pivot_row = open_rows.pop(chosen)
        inverse = pow(pivot_row[column], -1, PRIME)
        for row in open_rows:
            if row[column]:
                factor = row[column] * inverse % PRIME
                for k in range(column, len(row)):
                    row[k] = (row[k] - factor * pivot_row[k]) % PRIME
    if not open_rows:
        return Solutions.ONE
    return Solutions.NONE if any(row[-1] for row in open_rows) else Solutions.MANY
