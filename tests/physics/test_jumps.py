"""Jumps of states (`when`, `reset`): against closed forms and hand-written event loops."""

import numpy as np
import pytest

from bgc.runtime.running.failures import SimulationError

G = 9.81
METHODS = [
    ("rodas5p", {}),
    ("dopri5", {}),
    ("radau5", {}),
    ("ros34prw", {"step": 0.037}),
    ("rk4", {"step": 0.01}),
    ("gauss4", {"step": 0.037}),
]


def bounces(time, e, floor):
    """Height, speed and number of bounces of a ball that falls from 1 m."""
    start, speed, count = np.sqrt(2 * (1 - floor) / G), np.sqrt(2 * G * (1 - floor)) * e, 1
    if time < start:
        return 1 - G * time**2 / 2, -G * time, 0
    while time >= start + 2 * speed / G:
        start, speed, count = start + 2 * speed / G, speed * e, count + 1
    since = time - start
    return floor + speed * since - G * since**2 / 2, speed - G * since, count


@pytest.mark.parametrize(("solver", "options"), METHODS)
@pytest.mark.parametrize("floor", [0.0, 0.3])
def test_a_bouncing_ball(load, solver, options, floor):
    """Every method is exact on a parabola; the times of the bounces are located to rounding."""
    ball = load("jumps", "bounce")
    result = ball.simulate(solver=solver, parameters={"floor": floor}, **options)
    exact = np.array([bounces(t, 0.8, floor) for t in result.time])
    np.testing.assert_allclose(result["height"], exact[:, 0], atol=1e-11)
    np.testing.assert_allclose(result["speed"], exact[:, 1], atol=1e-11)
    np.testing.assert_allclose(result["bounces"], exact[:, 2], atol=1e-12)
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-11)
    impacts = 2 * G * (1 - floor) * 0.8 ** (2 * np.arange(exact[-1, 2]))  # squares of speeds
    taken = np.sum(impacts) * (1 - 0.8**2) / 2
    assert result["energy.dissipated"][-1] == pytest.approx(taken, rel=1e-12)


def test_what_jumps_take_counts_where_no_other_account_is_observed(load):
    """A jump dissipates what it takes from the stored energy, which this scene does not observe."""
    taken = load("jumps", "taken").simulate()["energy.dissipated"]
    exact = [sum(G * 0.64**k for k in range(bounces(t, 0.8, 0)[2])) for t in np.arange(0, 2, 0.01)]
    np.testing.assert_allclose(taken[:-1], np.array(exact) * (1 - 0.64), atol=1e-11)


@pytest.mark.parametrize(("solver", "options"), METHODS)
@pytest.mark.parametrize("e", [0.8, 0.3, 1e-3, 1e-12])
@pytest.mark.parametrize("floor", [0.0, 0.3, -1.7])
def test_a_ball_that_comes_to_rest_ends_the_run_with_a_status(load, solver, options, e, floor):
    """Infinitely many bounces in a finite time: the run ends there, and no ball falls through."""
    ball = load("jumps", "bounce")
    rest = np.sqrt(2 * (1 - floor) / G) * (1 + e) / (1 - e)
    with pytest.raises(SimulationError, match="BG770") as failure:
        ball.simulate(20, every=0.1, solver=solver, parameters={"floor": floor, "e": e}, **options)
    rows = failure.value.result
    np.testing.assert_allclose(rows.time[-1], rest, atol=0.1 + 1e-6)
    assert np.all(rows["height"] > floor - 1e-12)


def test_an_elastic_ball_bounces_on(load):
    result = load("jumps", "bounce").simulate(300, every=0.5, parameters={"e": 1})
    np.testing.assert_allclose(result["energy.dissipated"], 0, atol=1e-9)
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-9)
    assert round(result["bounces"][-1]) == int((300 / np.sqrt(2 / G) + 1) / 2)


