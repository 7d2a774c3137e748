"""Sampled parts: against hand-written loops with exact solutions between the instants."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from bgc.runtime.running.failures import SimulationError

R, L, K, J, B = 1.2, 1.5e-3, 0.05, 20e-6, 15e-6
LIMIT, KP, KI, KD, N = 12.0, 0.1, 8.0, 5e-5, 5.0
A = np.array([[-R / L, -K / L], [K / J, -B / J]])  # of current and speed


class Pid:
    """The controller of `Controlled`, as a programmer writes it."""

    def __init__(self, period):
        self.period, self.integral, self.before, self.rate = period, 0.0, 0.0, 0.0

    def __call__(self, t, speed):
        error = (200.0 if t < 0.1 else 50.0) - speed
        slope = (self.rate + N * (error - self.before)) / (1 + N)
        free = KP * error + self.integral + KD * slope / self.period
        if abs(free) < LIMIT:
            self.integral += KI * self.period * error
        self.before, self.rate = error, slope
        return min(max(free, -LIMIT), LIMIT)


def controlled(times, period, delay):
    """Speed, current and voltage at times: the exact flow between instants, and the loop."""
    pid, state, u, now, k = Pid(period), np.zeros(2), 0.0, 0.0, 0
    rows = []

    def advance(span):
        rest = np.linalg.solve(A, [u / L, 0.0])
        return expm(A * span) @ (state + rest) - rest

    for t in times:
        while k * period + delay <= t + 1e-12:
            state, now = advance(k * period + delay - now), k * period + delay
            u = pid(now, state[1])
            k += 1
        row = advance(t - now)
        rows.append((row[1], row[0], u, pid.integral))
    return np.array(rows)


@pytest.mark.parametrize(
    ("solver", "options"),
    [
        ("rodas5p", {"rtol": 1e-11}),
        ("radau5", {"rtol": 1e-11}),
        ("dopri5", {"rtol": 1e-11}),
        ("gauss4", {"step": 2e-5}),
        ("rk4", {"step": 2e-5}),
    ],
)
@pytest.mark.parametrize("delay", [0.0, 0.7e-3])
def test_a_discrete_pid_drives_a_motor(load, solver, options, delay):
    """With a rate that is filtered, limits, an integral that stops there, and a late start."""
    model = load("sampled", "control")
    result = model.simulate(solver=solver, parameters={"delay": delay}, **options)
    exact = controlled(result.time, 2e-3, delay)
    scale = np.abs(exact).max(axis=0)
    for k, name in enumerate(("speed", "current", "u", "integral")):
        np.testing.assert_allclose(result[name], exact[:, k], atol=1e-8 * scale[k], rtol=0)
    exchanged = np.abs(result["energy.residual"]).max()
    assert exchanged < 1e-8


def test_the_motor_by_scipy(load):
    """The same loop with SciPy's integrator between the instants."""
    result = load("sampled", "control").simulate(rtol=1e-11)
    pid, state, u = Pid(2e-3), np.zeros(2), 0.0
    for k in range(100):
        u = pid(2e-3 * k, state[1])
        state = solve_ivp(
            lambda t, y, u=u: A @ y + [u / L, 0], (0, 2e-3), state, "DOP853", rtol=1e-12, atol=1e-12
        ).y[:, -1]
    np.testing.assert_allclose(result["speed"][-1], state[1], rtol=1e-8)


def test_a_fixed_step_that_does_not_match_is_cut_at_the_instants(load):
    """Steps of 0.7 ms: the result still is that of instants at multiples of 2 ms."""
    model = load("sampled", "control")
    result = model.simulate(solver="gauss4", step=0.7e-3)
    exact = controlled(result.time, 2e-3, 0.0)
    np.testing.assert_allclose(result["speed"], exact[:, 0], atol=5e-3)
    assert result.counts["steps"] >= 286 + 85  # every seventh instant is on the grid
    matching = model.simulate(solver="gauss4", step=0.5e-3)
    assert matching.counts["steps"] == 400


def test_parts_of_two_rates_read_the_values_before_the_instant(load):
    """Each evaluation reads what was held before, whichever part stands first in the text."""
    result = load("sampled", "rates").simulate(rtol=1e-11)
    x, fast, slow, count, now = 1.0, 0.0, 0.0, 0.0, 0.0
    doubled, r, s, w = 0.0, np.array([1.0, 2, 3]), np.zeros(2), np.zeros(2)
    for row, t in enumerate(result.time):
        for tick in range(13):
            at = tick * 0.01
            if not now - 1e-9 <= at <= t + 1e-9 or at < count * 0.01 - 1e-9:
                continue
            x, now = 0.1 * fast + (x - 0.1 * fast) * np.exp(-(at - now)), at
            held = fast, slow, count
            fast = x + held[1]
            doubled, count = 2 * fast, held[2] + 1
            if tick % 3 == 1:
                slow = r[0] + 10 * held[0]
                w = s + slow
                s = s + np.array([1, 2]) * held[2]
                r = np.roll(r, -1)
        here = 0.1 * fast + (x - 0.1 * fast) * np.exp(-(t - now))
        found = [result[name][row] for name in ("x", "fast", "doubled", "slow", "count")]
        np.testing.assert_allclose(found, [here, fast, doubled, slow, count], rtol=1e-9)
        for name, value in (("r", r), ("s", s), ("w", w)):
            wide = [result[f"{name}[{k + 1}]"][row] for k in range(len(value))]
            np.testing.assert_allclose(wide, value, rtol=1e-9)


@pytest.mark.parametrize("options", [{}, {"solver": "rk4", "step": 1e-4}])
def test_instants_do_not_drift_over_a_million_samples(load, options):
    result = load("sampled", "clock").simulate(**options)
    assert result["count"][-1] == pytest.approx(1e6, abs=1)
    assert result["worst_before"][-1] < 1e-13  # a few units in the last place of 100 s


def test_sampled_parts_and_jumps_act_on_each_other(load):
    """x is sampled above 1 at 1.2 s; the jump follows at that instant, and again after 1.2 s."""
    result = load("sampled", "mixed").simulate()
    expected = np.where(result.time < 1.2 - 1e-9, result.time, np.nan)
    inside = ~np.isnan(expected)
    np.testing.assert_allclose(result["x"][inside], expected[inside], atol=1e-9)
    last = result.time >= 2.4 - 1e-9
    np.testing.assert_allclose(result["x"][last], result.time[last] - 2.4, atol=1e-9)
    np.testing.assert_allclose(result["passed"][-1], 2)
    np.testing.assert_allclose(result["above"][np.isclose(result.time, 1.2)], 1)


def test_an_infinite_sample_ends_the_run_and_is_named(load):
    with pytest.raises(SimulationError, match=r"BG771.*`u`") as failure:
        load("sampled", "infinite").simulate()
    np.testing.assert_allclose(failure.value.result["u"], [0.5, 1])
