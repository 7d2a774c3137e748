"""Solvability of linear systems of nodes, decided by their fingerprints.

A matrix that is singular for all values of its symbols is singular in residues. Any other matrix is
regular in residues, except with a probability of about its size in 2^61.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from heapq import heapify, heappop, heappush
from typing import TypeVar

from bgc.algebra.fingerprint import PRIME

_Column = TypeVar("_Column")


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


def rank_of(rows: Sequence[Mapping[_Column, int]]) -> int:
    """The rank of a sparse matrix modulo the prime; shortest rows are solved first."""
    work: list[dict[_Column, int]] = [{c: x for c, x in row.items() if x} for row in rows]
    where: dict[_Column, set[int]] = {}
    for i, row in enumerate(work):
        for column in row:
            where.setdefault(column, set()).add(i)
    queue = [(len(row), i) for i, row in enumerate(work)]
    heapify(queue)
    rank = 0
    while queue:
        length, i = heappop(queue)
        row = work[i]
        if length != len(row) or not row:
            if row:
                heappush(queue, (len(row), i))
            continue
        rank += 1
        column = min(row, key=lambda c: len(where[c]))
        inverse = pow(row[column], -1, PRIME)
        for c in row:
            where[c].discard(i)
        for r in where.pop(column):
            factor = work[r].pop(column) * inverse % PRIME
            for c, x in row.items():
                if c == column:
                    continue
                left = (work[r].get(c, 0) - factor * x) % PRIME
                if left:
                    work[r][c] = left
                    where[c].add(r)
                elif c in work[r]:
                    del work[r][c]
                    where[c].discard(r)
            heappush(queue, (len(work[r]), r))
        work[i] = {}
    return rank
