"""Gravity compensation: a crane that carries its own weight stands still with free joints."""

import numpy as np
import pytest


@pytest.mark.parametrize("crane", ["two_beam", "telescopic"])
def test_a_crane_with_free_joints_stands_but_for_the_sag_of_its_locks(load, crane):
    result = load("balance", crane).simulate()
    moved = np.linalg.norm(result["tip"] - result["tip"][0], axis=1)
    assert moved.max() < 1e-3
    assert moved[-1] == pytest.approx(moved[1], rel=1e-2)  # sagged at once, and at rest
