"""A closed chain of rigid bars, one pin of which may give way, against Lagrange's equations."""

import bars
import numpy as np
import pytest
from lagrange import motion

GRAVITY = 9.81
LENGTHS = (1, 2.5, 1.7)
MASSES = (3, 8, 5)
PIN = np.array([2.4, 0])  # of the rocker, on the ground
SIDE = 0.1
TORQUE = 60


def places(angles):
    """Centres of the bars and the rocker's end, from the angles of the bars to the ground."""
    at, centres = np.zeros(2), []
    for length, angle in zip(LENGTHS, angles, strict=True):
        along = length * np.array([np.cos(angle), np.sin(angle)])
        centres.append(at + along / 2)
        at = at + along
    return centres, at


def mass_matrix(angles):
    total = np.zeros((3, 3), complex)
    for k, (mass, length) in enumerate(zip(MASSES, LENGTHS, strict=True)):
        shares = np.array([*LENGTHS[:k], length / 2, 0, 0])[:3]
        rates = shares * np.array([-np.sin(angles), np.cos(angles)])
        total += mass * rates.T @ rates
        total[k, k] += mass * (length**2 + SIDE**2) / 12
    return total if np.iscomplexobj(angles) else total.real


def potential(stiffness):
    def of(angles):
        centres, end = places(angles)
        weights = sum(m * GRAVITY * centre[1] for m, centre in zip(MASSES, centres, strict=True))
        return weights + stiffness * (end - PIN) @ (end - PIN) / 2 - TORQUE * angles[0]

    return of


@pytest.mark.parametrize("stiffness", [2e3, 2e4])
def test_bars_and_gap_move_as_lagrange_says(load, stiffness):
    result = load("four_bar", "four_bar").simulate(parameters={"stiffness": stiffness})
    start = np.array([np.pi / 2, np.arctan2(0.7, 2.4), -np.pi / 2])
    q, _ = motion(mass_matrix, potential(stiffness), start, np.zeros(3), result.time)
    assert np.ptp(q[:, 0]) > 1, "it has to move"

    turned = np.cumsum(np.column_stack([result["a"], result["b"], result["c"]]), axis=1)
    np.testing.assert_allclose(turned, q, atol=1e-6)
    gap = np.array([np.linalg.norm(PIN - places(angles)[1]) for angles in q])
    assert gap.max() > 1e-2
    np.testing.assert_allclose(np.linalg.norm(result["gap"], axis=1), gap, atol=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-5


def test_all_rigid_it_moves_as_bars_with_pins(load):
    """No part says when the chain is closed, so the gap is that of integration."""
    result = load("four_bar", "all_rigid").simulate()
    turned = np.cumsum(np.column_stack([result["a"], result["b"], result["c"]]), axis=1)
    np.testing.assert_allclose(turned, bars.four_bar(result.time, turned[0]), atol=2e-7)
    np.testing.assert_allclose(result["tip"] - [2.4, 0, 0], 0, atol=1e-8)
    assert np.abs(result["energy.residual"]).max() < 1e-6
