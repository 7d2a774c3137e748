"""Changes of least length, against NumPy."""

import numpy as np
import pytest

from bgc.algebra.dense import damped_change


@pytest.mark.parametrize("shape", [(2, 7), (5, 5), (7, 2), (3000, 2)])
def test_damped_changes_of_wide_and_tall_matrices(shape):
    """3,000 equal conditions on two states take the work of a matrix of 2 by 2."""
    rng = np.random.default_rng(shape[0])
    matrix, right = rng.normal(size=shape), rng.normal(size=shape[0])
    damped = matrix.T @ matrix + 0.3 * np.eye(shape[1])
    expected = np.linalg.solve(damped, matrix.T @ right)
    found = damped_change(matrix.tolist(), right.tolist(), 0.3)
    assert np.allclose(found, expected, rtol=1e-10)


def test_no_change_where_the_factors_do_not_exist():
    assert damped_change([[0.0, 0.0]], [1.0], 0.0) == [0.0, 0.0]
    assert damped_change([[0.0], [0.0]], [1.0, 1.0], 0.0) == [0.0]