def test_two_balls_between_walls(load):
    """Momentum changes at the walls alone, energy nowhere; by an event loop of straight lines."""
    result = load("jumps", "collide").simulate()
    mass, x, v, now = np.array([1.0, 2]), np.array([-0.5, 0.4]), np.array([1.5, 0.5]), 0.0
    places, momenta = [], []
    for row in result.time:
        while True:
            gap, closing = x[1] - x[0] - 0.3, v[0] - v[1]
            times = [gap / closing if closing > 0 else np.inf, *((np.sign(v) - x) / v)]
            first = int(np.argmin(times))
            if now + times[first] > row:
                break
            x, now = x + v * times[first], now + times[first]
            if first == 0:
                v = 2 * (mass * v).sum() / mass.sum() - v
            else:
                v[first - 1] *= -1
        places.append(x + v * (row - now))
        momenta.append(mass * v)
    found = np.column_stack([result["x[1]"], result["x[2]"]])
    np.testing.assert_allclose(found, places, atol=1e-12)
    np.testing.assert_allclose(result["p1"] + result["p2"], np.sum(momenta, axis=1), atol=1e-13)
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-14)
    np.testing.assert_allclose(result["energy.dissipated"], 0, atol=1e-14)


@pytest.mark.parametrize(("solver", "options"), METHODS)
def test_a_thermostat(load, solver, options):
    """The relay switches at 21 and 19 degrees, at the times of two exponentials."""
    result = load("jumps", "regulate").simulate(solver=solver, **options)
    T, on, start, row = 15.0, True, 0.0, []
    for t in result.time:
        while True:
            target, edge = (30.0, 21.0) if on else (10.0, 19.0)
            end = start + 5 * np.log((T - target) / (edge - target))
            if t < end:
                break
            T, on, start = edge, not on, end
        row.append((target + (T - target) * np.exp(-(t - start) / 5), float(on)))
    exact = np.array(row)
    np.testing.assert_allclose(result["T"], exact[:, 0], atol=2e-4 if options else 2e-5)
    np.testing.assert_allclose(result["heats"], exact[:, 1], atol=1e-12)


def test_resets_of_an_integrator_and_of_a_vector(load):
    """A sawtooth phase, and two components exchanged at once at a time."""
    result = load("jumps", "integrate").simulate()
    phase = result.time % 1
    inside = (phase > 1e-6) & (phase < 1 - 1e-6)
    expected = (1 - np.cos(np.pi * phase)) / np.pi
    np.testing.assert_allclose(result["integral"][inside], expected[inside], atol=1e-6)
    np.testing.assert_allclose(result["angle"][inside], 2 * np.pi * phase[inside], atol=1e-12)
    late = result.time >= 1.5
    first, second = np.where(late, 5 + result.time - 1.5, 1 + result.time), 2 + 2 * result.time
    second = np.where(late, 2.5 + 2 * (result.time - 1.5), second)
    np.testing.assert_allclose(result["r[1]"], first, atol=1e-12)
    np.testing.assert_allclose(result["r[2]"], second, atol=1e-12)


@pytest.mark.parametrize(
    ("solver", "options"), [("rodas5p", {}), ("radau5", {}), ("gauss4", {"step": 1e-4})]
)
def test_algebraic_equations_hold_after_a_jump(load, solver, options):
    """The charge is taken away; the current through the diode follows at once."""
    result = load("jumps", "discharge").simulate(solver=solver, **options)
    voltage, current = result["store.e"], result["diode.f"]
    drop = 0.5 * np.log1p(current / 1e-3)
    np.testing.assert_allclose(drop + 10 * current + voltage, 5, atol=1e-8)
    (jump,) = np.flatnonzero(np.diff(voltage) < 0)
    assert voltage.max() < 3 < voltage[jump] + 10 * (voltage[jump] - voltage[jump - 1])
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-8)


def test_jumps_that_cause_each_other_end_with_a_status(load):
    with pytest.raises(SimulationError, match="BG770"):
        load("jumps", "endless").simulate()


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5", "radau5"])
@pytest.mark.parametrize("level", [0.9, 0.999, 0.9999])
def test_a_jump_counts_that_is_over_before_another_event_of_its_step(load, solver, level):
    """The law leaves its piece at the same edge; its return ended the step behind the jump."""
    count = load("jumps", "peaks").simulate(solver=solver, parameters={"level": level})["count"]
    assert count[-1] == 7  # at 5 x = pi/2 + 2 pi k


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5", "radau5"])
@pytest.mark.parametrize("rate", [5, 100])
def test_jumps_of_an_argument_that_turns_many_times_in_a_step_count(load, solver, rate):
    """No law resolves the swing: the steps are shortened until samples do."""
    count = load("jumps", "counted").simulate(solver=solver, parameters={"rate": rate})["count"]
    assert count[-1] == pytest.approx((9 * rate - np.pi / 2) // (2 * np.pi) + 1, abs=1e-9)
