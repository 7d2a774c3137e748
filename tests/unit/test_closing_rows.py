"""Ranks and least changes of closing rows against NumPy, and the proof of a constant rank."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.dense import (
    damped_change,
    independent_in,
    independent_rows,
    soft_motion,
)
from bgc.algebra.derivatives import gradient
from bgc.equations.closures.contradiction import is_within_reach
from bgc.equations.closures.manifold import Conditions, chosen_rows
from bgc.equations.closures.start_check import _values
from bgc.equations.inertias.rank import _flows_left
from bgc.equations.storage.conditions import Answer, System


def dependent(seed):
    """Seven rows of rank 4 with a row of zeros, of very different lengths."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(7, 4)) @ rng.normal(size=(4, 6))
    rows[3] = 0.0
    return rows * 10.0 ** rng.integers(-4, 5, size=(7, 1))


@pytest.mark.parametrize("seed", range(5))
def test_rows_are_independent_and_the_best_of_them_wanted(seed):
    matrix = dependent(seed)
    found = independent_rows(matrix.tolist(), 1e-9)
    assert len(found) == 4 and 3 not in found
    unit = matrix[found] / np.linalg.norm(matrix[found], axis=1, keepdims=True)
    assert np.linalg.matrix_rank(unit, tol=1e-6) == 4
    doubled = np.vstack([matrix, 3.0 * matrix[found[0]]]).tolist()
    chosen = independent_rows(doubled, 1e-9)
    assert len(chosen) == 4 and not {found[0], 7} <= set(chosen)


@pytest.mark.parametrize("damping", [1e-3, 2.0])
def test_a_damped_change_is_that_of_its_formula(damping):
    rng = np.random.default_rng(1)
    matrix, right = rng.normal(size=(4, 3)), rng.normal(size=4)
    expected = matrix.T @ np.linalg.solve(matrix @ matrix.T + damping * np.eye(4), right)
    found = damped_change(matrix.tolist(), right.tolist(), damping)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert damped_change([[1.0, 0.0], [0.0, 0.0]], [1.0, 1.0], 0.0) == [0.0, 0.0]


def test_pivots_choose_rows_of_a_semidefinite_matrix():
    rng = np.random.default_rng(2)
    root = rng.normal(size=(5, 3))
    root[4] = 0.0
    matrix = root @ root.T
    whole = np.diag(matrix).tolist()
    found = independent_in(matrix.tolist(), whole, 1e-9)
    assert len(found) == 3 and 4 not in found
    assert found[0] == 0  # all begin as their own whole; the first of them is taken
    halved = [2.0 * whole[0], *whole[1:]]
    assert independent_in(matrix.tolist(), halved, 1e-9)[0] == 1


@pytest.mark.parametrize(
    ("rows", "left"),
    [
        ([[0], [0, 1]], set()),
        ([[0], [0, 1], [0, 1, 2]], set()),
        ([[0, 1, 2], [1, 0], [1]], set()),
        ([[0, 1], [0, 1], [2]], {0, 1}),  # two rows that may be the same
        ([[0, -1], [0]], {1}),  # -1: a coefficient of flow 1 that may vanish
        ([], {0, 1, 2}),
    ],
)
def test_rows_determine_a_flow_once_those_before_it_are_known(rows, left):
    variables = SimpleNamespace(certificate=lambda node: None if node < 0 else "proven")
    given = [{abs(k): k for k in row} for row in rows]
    flows = {k for row in given for k in row} if rows else {0, 1, 2}
    assert _flows_left(variables, given, flows) == left


@pytest.mark.parametrize(("kind", "found"), [("momentum", (2.0, 3.0)), ("algebraic", None)])
def test_a_flow_that_a_loop_gives_is_not_compared_before_the_loop_is_solved(kind, found):
    dag = Dag()
    program = SimpleNamespace(dag=dag, states=[SimpleNamespace(kind=kind)])
    given = SimpleNamespace(node=dag.symbol(Kind.STATE, 0), value=dag.const(3))
    assert _values(program, given, {Symbol(Kind.STATE, 0): 2.0}) == found


def test_two_bars_in_one_line_end_the_reach_of_a_chain():
    dag = Dag()
    angles = [dag.symbol(Kind.STATE, k) for k in range(2)]
    nodes = [dag.add(*(dag.call(op, angle) for angle in angles)) for op in (Op.COS, Op.SIN)]
    conditions = Conditions(nodes, [0, 1], [gradient(dag, node, angles) for node in nodes])
    for first, second in ((0.0, 0.0), (0.5, -0.5)):
        point = {Symbol(Kind.STATE, 0): first, Symbol(Kind.STATE, 1): second}
        assert is_within_reach(dag, conditions, point) == (first != second)


def test_what_rounded_data_leave_over_is_neither_a_row_nor_a_mass():
    """Seven digits leave 1e-7 of a coefficient, whose square is the mass that it moves."""
    assert independent_rows([[1.0, 0.0], [0.0, 1e-7]], 1e-7, empty=1e-6) == [0]
    assert independent_rows([[1.0, 0.0], [0.0, 1e-5]], 1e-7, empty=1e-6) == [0, 1]
    assert independent_rows([[1.0, 0.0], [0.0, 1e-8]], 1e-7) == [0, 1]
    assert soft_motion([[49.0, 0.0], [0.0, 4e-14]], [49.0, 4e-14], 1e-9, 49e-14) == [0.0, 1.0]
    assert soft_motion([[49.0, 0.0], [0.0, 4e-12]], [49.0, 4e-12], 1e-9, 49e-14) is None


def test_a_sum_that_cancels_but_for_rounding_follows():
    system = System()
    for k, value in enumerate((0.1, 0.2, 0.3)):
        assert system.insert([*(float(j == k) for j in range(3)), value]) is Answer.ADDS
    assert 0.1 + 0.2 - 0.3 != 0
    assert system.insert([1.0, 1.0, -1.0, 0.0]) is Answer.FOLLOWS
    assert system.insert([1.0, 1.0, -1.0, 1e-6]) is Answer.CONTRADICTS


def test_rows_that_depend_on_others_at_a_point_are_not_chosen_there():
    dag = Dag()
    rows = ((dag.one, dag.zero), (dag.one, dag.zero), (dag.zero, dag.one))
    actions = tuple(tuple(map(dag.neg, column)) for column in zip(*rows, strict=True))
    closures = SimpleNamespace(
        ranks=(2,), chain_of=(0, 0, 0), by_impulse=rows, response=actions, impulses=(0, 1)
    )
    assert chosen_rows(dag, closures, {}) == [0, 2]
