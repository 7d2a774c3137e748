"""Compensation of heave, sway and tension, against linear theory."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal


@pytest.mark.parametrize(("scene", "seed"), [("heave", 1), ("heave", 2), ("digital", 1)])
def test_heave_compensation_leaves_what_its_washout_lets_through(load, scene, seed):
    """JONSWAP, Hs 2.5 m, Tp 8 s: the rest is the heave through a low pass of 30 s."""
    model = load("compensation", scene)
    free = load("compensation", "heave").simulate(parameters={"on": 0, "seed": seed})
    held = model.simulate(parameters={"seed": seed})
    late = free.time > 150
    taken = 1 - np.std(held["height"][late]) / np.std(free["height"][late])
    assert taken > 0.93
    _, slow, _ = signal.lsim(([1], [30, 1]), free["height"] - free["height"][0], free.time)
    np.testing.assert_allclose(held["height"] - held["height"][0], slow, atol=0.08)
    rates = np.abs([held[f"rates[{k}]"] for k in (1, 2, 3)]).max(axis=1)
    assert np.all(rates < [0.3, 0.25, 0.25])
    # The joints do not drift: the crane is where it was.
    for k, start in enumerate((0.4, 0.9, -1.2)):
        assert abs(held[f"angles[{k + 1}]"][late].mean() - start) < 0.06


@pytest.mark.parametrize("damping", [0.2, 0.4, 0.7])
def test_anti_sway_damps_a_pendulum_as_asked(load, damping):
    w, d0 = np.sqrt(9.81 / 10), 10 * np.sin(0.02)
    start = {"damping": damping, "sway0": 2 * damping * w * d0}
    result = load("compensation", "sway").simulate(parameters=start)
    turning = w * np.sqrt(1 - damping**2)
    t = result.time
    swing = np.cos(turning * t) + damping * w / turning * np.sin(turning * t)
    expected = 0.02 * np.exp(-damping * w * t) * swing
    np.testing.assert_allclose(result["angle"], expected, atol=5e-4)


def test_a_load_hangs_still_after_a_move(load):
    model = load("compensation", "sway")
    move = {"speed": 1.0, "angle0": 0.0}
    left = []
    for damping in (0.0, 0.4):
        result = model.simulate(parameters=move | {"damping": damping})
        left.append(np.abs(result["angle"][result.time > 33]).max())
    assert left[0] > 0.05
    assert left[1] < 0.01 * left[0]


def test_a_winch_holds_the_tension(load):
    """The amplitude of the tension is that of the linear loop."""
    model = load("compensation", "towing")
    result = model.simulate()
    late = result.time > 16
    tension = result["tension"][late]
    w, k, loss = 2 * np.pi / 8, 5e6 / 50, 0.01
    s = 1j * w
    rope = k * (1 + loss * s)
    law = (1e-4 + 1e-4 / s) / (0.05 * s + 1)
    amplitude = abs(rope / (s + rope * law)) * w
    assert np.ptp(tension) / 2 == pytest.approx(amplitude, rel=0.03)
    assert tension.mean() == pytest.approx(50e3, rel=0.01)
    assert np.abs(result["speed"]).max() < 2
    assert np.abs(result["energy.residual"]).max() < 1
    loose = model.simulate(parameters={"on": 0})["tension"][late]
    assert np.ptp(tension) < 0.1 * np.ptp(loose)
    assert loose.min() == 0  # slack, never pushed
