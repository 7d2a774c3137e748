"""The haptic handle: dead band, limits, and which way the virtual coupling pulls."""

import numpy as np


def test_rate_control_has_a_dead_band_and_a_limit(load):
    result = load("handle", "rate").simulate(rtol=1e-9)
    wanted = np.array([0, -12 * 0.005, 0.6])
    reached = 1 - np.exp(-result.time / 0.05)
    np.testing.assert_allclose(result["velocity"], reached[:, None] * wanted, atol=1e-7)


def test_the_coupling_stretches_by_crane_minus_hand_and_pulls_the_crane_back(load):
    result = load("handle", "rate").simulate(rtol=1e-9)
    crane = np.array([0.1, 0, 0])
    slip = crane - result["velocity"]
    np.testing.assert_allclose(result["slip"], slip, atol=1e-12)
    wanted = np.array([0, -0.06, 0.6])
    stretch = crane * 1 - wanted * (1 - 0.05 * (1 - np.exp(-20)))
    np.testing.assert_allclose(result["stretch"][-1], stretch, rtol=1e-6)
    # The effort that the crane has to overcome: a crane ahead of the hand is held back.
    pull = 4e5 * result["stretch"] + 8e4 * slip
    np.testing.assert_allclose(result["resistance"], pull, rtol=1e-9)
    assert result["resistance"][-1, 0] > 0


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
