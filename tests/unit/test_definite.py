"""Symmetry and definiteness against numpy's eigenvalues."""

import numpy as np
import pytest

from bgc.passivity.definite import find_asymmetry, find_indefinite


def random_symmetric(rng: np.random.Generator, eigenvalues: list[float]) -> np.ndarray:
    turn, _ = np.linalg.qr(rng.normal(size=(len(eigenvalues), len(eigenvalues))))
    return turn @ np.diag(eigenvalues) @ turn.T


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("size", [2, 3, 6, 70])
def test_the_verdict_and_the_eigenvalue_are_numpys(seed, size):
    rng = np.random.default_rng(seed)
    eigenvalues = rng.uniform(0.1, 5, size)
    if seed % 2:
        eigenvalues[0] = -0.3
    skew = rng.normal(size=(size, size))
    matrix = random_symmetric(rng, eigenvalues) + skew - skew.T
    bad = find_indefinite(matrix.tolist())
    assert (bad is not None) == bool(seed % 2)
    if bad is not None:
        assert bad.eigenvalue == pytest.approx(-0.3)
        along = np.array(bad.direction)
        assert np.abs(along).max() == 1
        np.testing.assert_allclose((matrix + matrix.T) / 2 @ along, -0.3 * along, atol=1e-9)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_units_of_the_ports_do_not_change_the_verdict(scale):
    units = np.array([1, scale, scale**2])
    matrix = np.outer(units, units) * np.array([[2, 1, 0], [1, 2, 1.999], [0, 1.999, 2]])
    assert (find_indefinite(matrix.tolist()) is not None) == (
        np.linalg.eigvalsh(matrix / np.outer(units, units))[0] < 0
    )


def test_a_field_that_leaves_a_direction_free_is_semidefinite():
    rods = np.array([[1.0, 2, 3], [2, 4, 6], [3, 6, 9]])
    assert find_indefinite(rods.tolist()) is None
    assert find_indefinite(rods.tolist(), strictly=True) is not None
    assert find_indefinite([[0.0, 0], [0, 0]]) is None


def test_a_zero_on_the_diagonal_beside_a_coupling_is_indefinite():
    bad = find_indefinite([[0.0, 1], [1, 5]])
    assert bad is not None and bad.pair is not None
    assert (bad.pair.row, bad.pair.column, bad.pair.limit) == (1, 2, 0)


def test_the_pair_at_fault_is_named_where_one_pair_is():
    bad = find_indefinite([[4.0, 0, 7], [0, 1, 0], [7, 0, 9]])
    assert bad is not None and bad.pair is not None
    assert (bad.pair.row, bad.pair.column, bad.pair.entry, bad.pair.limit) == (1, 3, 7, 6)
    three = np.full((3, 3), -0.6) + 1.6 * np.eye(3)  # each pair is allowed, not all together
    bad = find_indefinite(three.tolist())
    assert bad is not None and bad.pair is None
    assert bad.eigenvalue == pytest.approx(1 - 2 * 0.6)


def test_all_negative_eigenvalues_are_counted_over_the_blocks():
    bad = find_indefinite([[-1.0, 0, 0], [0, 1, 2], [0, 2, 1]])
    assert bad is not None and (bad.count, bad.direction) == (2, (1.0, 0.0, 0.0))


def test_what_is_not_finite_says_nothing():
    assert find_indefinite([[float("nan"), 1.0], [1.0, -1.0]]) is None
    assert find_asymmetry([[1.0, float("inf")], [0.0, 1.0]]) is None


def test_rounding_is_no_asymmetry():
    assert find_asymmetry([[1.0, 0.1 + 0.2], [0.3, 1.0]]) is None
    assert find_asymmetry([[1e6, 1e-12], [0.0, 1e6]]) is None
    uneven = find_asymmetry([[1.0, 2, 3], [2, 1, 4], [3, 5, 1]])
    assert uneven is not None
    assert (uneven.row, uneven.column, uneven.entry, uneven.mirror) == (2, 3, 4, 5)
