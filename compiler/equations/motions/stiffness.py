"""A numerical check of the common stiffness of merged compliances, at a random point.

`B' K B` of positive stiffnesses is symmetric positive definite, and is solved as such. An
indefinite one (of a field without an energy, or with a negative stiffness) may still determine the
charges. A singular or nearly singular one does not.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from enum import Enum

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import Evaluator
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node

_LEAST_PIVOT = 1e-9  # eigenvalue or pivot, of the matrix scaled to a diagonal of ones or less
_EQUAL = 1e-12


class Stiffness(Enum):
    """The verdict on a matrix: definite, regular or singular."""

    DEFINITE = "symmetric positive definite"
    REGULAR = "to be solved with pivots"
    SINGULAR = "singular, or nearly"


def judge_stiffness(
    variables: Variables,
    matrix: Sequence[Mapping[int, Node]],
    parts: Sequence[Sequence[Node]],
) -> Stiffness:
    """Judge a sparse matrix of nodes at a random state, parameters at their defaults.

    `parts` are those that the entries of its diagonal are sums of: their sizes are its scale.
    """
    dag = variables.dag

    def leaf(symbol: Symbol) -> float:
        if symbol.kind is Kind.PARAM:
            return variables.default(dag.symbol(symbol.kind, symbol.index))
        return random.Random(f"{symbol.kind} {symbol.index}").uniform(0.2, 1)

    numbers = Evaluator(dag, leaf)
    table = [[0.0] * len(matrix) for _ in matrix]
    for i, row in enumerate(matrix):
        for j, node in row.items():
            table[i][j] = numbers.value(node)
    if not all(math.isfinite(x) for row in table for x in row):
        return Stiffness.REGULAR  # nothing can be said at this point
    sizes = [math.fsum(abs(numbers.value(node)) for node in terms) for terms in parts]
    table = _scaled(table, sizes)
    if _is_definite(table):
        return Stiffness.DEFINITE
    return Stiffness.REGULAR if _least_pivot(table) > _LEAST_PIVOT else Stiffness.SINGULAR


def _scaled(table: Sequence[Sequence[float]], sizes: Sequence[float]) -> list[list[float]]:
    """The same with a diagonal of ones, less where parts of it cancel."""
    scale = [math.sqrt(size) or 1.0 for size in sizes]
    return [
        [x / (a * b) for x, b in zip(row, scale, strict=True)]
        for row, a in zip(table, scale, strict=True)
    ]


def _is_definite(table: Sequence[Sequence[float]]) -> bool:
    """Return whether a matrix is symmetric and positive, by Cholesky with a small margin."""
    factors: list[list[float]] = []
    for i, row in enumerate(table):
        if any(abs(row[j] - table[j][i]) > _EQUAL for j in range(i)):
            return False
        line: list[float] = []
        for j in range(i):
            known = sum(x * y for x, y in zip(line, factors[j], strict=False))
            line.append((row[j] - known) / factors[j][j])
        square = row[i] - _LEAST_PIVOT - sum(x * x for x in line)
        if not square > 0:
            return False
        factors.append([*line, math.sqrt(square)])
    return True


def _least_pivot(table: Sequence[Sequence[float]]) -> float:
    """The smallest pivot of Gaussian elimination with partial pivoting."""
    rows = [list(row) for row in table]
    least = math.inf
    for k in range(len(rows)):
        best = max(range(k, len(rows)), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        pivot = rows[k][k]
        least = min(least, abs(pivot))
        if pivot == 0:
            break
        for row in rows[k + 1 :]:
            factor = row[k] / pivot
            row[k:] = [x - factor * y for x, y in zip(row[k:], rows[k][k:], strict=True)]
    return least
