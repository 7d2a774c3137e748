"""Sources, filters and controllers of library/control, against SciPy and hand-written loops."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.linalg import expm

from bgc.diagnostics.diagnostic import BgError

LOG = np.loadtxt(
    Path(__file__).parents[1] / "models" / "control_log.csv", delimiter=",", skiprows=1
)
TIMES, LEVELS = LOG[:, 0], 1e-3 * LOG[:, 1]
PERIOD = 0.02
# Numerators and denominators in s, with the values at rest at the start.
LINEAR = {
    "low": ([2.0], [0.25, 1.0], 0.15),
    "second": ([75.0], [1.0, 4.0, 25.0], 0.1),
    "high": ([0.25, 0.0], [0.25, 1.0], 0.4),
    "lead": ([0.6, 1.0], [0.25, 1.0], 0.4),
}


def test_sources_follow_their_formulas(load):
    result = load("control", "sources").simulate()
    t = result.time
    np.testing.assert_allclose(result["stepped"], np.where(t >= 0.35, 2e5, -1e5))
    np.testing.assert_allclose(result["ramp"], np.interp(t, [0.4, 1.1], [1, -1]), atol=1e-14)
    wave = 1 + np.where(t >= 0.25, 2 * np.sin(3 * np.pi * (t - 0.25) + 0.3), 0)
    np.testing.assert_allclose(result["sine"], wave, atol=1e-12)
    swept = 3 * signal.chirp(np.clip(t - 0.2, 0, None), 0.5, 1.5, 4, phi=-90)
    inside = t <= 1.7
    np.testing.assert_allclose(result["chirp"][inside], swept[inside], atol=1e-12)
    # After the sweep it goes on at 4 Hz, without a jump in phase.
    after = 2 * np.pi * (1.5 * (0.5 + 4) / 2 + 4 * (t - 1.7))
    np.testing.assert_allclose(result["chirp"][~inside], 3 * np.sin(after)[~inside], atol=1e-12)
    straight = np.interp(t - 0.2, TIMES, LEVELS)
    np.testing.assert_allclose(result["straight"], straight, atol=1e-12)
    smooth = PchipInterpolator(TIMES, LEVELS)(t)
    np.testing.assert_allclose(result["smooth"], smooth, atol=1e-3)
    # Eight pulses of 30 ms, none of which a step passes over.
    assert result["area"][-1] == pytest.approx(8 * 0.03 * 2, rel=1e-9)
    assert set(np.round(result["pulse"], 12)) == {0.5, 2.5}


@pytest.mark.parametrize("name", LINEAR)
def test_continuous_filters_have_their_transfer_functions(load, name):
    """The input has straight lines between rows, for which `lsim` is exact."""
    numerator, denominator, rest = LINEAR[name]
    result = load("control", "filters").simulate(rtol=1e-9)
    level = np.interp(result.time, TIMES, LEVELS)
    steady = signal.TransferFunction(numerator, denominator)
    _, y, _ = signal.lsim(steady, level - rest, result.time)
    at_rest = rest * numerator[-1] / denominator[-1]
    np.testing.assert_allclose(result[name], at_rest + y, atol=1e-6)


@pytest.mark.parametrize("name", LINEAR)
def test_sampled_filters_are_the_bilinear_ones_of_scipy(load, name):
    numerator, denominator, rest = LINEAR[name]
    result = load("control", "sampled").simulate()
    b, a = signal.bilinear(numerator, denominator, fs=1 / PERIOD)
    level = np.interp(result.time[::2], TIMES, LEVELS)
    at_rest = rest * numerator[-1] / denominator[-1]
    expected = at_rest + signal.lfilter(b, a, level - rest)
    np.testing.assert_allclose(result[name][::2], expected, atol=1e-12)
    np.testing.assert_array_equal(result[name][1::2], result[name][:-1:2])


def test_a_transfer_function_of_third_order_is_that_of_scipy(load):
    result = load("control", "filters").simulate(rtol=1e-9)
    level = np.interp(result.time, TIMES, LEVELS)
    _, y, _ = signal.lsim(([2, 0, 3, 5], [0.1, 1.2, 4, 8]), level, result.time)
    np.testing.assert_allclose(result["third"], y, atol=1e-6)


def test_a_relay_with_hysteresis_keeps_its_side_between_the_limits(load):
    result = load("control", "filters").simulate(rtol=1e-9)
    times = np.arange(0, 3.000005, 1e-5)
    side, expected = -2, []
    for level in np.interp(times, TIMES, LEVELS):
        side = 5 if level > 0.6 else -2 if level < -0.4 else side
        expected.append(side)
    differs = np.flatnonzero(result["relay"] != np.interp(result.time, times, expected))
    assert set(result["relay"]) == {-2, 5} and len(differs) == 0
    assert np.count_nonzero(np.diff(result["relay"])) > 4


def test_limits_bands_and_delays(load):
    continuous = load("control", "filters").simulate(rtol=1e-9)
    digital = load("control", "sampled").simulate()
    level = np.interp(continuous.time, TIMES, LEVELS)
    np.testing.assert_allclose(continuous["limited"], np.clip(level, -0.5, 1), atol=1e-14)
    dead = np.sign(level) * np.clip(np.abs(level) - 0.3, 0, None)
    np.testing.assert_allclose(continuous["dead"], dead, atol=1e-14)
    held = np.repeat(level[::2], 2)[: len(level)]
    np.testing.assert_allclose(continuous["held"], held, atol=1e-14)
    delayed = np.concatenate([[7, 7], held[:-2]])
    np.testing.assert_allclose(continuous["delayed"], delayed, atol=1e-14)
    # The sampled limiter as a loop; the continuous one approaches it with fine steps.
    for result, levels, step, atol in (
        (digital, level[::2], PERIOD, 1e-12),
        (continuous, np.interp(np.arange(0, 3.0005, 1e-3), TIMES, LEVELS), 1e-3, 8e-3),
    ):
        y, expected = 0.2, []
        for u in levels:
            y += np.clip(u - y, -6 * step, 4 * step)
            expected.append(y)
        rows = slice(None, None, 2) if result is digital else slice(None)
        every = 1 if result is digital else 10
        np.testing.assert_allclose(result["slewed"][rows], expected[::every], atol=atol)
    assert np.diff(continuous["slewed"]).max() <= 4 * 0.01 + 1e-6
    assert np.diff(continuous["slewed"]).min() >= -6 * 0.01 - 1e-6


KP, KI, KD, T, LIMIT, B, C, MASS, OIL = 40.0, 30.0, 25.0, 0.05, 12.0, 0.8, 0.3, 3.0, 2.0
TRACKING = KP / KI


def test_the_continuous_pid_by_scipy(load):
    result = load("control", "loop").simulate()

    def law(t, state, wanted):
        position, _, integral, slow = state
        slope = (C * wanted - position - slow) / T
        free = KP * (B * wanted - position) + integral + KD * slope + 0.2 * t
        return free, np.clip(free, -LIMIT, LIMIT), slope

    def rates(t, state, wanted, load):
        position, speed, _, _ = state
        free, u, slope = law(t, state, wanted)
        drawn = KI * (wanted - position) + (u - free) / TRACKING
        return [speed, (u + load - OIL * speed) / MASS, drawn, slope]

    state, rows = np.zeros(4), []
    for begin, end, wanted, load_ in ((0, 0.5, 0, 0), (0.5, 4, 1, 0), (4, 10.001, 1, -3)):
        at = result.time[(result.time >= begin - 1e-9) & (result.time < end - 1e-9)]
        solution = solve_ivp(
            rates, (begin, end), state, "Radau", t_eval=[*at, end], args=(wanted, load_),
            rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        state = solution.y[:, -1]
        rows += [(y[0], law(t, y, wanted)[1]) for t, y in zip(at, solution.y.T, strict=False)]
    position, force = np.array(rows).T
    np.testing.assert_allclose(result["position"], position, atol=1e-6)
    np.testing.assert_allclose(result["force"], force, atol=1e-4)
    assert np.abs(result["energy.residual"]).max() < 1e-8


def sampled_loop(times, period):
    """Position and force: the loop in the slot, with the exact motion between instants."""
    motion = expm(np.array([[0, 1, 0], [0, -OIL / MASS, 1 / MASS], [0, 0, 0]]) * period)
    state, integral, rate, before, rows = np.zeros(2), 0.0, 0.0, 0.0, []
    for k in range(round(times[-1] / period) + 1):
        t = k * period
        wanted = 1.0 if t >= 0.5 else 0.0
        weighted = C * wanted - state[0]
        rate = (T * rate + weighted - before) / (T + period)
        before = weighted
        free = KP * (B * wanted - state[0]) + integral + KD * rate + 0.2 * t
        u = np.clip(free, -LIMIT, LIMIT)
        integral += period * (KI * (wanted - state[0]) + (u - free) / TRACKING)
        rows.append((state[0], u))
        state = (motion @ [*state, u + (-3 if t >= 4 - 1e-9 else 0)])[:2]
    return np.array(rows)


def test_the_sampled_pid_is_the_hand_written_loop(load):
    result = load("control", "digital").simulate()
    expected = sampled_loop(result.time, PERIOD)
    shared = np.arange(0, len(result.time), 2)  # rows at 0.1 s, instants at 0.02 s
    np.testing.assert_allclose(result["position"][shared], expected[::5, 0], atol=1e-7)
    np.testing.assert_allclose(result["force"][shared], expected[::5, 1], atol=1e-5)


def test_the_sampled_pid_approaches_the_continuous_one(load):
    exact = load("control", "loop").simulate()["position"]
    errors = [
        np.abs(
            load("control", "digital").simulate(parameters={"pid.period": period})["position"]
            - exact
        ).max()
        for period in (0.02, 0.01, 0.005)
    ]
    assert errors[0] > 1.7 * errors[1] > 1.7**2 * errors[2]


def test_the_integral_does_not_wind_up(load):
    model = load("control", "filling")
    limited = model.simulate()["level"].max() / 10 - 1
    wound_up = model.simulate(parameters={"pid.tracking": 1e9})["level"].max() / 10 - 1
    assert limited < 0.05
    assert wound_up > 0.5


@pytest.mark.parametrize(
    ("scene", "name", "value", "code"),
    [
        ("filters", "limited.upper", -1, "BG705.*limit `lower` is above"),
        ("filters", "slewed.falling", -1, "BG705.*positive"),
        ("filters", "low.T", 0, "BG061"),
        ("loop", "limit", -1, "BG705.*limit `lower` is above"),
        ("digital", "pid.period", 0, "BG061"),
    ],
)
def test_wrong_parameters_are_refused(load, scene, name, value, code):
    with pytest.raises(BgError, match=f"(?s){code}"):
        load("control", scene).simulate(parameters={name: value})
