"""Andrews' squeezing mechanism of joints of the library, against its equations written out."""

import numpy as np


def test_joints_and_welds_give_the_equations_of_the_squeezer(load):
    """Three loops that meet at one point; nine of their eighteen constraints are redundant."""
    result = load("andrews", "squeeze").simulate(rtol=1e-12)
    written = load("ivp/squeezer", "ivp").simulate(every=0.001, solver="radau5", rtol=1e-12)
    assert written["q"][-1, 0] > 15, "more than two turns"
    np.testing.assert_allclose(result["q"], written["q"], atol=1e-9)
    np.testing.assert_allclose(result["v"], written["v"], atol=1e-6)
    for k in (3, 4, 6):
        assert np.abs(result[f"gap{k}"]).max() < 1e-11
    assert np.abs(result["energy.residual"]).max() < 1e-9 * np.ptp(result["energy.stored"])
