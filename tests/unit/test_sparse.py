"""The symbolic factorisation: pivots, fill and cost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bgc.emission.sparse import plan_pattern
from bgc.ir.lowered import LuPlan


def eliminate(plan: LuPlan, matrix: np.ndarray) -> np.ndarray:
    """L and U in one matrix, computed on the plan's pattern only."""
    size = len(plan.rows)
    work = matrix[np.ix_(plan.rows, plan.columns)].copy()
    kept = np.zeros_like(work, dtype=bool)
    for k in range(size):
        kept[k, [*plan.lower[k], k, *plan.upper[k]]] = True
    assert not work[~kept].any()
    for k in range(size):
        for j in plan.lower[k]:
            work[k, j] /= work[j, j]
            work[k, j + 1 :] -= work[k, j] * work[j, j + 1 :]
        assert not work[k][~kept[k]].any(), "an entry outside the planned fill"
    return work


@given(
    size=st.integers(1, 12),
    others=st.sets(st.tuples(st.integers(0, 11), st.integers(0, 11)), max_size=40),
    seed=st.integers(0, 2**16),
)
@settings(max_examples=60, deadline=None)
def test_the_fill_holds_every_factor(size: int, others: set[tuple[int, int]], seed: int) -> None:
    others = {(i, j) for i, j in others if i < size and j < size}
    plan = plan_pattern(size, {(i, i) for i in range(size)}, others)
    assert plan.rows == plan.columns
    matrix = np.zeros((size, size))
    rng = np.random.default_rng(seed)
    for i, j in {*others, *((i, i) for i in range(size))}:
        matrix[i, j] = rng.uniform(0.5, 1) + (20 if i == j else 0)
    work = eliminate(plan, matrix)
    product = (np.tril(work, -1) + np.eye(size)) @ np.triu(work)
    np.testing.assert_allclose(product, matrix[np.ix_(plan.rows, plan.columns)], atol=1e-12)


@given(st.permutations(range(8)), st.integers(0, 2**16))
@settings(max_examples=40, deadline=None)
def test_a_permutation_is_matched(permutation: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    extra = {(int(i), int(j)) for i, j in rng.integers(0, 8, (6, 2))}
    pattern = {(i, j) for i, j in enumerate(permutation)} | extra
    plan = plan_pattern(8, (), pattern)
    assert sorted(plan.rows) == sorted(plan.columns) == list(range(8))
    for k, (row, column) in enumerate(zip(plan.rows, plan.columns, strict=True)):
        assert (row, column) in pattern or plan.lower[k]


def test_the_diagonal_is_preferred() -> None:
    plan = plan_pattern(2, {(0, 1), (1, 0)}, {(0, 0), (1, 1), (1, 0)})
    assert sorted(zip(plan.rows, plan.columns, strict=True)) == [(0, 0), (1, 1)]


def test_pivots_are_among_what_is_surely_there() -> None:
    sure = {(0, 2), (1, 0), (2, 1)}
    plan = plan_pattern(3, sure, {(0, 1), (1, 2), (2, 0)})
    assert set(zip(plan.rows, plan.columns, strict=True)) == sure


def test_a_row_without_a_pivot_is_a_bug_upstream() -> None:
    with pytest.raises(AssertionError, match="singular"):
        plan_pattern(2, {(0, 0)}, {(1, 0)})


def test_an_arrow_is_eliminated_from_its_tips() -> None:
    """Dense first row and column: the natural order fills in, Markowitz does not."""
    size = 50
    arrow = {(0, i) for i in range(size)} | {(i, 0) for i in range(size)}
    plan = plan_pattern(size, {(i, i) for i in range(size)}, arrow)
    assert plan.entries == 3 * size - 2
    assert 0 in plan.rows[-2:]


def test_a_chain_of_thousands_has_no_fill() -> None:
    size = 4000
    band = {(i, i + 1) for i in range(size - 1)} | {(i + 1, i) for i in range(size - 1)}
    plan = plan_pattern(size, {(i, i) for i in range(size)}, band)
    assert plan.entries == 3 * size - 2
    assert plan.operations < 5 * size
