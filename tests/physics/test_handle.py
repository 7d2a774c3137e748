"""The haptic handle: dead band, limits, and which way the virtual coupling pulls."""

import numpy as np


def test_rate_control_has_a_dead_band_and_a_limit(load):
    velocity = load("handle", "rate").simulate()["velocity"]
    np.testing.assert_allclose(velocity[-1], [0, -12 * 0.005, 0.6])


def test_the_coupling_stretches_by_crane_minus_hand_and_pulls_the_crane_back(load):
    result = load("handle", "rate").simulate(rtol=1e-9)
    velocity = result["velocity"][-1]
    slip = np.array([0.1, 0, 0]) - velocity
    np.testing.assert_allclose(result["slip"][-1], slip, atol=1e-12)
    np.testing.assert_allclose(result["stretch"][-1], slip * result.time[-1], rtol=1e-9)
    # The effort that the crane has to overcome: a crane ahead of the hand is held back.
    np.testing.assert_allclose(result["resistance"][-1], (4e5 + 8e4) * slip, rtol=1e-9)


def test_the_load_is_scaled_to_the_hand(load):
    model = load("handle", "rate")
    assert model.observe()["force[3]"] == -10
    saturated = model.observe(parameters={"handle.limit": 4})
    np.testing.assert_allclose([saturated[f"force[{k}]"] for k in (1, 2, 3)], [0, 0, -4])


def test_position_control_follows_the_hand(load):
    result = load("handle", "position").simulate(rtol=1e-8)
    expected = 20 * np.array([0.004, -0.01, 0.07])
    lag = 1 - np.exp(-result.time / 0.1)
    np.testing.assert_allclose(result["asked"], lag[:, None] * expected, atol=1e-6)
    np.testing.assert_allclose(result["velocity"][-1], 0, atol=1e-6)
    np.testing.assert_allclose(result["force"][-1], [0, 0, -12], rtol=1e-9)  # 15 N, limited
