"""Drives of a joint, from an ideal effort to servo valve and oil: closed forms."""

from __future__ import annotations

import numpy as np
import pytest

INERTIA = 5000.0
DISPLACEMENT, VOLUME, BULK, SUPPLY, LEAK = 0.02, 0.1, 1.6e9, 3e7, 1e-12
VALVE = 4e-3 / np.sqrt(1e6)  # flow by square root of pressure


def test_an_ideal_effort_accelerates(load):
    result = load("drives", "effort").simulate(parameters={"command": -0.5})
    np.testing.assert_allclose(result["angle"], -0.5 * 1000 / INERTIA * result.time**2 / 2)
    assert np.abs(result["energy.residual"]).max() < 1e-9


@pytest.mark.parametrize("sign", [1, -1])
def test_a_rate_servo_ramps_and_then_keeps_its_rate(load, sign):
    result = load("drives", "rate").simulate(parameters={"command": sign})
    expected = sign * np.minimum(0.25 * result.time, 0.5)
    np.testing.assert_allclose(result["rate"], expected, atol=1e-3)


def test_a_rate_servo_slips_under_a_load_beyond_its_limit(load):
    model = load("drives", "rate")
    given = {"load": 3e4, "drive.servo.limit": 2e4}
    result = model.simulate(parameters=given)
    np.testing.assert_allclose(np.diff(result["rate"])[2:], -(3e4 - 2e4) / INERTIA * 0.5, rtol=1e-3)


def test_closed_in_oil_is_a_spring(load):
    """Two chambers: k = D^2 beta (1/V + 1/V)."""
    values = load("drives", "oil").eigenvalues()
    omega = np.sqrt(2 * DISPLACEMENT**2 * BULK / VOLUME / INERTIA)
    assert values.imag.max() == pytest.approx(omega, rel=1e-4)


@pytest.mark.parametrize("sign", [1, -1])
def test_an_open_valve_sets_the_rate(load, sign):
    """Without a load each orifice takes half of the supply: Q = kv sqrt(ps/2) = D w."""
    result = load("drives", "oil").simulate(parameters={"command": sign})
    rate = VALVE * np.sqrt(SUPPLY / 2) / DISPLACEMENT
    assert result["rate"][-1] == pytest.approx(sign * rate, rel=1e-4)
    np.testing.assert_allclose([result["front"][-1], result["back"][-1]], SUPPLY / 2, rtol=1e-3)
    exchanged = result["energy.supplied"][-1]
    assert exchanged > 1e5
    assert np.abs(result["energy.residual"]).max() < 1e-5 * exchanged


def test_a_load_creeps_by_the_leak(load):
    """Valve closed: the load's pressure T/D drives the leak, w = -G T/D^2."""
    load_torque = 1e5
    half = load_torque / DISPLACEMENT / 2
    given = {"load": load_torque, "drive.pressure0": 5e6 + half, "drive.pressure_back0": 5e6 - half}
    result = load("drives", "oil").simulate(parameters=given)
    creep = -LEAK * load_torque / DISPLACEMENT**2
    slope = np.polyfit(result.time, result["angle"], 1)[0]
    assert slope == pytest.approx(creep, rel=0.02)
    np.testing.assert_allclose(result["front"] - result["back"], 2 * half, rtol=1e-3)


def test_a_crane_in_its_drives_slews_and_luffs(load):
    result = load("drives", "at_sea").simulate()
    height, distance = (
        result["load"][:, 2],
        np.hypot(result["load"][:, 0] + 20, result["load"][:, 1]),
    )
    assert height[-1] - height[0] > 0.5, "luffed up"
    assert distance[-1] < distance[0], "and in"
    slewed = np.arctan2(result["load"][-1, 1], result["load"][-1, 0] + 20)
    assert slewed == pytest.approx(0.05 * 5, rel=0.1)
    supplied = np.abs(result["energy.supplied"]).max()
    assert np.abs(result["energy.residual"]).max() < 1e-6 * supplied
