"""The haptic handle: dead band, limits, which way the virtual coupling pulls, and the modes."""

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


def test_an_open_clutch_keeps_the_tip_while_the_hand_returns(load):
    """40 mm out, back with the clutch open, out again: the tip goes out twice."""
    result = load("modes", "clutch").simulate("4 s", rtol=1e-8)
    lag, speed, rise = 0.1, 50 * 0.04, lambda t: t - 0.1 * (1 - np.exp(-t / 0.1))
    time, asked = result.time, result["asked"][:, 1]
    held = (time > 1.0) & (time <= 2.0)
    reached = speed * rise(1.0)
    np.testing.assert_allclose(asked[time <= 1.0], speed * rise(time[time <= 1.0]), atol=1e-6)
    np.testing.assert_allclose(asked[held], reached, atol=1e-6)
    np.testing.assert_allclose(result["velocity"][held & (time < 1.95), 1], 0.0, atol=1e-9)
    # The zero lags by 5 ms of the hand's motion, and the tip moves back by that share at most.
    after = (time > 2.0) & (time <= 3.0)
    expected = reached + speed * rise(time[after] - 2.0)
    slip = speed * 5e-3 * (1 - np.exp(-(time[after] - 2.0) / lag))
    np.testing.assert_allclose(asked[after], expected - slip, atol=1e-5)
    np.testing.assert_allclose(asked[-1], reached + speed * (1 - 5e-3), atol=2e-4)


def test_a_spring_brings_the_handle_to_the_middle_of_its_dead_band(load):
    result = load("modes", "centred").simulate()
    beyond = np.maximum(result["x"] - 0.005, 0.0)
    weight = np.array([900, 0, -18e3]) / 1800
    np.testing.assert_allclose(result["force"], weight - 60 * beyond, atol=1e-9)
    assert result["force"][0, 1] == 0.0 and result["force"][-1, 1] < 0.0


def test_joint_torques_are_those_of_virtual_work(load):
    """J' F of a slewed arm with two links, by hand."""
    slew, a, b = 0.3, 0.7, -0.4
    reach, height = 12 * np.cos(a) + 9 * np.cos(b), 12 * np.sin(a) + 9 * np.sin(b)
    out = np.array([np.cos(slew), np.sin(slew), 0])
    side = np.array([-np.sin(slew), np.cos(slew), 0])
    up, force = np.array([0, 0, 1]), np.array([900, 0, -18e3])
    turned = [reach * side, reach * up - height * out, 9 * np.cos(b) * up - 9 * np.sin(b) * out]
    torques = np.array([force @ column for column in turned])
    result = load("modes", "torques").simulate()
    np.testing.assert_allclose(result["holding"][-1], -torques, rtol=1e-9)
    np.testing.assert_allclose(result["force"][-1], [1e-4, 5e-5, 2e-5] * torques, rtol=1e-9)
