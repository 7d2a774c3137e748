"""Laws that switch: against motions put together from closed forms."""

import numpy as np
import pytest
from piecewise import motion
from scipy.integrate import quad
from scipy.optimize import brentq

from bgc.runtime.running.failures import SimulationError

G = 9.81


def test_a_ball_on_a_spring(load):
    result = load("events", "ball").simulate()
    free = np.array([[0, 1, 0], [0, 0, -G], [0, 0, 0]])  # of height, speed, 1
    touching = np.array([[0, 1, 0], [-1e4, 0, -G], [0, 0, 0]])
    edge = np.array([1.0, 0, 0])
    exact = motion({True: free, False: touching}, edge, [1, 0, 1], result.time, 5e-3, inside=True)
    np.testing.assert_allclose(result["height"], exact[:, 0], atol=1e-9)
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-7)
    assert result.counts["events"] in (4, 5)  # a step may end beyond the last row


def test_events_are_worth_their_price(load):
    """Located, the same tolerance costs less and gives more."""
    located = load("events", "ball").simulate(rtol=1e-7, every=2)
    through = load("events", "unlocated_ball").simulate(rtol=1e-7, every=2)
    exact = 0.91686577663
    assert through.counts["events"] == 0
    assert located.counts["rhs"] < 0.8 * through.counts["rhs"]
    errors = [abs(run["height"][-1] - exact) for run in (located, through)]
    assert errors[0] < 0.1 * errors[1]


def test_a_slack_rope(load):
    result = load("events", "slack_rope").simulate()
    slack = np.array([[0, -1, 0.5], [0, 0, -G], [0, 0, 0]])  # of stretch, speed, 1
    taut = np.array([[0, -1, 0.5], [250, -1.5, 0.75 - G], [0, 0, 0]])
    edge = np.array([1.0, 0, 0])
    exact = motion({True: taut, False: slack}, edge, [-0.2, 0, 1], result.time, 2e-3, inside=False)
    np.testing.assert_allclose(result["stretch"], exact[:, 0], atol=1e-9)
    np.testing.assert_allclose(result["speed"], exact[:, 1], atol=1e-8)
    assert result.counts["events"] >= 8


def test_a_rectifier(load):
    """The diode blocks over most of a period, during which the source must not be lost sight of."""
    result = load("events", "rectifier").simulate()
    source = [[0, 0, 100], [0, -100, 0]]  # of voltage, sin, cos
    conducts = np.array([[-520, 5000, 0], *source])
    blocks = np.array([[-20, 0, 0], *source])
    edge = np.array([-1.0, 10, 0])
    exact = motion({True: conducts, False: blocks}, edge, [0, 0, 1], result.time, 2e-4, inside=True)
    np.testing.assert_allclose(result["voltage"], exact[:, 0], atol=1e-8)
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-9)


def test_switches_of_time_are_landed_on(load):
    model = load("events", "pulses")
    edges = [(k / 4 + late, sign) for k in range(8) for late, sign in ((0, 1), (0.1, -1))]
    edges.append((1.15, 2))
    for arguments in ({}, {"solver": "ros34prw", "step": 0.01}, {"solver": "rk4", "step": 0.01}):
        result = model.simulate(**arguments)
        passed = [np.clip(result.time - at, 0, None) for at, _ in edges]
        exact = sum(size * (1 - np.exp(-t)) for t, (_, size) in zip(passed, edges, strict=True))
        np.testing.assert_allclose(result["lag.x"], exact, atol=2e-7)
        phase = np.fmod(result.time + 1e-9, 0.25)
        clear = (phase > 0.02) & (abs(phase - 0.1) > 0.02)
        source = (phase < 0.1) + 2 * (result.time > 1.149)  # in the new mode at 1.15 s
        np.testing.assert_array_equal(result["lag.source"][clear], source[clear])
        assert result.counts["events"] in (16, 17)  # one of them is at the end


def test_an_oscillation_that_nothing_else_resolves_is_not_lost(load):
    """A square wave on a slow lag: steps of a smooth problem would span many periods."""
    result = load("events", "square").simulate()
    period = np.pi / 40
    x, halves = 0.0, int(20 / period)
    for k in range(halves):
        x = (-1) ** k + (x - (-1) ** k) * np.exp(-period)
    x = (-1) ** halves + (x - (-1) ** halves) * np.exp(-(20 - halves * period))
    assert result["x"][-1] == pytest.approx(x, abs=1e-8)


def test_a_switch_that_is_passed_and_passed_back_within_one_step(load):
    result = load("events", "stone").simulate(every=1.0)  # steps may be long
    assert result.counts["steps"] < 10
    assert result["above"][-1] == pytest.approx(2 * np.sqrt(2e-5), abs=1e-10)


