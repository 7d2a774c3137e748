"""Matrices of nodes: NumPy's results, exact zeros, symmetric inverses."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.linalg import (
    Matrix,
    inverse,
    transpose,
)


def numbers(dag: Dag, matrix: Matrix, values: dict[Symbol, float]) -> npt.NDArray[np.float64]:
    nodes = [node for row in matrix for node in row]
    return np.array(evaluate_nodes(dag, nodes, values)).reshape(len(matrix), -1)


def parameters(dag: Dag, array: npt.NDArray[np.float64]) -> tuple[Matrix, dict[Symbol, float]]:
    """The nonzero entries as parameters, equal entries across the diagonal as one."""
    values: dict[Symbol, float] = {}
    rows = []
    for i, row in enumerate(array):
        nodes = []
        for j, entry in enumerate(row):
            low, high = (min(i, j), max(i, j)) if entry == array[j, i] else (i, j)
            index = low * len(array) + high
            node = dag.zero if entry == 0 else dag.symbol(Kind.PARAM, index)
            values[Symbol(Kind.PARAM, index)] = float(entry)
            nodes.append(node)
        rows.append(tuple(nodes))
    return tuple(rows), values


@st.composite
def arrays(draw: st.DrawFn, symmetric: bool) -> npt.NDArray[np.float64]:
    """Sparse, well-conditioned, some rows swapped when not symmetric."""
    size = draw(st.integers(1, 7))
    seed = np.random.default_rng(draw(st.integers(0, 10**6)))
    array = seed.normal(size=(size, size)) * (seed.random((size, size)) < 0.4)
    array += np.diag(4 * np.sign(seed.normal(size=size)) if not symmetric else np.full(size, 8.0))
    if symmetric:
        return np.triu(array) + np.triu(array, 1).T
    return array[seed.permutation(size)]


@given(arrays(symmetric=True))
@settings(max_examples=60, deadline=None)
def test_symmetric_inverse_is_symmetric_node_for_node(array: npt.NDArray[np.float64]) -> None:
    dag = Dag()
    matrix, values = parameters(dag, array)
    result = inverse(dag, matrix)
    assert result == transpose(result)
    np.testing.assert_allclose(
        numbers(dag, result, values), np.linalg.inv(array), rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize("zeros", [False, True])
def test_large_symmetric_matrices_need_half_the_operations(zeros: bool) -> None:
    size, seed = 12, np.random.default_rng(5)
    basis = seed.normal(size=(size, size)) * np.logspace(0, -4, size)[:, None]
    array = basis.T @ basis  # of a condition number near 1e8 and more
    if zeros:
        array = np.triu(np.where(seed.random((size, size)) < 0.3, array, 0), 1)
        array = array + array.T + np.diag(np.linspace(30, 60, size))
        array[0, :] = array[:, 0] = 1.0
        array[0, 0] = 50.0
    dag = Dag()
    matrix, values = parameters(dag, (array + array.T) / 2)
    first = len(dag)
    found = inverse(dag, matrix)
    made = len(dag) - first
    assert made <= size**3 + 2 * size**2
    assert all(found[i][j] == found[j][i] for i in range(size) for j in range(i))
    expected = np.linalg.inv(array)
    error = np.abs(numbers(dag, found, values) - expected).max() / np.abs(expected).max()
    assert error < 4e-16 * np.linalg.cond(array)


def test_zero_entries_stay_zero_and_are_never_divided_by() -> None:
    dag = Dag()
    a, b = dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.PARAM, 1)
    matrix = ((dag.zero, a, dag.zero), (b, dag.zero, dag.zero), (dag.zero, dag.zero, dag.const(4)))
    result = inverse(dag, matrix)
    reciprocal_a, reciprocal_b = dag.div(dag.one, a), dag.div(dag.one, b)
    assert result[0] == (dag.zero, reciprocal_b, dag.zero)
    assert result[1] == (reciprocal_a, dag.zero, dag.zero)
    assert result[2] == (dag.zero, dag.zero, dag.const(Fraction(1, 4)))


def test_rotation_is_inverted_without_dividing_by_its_entries() -> None:
    dag = Dag()
    angle = dag.symbol(Kind.PARAM)
    cos, sin = dag.call(Op.COS, angle), dag.call(Op.SIN, angle)
    matrix = ((cos, dag.neg(sin)), (sin, cos))
    values = {Symbol(Kind.PARAM, 0): np.pi / 2}
    found = numbers(dag, inverse(dag, matrix), values)
    np.testing.assert_allclose(found, [[0, 1], [-1, 0]], atol=1e-15)
