"""Compensation of a chain's own weight by the derivative of its potential energy."""

import numpy as np


def test_it_is_the_sum_of_the_torques_of_all_weights(load):
    """While a quarter of it is missing, so that the chain moves: on a tilted base."""
    result = load("own_weight", "held").simulate(parameters={"share": 0.75})
    for k in range(1, 5):
        by_hand = result[f"by_hand[{k}]"]
        moved = result[f"coordinates[{k}]"]
        assert np.ptp(moved) > 0.1
        scale = np.abs(by_hand).max()
        assert scale > 100
        np.testing.assert_allclose(result[f"held[1,{k}]"], by_hand, rtol=0, atol=1e-12 * scale)
    assert np.abs(result["energy.residual"]).max() < 1


def test_a_chain_that_it_holds_stays(load):
    result = load("own_weight", "held").simulate()
    for k in range(1, 5):
        coordinate = result[f"coordinates[{k}]"]
        np.testing.assert_allclose(coordinate, coordinate[0], atol=1e-9)
