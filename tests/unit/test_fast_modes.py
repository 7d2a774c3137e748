"""Projectors on fast modes, against an ordered Schur form and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import matrix_balance, schur, solve_sylvester

from bgc.runtime.linear.fast_modes import balancing, fast_projector

Real = NDArray[np.float64]


def chain(stiffness: float, damping: float, bodies: int = 12) -> Real:
    """Bodies in a row, every third spring stiff: momenta, then deflections."""
    mass = 10.0 ** np.linspace(0, 5, bodies)
    spring = np.where(np.arange(bodies) % 3 == 1, stiffness, 1e3)
    gap = (np.eye(bodies) - np.eye(bodies, k=-1)) / mass  # rates of deflections by momenta
    pull = -(np.eye(bodies) - np.eye(bodies, k=1))
    resistance = 2 * damping * np.sqrt(spring * mass)
    return np.block([[pull * resistance @ gap, pull * spring], [gap, np.zeros_like(gap)]])


def balanced(matrix: Real) -> Real:
    scale = balancing(matrix)
    return matrix * scale / scale[:, None]


def by_schur(matrix: Real, limit: float) -> tuple[Real, int]:
    triangle, basis, fast = schur(
        matrix, output="real", sort=lambda re, im: math.hypot(re, im) > limit
    )
    coupling = solve_sylvester(
        triangle[:fast, :fast], -triangle[fast:, fast:], triangle[:fast, fast:]
    )
    inner = np.zeros_like(triangle)
    inner[:fast, :fast], inner[:fast, fast:] = np.eye(fast), coupling
    return basis @ inner @ basis.T, fast


@pytest.mark.parametrize("stiffness", [1e5, 1e8, 1e11, 1e14])
@pytest.mark.parametrize("damping", [0, 0.3, 1])
def test_projector_of_a_stiff_chain_is_that_of_an_ordered_schur_form(
    stiffness: float, damping: float
) -> None:
    matrix = balanced(chain(stiffness, damping))
    sizes = np.sort(np.abs(np.linalg.eigvals(matrix)))
    gap = int(np.argmax(sizes[1:] / sizes[:-1]))
    limit = math.sqrt(sizes[gap] * sizes[gap + 1])
    projector, fast, between = fast_projector(matrix, limit)
    exact, count = by_schur(matrix, limit)
    assert (fast, sizes[gap] < between < sizes[gap + 1]) == (count, True)
    np.testing.assert_allclose(projector, exact, atol=1e-9 * np.abs(exact).max())
    np.testing.assert_allclose(projector @ projector, projector, atol=1e-10)


def test_modes_without_a_basis_of_eigenvectors_are_projected_on() -> None:
    """Two equal real modes, as critical damping has them, and two zero ones, as a free body has."""
    turn = np.linalg.qr(np.arange(16.0).reshape(4, 4) ** 2 % 7 + np.eye(4))[0]
    jordan = np.array([[-50, 50, 0, 0], [0, -50, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0.0]])
    projector, fast, _ = fast_projector(turn @ jordan @ turn.T, 10)
    assert fast == 2
    np.testing.assert_allclose(projector, turn @ np.diag([1, 1, 0, 0]) @ turn.T, atol=1e-12)


@pytest.mark.parametrize(("limit", "fast"), [(1e-3, 3), (1.0, 2), (30.0, 0)])
def test_modes_are_parted_at_the_limit(limit: float, fast: int) -> None:
    matrix = np.array([[-20, 5, 1], [0, 7, 3], [0, 0, 0.01]])
    projector, count, _ = fast_projector(matrix, limit)
    assert count == fast
    assert np.trace(projector) == pytest.approx(fast, abs=1e-12)


def test_equal_modes_at_the_limit_stay_together() -> None:
    matrix = np.diag([-10 * (1 + 1e-15), -10 * (1 - 1e-15), -1.0])
    projector, fast, _ = fast_projector(matrix, 10)
    assert fast == 2
    np.testing.assert_allclose(projector, np.diag([1, 1, 0]), atol=1e-12)


def test_what_rounding_hides_is_refused() -> None:
    """Both projectors of this matrix are larger than doubles resolve."""
    matrix = np.triu(np.full((30, 30), 1e6))
    np.fill_diagonal(matrix, np.where(np.arange(30) % 2, 1.0, 1.001))
    with pytest.raises(np.linalg.LinAlgError):
        fast_projector(matrix, 1.0005)


def test_a_balanced_matrix_has_rows_and_columns_alike() -> None:
    matrix = chain(1e14, 0.3)
    scale = balancing(matrix)
    assert (np.log2(scale) % 1 == 0).all()
    off = balanced(matrix) - np.diag(np.diag(matrix))
    ratio = np.linalg.norm(off, axis=0) / np.linalg.norm(off, axis=1)
    assert 0.4 < ratio.min() <= ratio.max() < 2.5
    theirs, _ = matrix_balance(matrix, permute=False)
    assert np.linalg.norm(balanced(matrix)) < 1.2 * np.linalg.norm(theirs)
    np.testing.assert_array_equal(balancing(np.zeros((2, 2))), 1)
