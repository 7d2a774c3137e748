"""An odd loop of gyrators end to end: three charges, of which two are independent."""

import numpy as np
from scipy.linalg import expm

STIFFNESS = np.diag([1 / 2, 1 / 3, 1 / 4])
GYRATION = np.array([[0.0, -2, 5], [2, 0, -3], [-5, 3, 0]])  # efforts from flows
OPEN = np.array([3.0, 5, 2])  # the flows that gyrate nothing: efforts across them add to zero


def test_charges_on_a_ring_of_gyrators_follow_the_matrix_exponential(load):
    """`f = pinv(G) K q + z n` with `n' K f = 0`; the third charge follows from `n' K q = 0`."""
    result = load("gyrator_ring", "free").simulate()
    start = np.array([1, 2, -4 * (3 / 2 + 5 * 2 / 3) / 2])
    driven = np.linalg.pinv(GYRATION) @ STIFFNESS
    stiff = OPEN @ STIFFNESS
    rates = driven - np.outer(OPEN, stiff @ driven) / (stiff @ OPEN)
    charges = np.array([expm(rates * t) @ start for t in result["time"]])
    found = np.column_stack([result["a"], result["b"], result["c"]])
    np.testing.assert_allclose(found, charges, atol=1e-8)
    np.testing.assert_allclose(result["current"], (charges @ rates.T)[:, 0], atol=1e-8)
    assert np.abs(result["residual"]).max() < 1e-9
