"""`Reduction` against row echelon forms in rationals, and its columns against its rows."""

import random
from fractions import Fraction

import pytest

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.reduction import Reduction


def echelon(rows):
    """The reduced row echelon form of dense rows, without rows of zeros."""
    rows, done = [list(row) for row in rows], 0
    for column in range(len(rows[0])):
        place = next((i for i in range(done, len(rows)) if rows[i][column]), None)
        if place is None:
            continue
        rows[done], rows[place] = rows[place], rows[done]
        rows[done] = [x / rows[done][column] for x in rows[done]]
        for i, row in enumerate(rows):
            if i != done:
                rows[i] = [x - row[column] * y for x, y in zip(row, rows[done], strict=True)]
        done += 1
    return rows[:done]


@pytest.mark.parametrize("seed", range(20))
def test_eliminating_columns_keeps_the_space_of_the_rows(seed):
    rng, dag = random.Random(seed), Dag()
    height, width = rng.randint(1, 5), rng.randint(1, 6)
    matrix = [[Fraction(rng.randint(-2, 2)) for _ in range(width)] for _ in range(height)]
    matrix.append([sum(column) for column in zip(*matrix, strict=True)])  # which depends on them
    rows = [{j: dag.const(x) for j, x in enumerate(row)} for row in matrix]
    reduction = Reduction(dag, Fingerprints(dag), rows)
    taken = {}
    while candidates := [
        (i, j) for i, row in enumerate(reduction.rows) if i not in taken for j in row
    ]:
        i, j = rng.choice(candidates)
        reduction.eliminate(i, j)
        taken[i] = j
        assert reduction.holding[j] == {i}
    for j, holding in reduction.holding.items():
        assert holding == {i for i, row in enumerate(reduction.rows) if j in row}
    dense = [[dag.value(row.get(j, dag.zero)) for j in range(width)] for row in reduction.rows]
    assert echelon(dense) == echelon(matrix)
