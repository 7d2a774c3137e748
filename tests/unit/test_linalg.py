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
    SingularMatrixError,
    apply,
    diagonal,
    identity,
    inverse,
    multiply,
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


@given(arrays(symmetric=False))
@settings(max_examples=60, deadline=None)
def test_inverse_of_parameters(array: npt.NDArray[np.float64]) -> None:
    dag = Dag()
    matrix, values = parameters(dag, array)
    found = numbers(dag, inverse(dag, matrix), values)
    np.testing.assert_allclose(found @ array, np.eye(len(array)), atol=1e-8)


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


def test_a_large_symmetric_matrix_with_zeros_on_its_diagonal() -> None:
    size = 8
    array = np.random.default_rng(2).normal(size=(size, size))
    array = array + array.T - 2 * np.diag(np.diag(array))
    array[0, 1:] = array[1:, 0] = np.arange(1, size)
    array[-3:, -3:] = 0
    dag = Dag()
    matrix, values = parameters(dag, array)
    found = numbers(dag, inverse(dag, matrix), values)
    assert np.allclose(found, np.linalg.inv(array), rtol=1e-9, atol=1e-9)


def test_rigid_body_inertia_of_parameters() -> None:
    """The 6 x 6 mass matrix of a body with an offset centre of mass (eq. 2 of the paper)."""
    dag = Dag()
    m, x, y, z = (dag.symbol(Kind.PARAM, k) for k in range(4))
    moments = [dag.symbol(Kind.PARAM, 4 + k) for k in range(3)]
    cross = ((dag.zero, dag.neg(z), y), (z, dag.zero, dag.neg(x)), (dag.neg(y), x, dag.zero))
    mass = [[dag.zero] * 6 for _ in range(6)]
    for i in range(3):
        mass[i][i], mass[3 + i][3 + i] = m, moments[i]
        for j in range(3):
            mass[3 + i][j] = dag.mul(m, cross[i][j])
            mass[i][3 + j] = dag.neg(dag.mul(m, cross[i][j]))
    matrix = tuple(map(tuple, mass))
    assert matrix == transpose(matrix)
    result = inverse(dag, matrix)
    assert result == transpose(result)
    values = dict(
        zip(
            (Symbol(Kind.PARAM, k) for k in range(7)),
            (8000.0, 6.0, 0.0, 0.5, 900.0, 4e5, 5e5),
            strict=True,
        )
    )
    product = numbers(dag, result, values) @ numbers(dag, matrix, values)
    np.testing.assert_allclose(product, np.eye(6), atol=1e-9)
    assert len(dag) < 600


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


def test_saddle_point_with_zero_diagonal() -> None:
    dag = Dag()
    array = np.array([[2.0, 0, 0, 1], [0, 3, 0, 1], [0, 0, 5, 1], [1, 1, 1, 0]])
    matrix, values = parameters(dag, array)
    found = numbers(dag, inverse(dag, matrix), values)
    np.testing.assert_allclose(found, np.linalg.inv(array), atol=1e-14)


def test_constants_are_inverted_exactly() -> None:
    dag = Dag()
    hilbert = tuple(tuple(dag.const(Fraction(1, i + j + 1)) for j in range(6)) for i in range(6))
    result = inverse(dag, hilbert)
    assert dag.value(result[5][5]) == 698544
    assert multiply(dag, hilbert, result) == identity(dag, 6)


@pytest.mark.parametrize(
    "rows", [[[1, 2], [2, 4]], [[0, 0], [0, 1]], [[0]], [[1, 2, 3], [4, 5, 6], [7, 8, 9]]]
)
def test_singular_constants_are_found(rows: list[list[int]]) -> None:
    dag = Dag()
    with pytest.raises(SingularMatrixError):
        inverse(dag, tuple(tuple(dag.const(x) for x in row) for row in rows))


def test_singular_constants_that_are_not_rational_are_found() -> None:
    dag = Dag()
    root = dag.call(Op.SQRT, dag.const(2))
    with pytest.raises(SingularMatrixError):
        inverse(dag, ((root, root), (root, root)))


def test_structurally_singular_parameters_are_found() -> None:
    dag = Dag()
    a, b = dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.PARAM, 1)
    with pytest.raises(SingularMatrixError):
        inverse(dag, ((a, b), (dag.zero, dag.zero)))
    with pytest.raises(SingularMatrixError):
        inverse(dag, ((a, a), (a, a)))


def test_products_and_transposes() -> None:
    dag = Dag()
    left = ((1, 2, 3), (4, 5, 6))
    nodes = tuple(tuple(dag.const(x) for x in row) for row in left)
    product = multiply(dag, nodes, transpose(nodes))
    assert [[dag.value(x) for x in row] for row in product] == [[14, 32], [32, 77]]
    assert product == transpose(product)
    vector = apply(dag, nodes, [dag.one, dag.zero, dag.one])
    assert [dag.value(x) for x in vector] == [4, 10]
    assert diagonal(dag, [dag.one, dag.one]) == identity(dag, 2)