def test_switches_at_one_time(load):
    result = load("events", "together").simulate()
    assert result["first"][-1] == pytest.approx(1, abs=1e-12)
    assert result["last"][-1] == pytest.approx(1 - 150e-15, abs=1e-12)
    exact = 2 - 1.5 * np.exp(-0.15)
    np.testing.assert_allclose(result["twin"][-1], exact, rtol=1e-7)
    np.testing.assert_array_equal(result["twin"][:, 0], result["twin"][:, 1])
    assert result.counts["events"] <= 4


def test_a_switch_in_an_algebraic_equation(load):
    result = load("events", "loop").simulate()

    def time_at(z):
        first = quad(lambda s: (3 * s**2 + 1) / (2 - s), 0, 0.5, epsabs=1e-13)[0]
        return first + quad(lambda s: (3 * s**2 + 3) / (2 - s), 0.5, z, epsabs=1e-13)[0]

    at_one = time_at(brentq(lambda z: z**3 + 3 * z - 2, 0.5, 1))  # when x is 1
    # Also where most rows are inside of steps, and those before the event in the old mode.
    for run in (result, load("events", "loop").simulate(rtol=1e-4)):
        np.testing.assert_allclose(run["w"], np.where(run.time < at_one, 1, 2), atol=1e-9)
    assert result["y"][-1] == pytest.approx(4 - at_one, abs=1e-8)
    z = brentq(lambda z: time_at(z) - 2, 0.5, 1.5, xtol=1e-14)
    assert result["z"][-1] == pytest.approx(z, abs=1e-9)
    assert result["x"][-1] == pytest.approx(z**3 + 3 * z - 1, abs=1e-9)


@pytest.mark.parametrize("arguments", [{}, {"solver": "ros34prw", "step": 0.01}])
def test_friction_slides_and_turns_but_what_sticks_ends_the_run(load, arguments):
    model = load("events", "friction")
    turned = model.simulate(parameters={"push": -2}, **arguments)
    exact = np.where(turned.time < 1 / 3, 1 - 3 * turned.time, 1 / 3 - turned.time)
    np.testing.assert_allclose(turned["block.f"], exact, atol=1e-12)
    with pytest.raises(SimulationError) as caught:
        model.simulate(**arguments)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "BG715"
    assert diagnostic.span is not None and diagnostic.span.text == "sign(f)"
    assert "`block.p`" in diagnostic.message
    kept = caught.value.result
    np.testing.assert_allclose(kept["block.f"], 1 - 0.5 * kept.time, atol=1e-12)
    assert kept.time[-1] == pytest.approx(2, abs=0.01)


@pytest.mark.parametrize("solver", ["rodas5p", "radau5"])
def test_a_law_that_is_undefined_beyond_its_switch(load, solver):
    """In the mode of a full tank, its root is not a number as soon as the tank is empty."""
    result = load("events", "tank").simulate(solver=solver, rtol=1e-8)
    exact = np.clip(1 - result.time / 2, 0, None) ** 2
    np.testing.assert_allclose(result["level"], exact, atol=1e-6)


def test_a_continuous_law_that_comes_to_rest_on_its_switch_goes_on_without_events(load):
    """It chatters by rounding, which does no harm: error control sees to it from there on."""
    result = load("events", "level").simulate(solver="ros34prw", step=0.01)
    exact = np.clip(1 - result.time / 2, 0, None) ** 2
    np.testing.assert_allclose(result["level"], exact, atol=1e-4)
    assert result.counts["events"] <= 110


@pytest.mark.parametrize("arguments", [{}, {"solver": "ros34prw", "step": 0.01}])
def test_a_staircase_is_climbed_step_by_step(load, arguments):
    """Each stair is an event, a thousandth of the step that the smooth equations would allow."""
    result = load("events", "staircase").simulate(**arguments)
    rise, period = 0.1635, 0.489

    def climbed(x):  # the integral of floor(1000 x) over x
        stairs = np.floor(1000 * x)
        return stairs * (stairs - 1) / 2000 + stairs * (x - stairs / 1000)

    x, area = 0.0, 0.0
    for k in range(11):
        top = x + min(rise, 5 - k * period)
        area += climbed(top) - climbed(x)
        area += np.floor(1000 * top) * max(0.0, min(period, 5 - k * period) - rise)
        x = top
    assert result["x"][-1] == pytest.approx(x, abs=1e-9)
    assert result["area"][-1] == pytest.approx(area, rel=1e-9)
    assert result.counts["events"] == pytest.approx(np.floor(1000 * x) + 21, abs=8)


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5"])
def test_a_jump_that_holds_its_only_state_at_the_edge_ends_the_run(load, solver):
    with pytest.raises(SimulationError, match="BG715") as caught:
        load("events", "edge").simulate(solver=solver)
    assert caught.value.result.time[-1] == pytest.approx(1.0)
    assert abs(caught.value.result["x"][-1]) < 1e-9
