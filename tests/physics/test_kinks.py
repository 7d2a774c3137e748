"""Kinks of abs, min and max are located as jumps are, whatever the method."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import bgc

METHODS = [
    {},
    {"rtol": 1e-9},
    {"solver": "rodas4p2"},
    {"solver": "radau5"},
    {"solver": "dopri5"},
    {"solver": "ros34prw", "step": 0.01},
    {"solver": "rk4", "step": 0.01},
]


def saturated_follower(end: float, limit: float = 1.0) -> float:
    """x(end) of x' = clamp(10 (sin 5t - x), +-limit), put together from smooth pieces."""

    def error(t: float, y: np.ndarray) -> float:
        return 10 * (math.sin(5 * t) - y[0])

    t, x, side = 0.0, 0.0, 0
    while t < end:
        edges = [
            lambda t, y, level=level: error(t, y) - level
            for level in ((-limit, limit) if side == 0 else (side * limit,))
        ]
        for edge in edges:
            edge.terminal = True
        rate = (lambda t, y: [error(t, y)]) if side == 0 else (lambda t, y, s=side: [s * limit])
        piece = solve_ivp(
            rate, (t, end), [x], "DOP853", events=edges, rtol=1e-12, atol=1e-14, max_step=0.05
        )
        t, x = piece.t[-1], piece.y[0, -1]
        if piece.status == 1:
            side = 0 if side else (-1 if len(piece.t_events[0]) else 1)
            t, x = t + 1e-13, x  # beyond the edge
    return float(x)


@pytest.fixture(scope="module")
def follower_end() -> float:
    return saturated_follower(5.0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scene", ["follower", "driven", "pushed"])
def test_a_saturated_controller(load, follower_end, scene, method):
    result = load("kinks", scene).simulate(**method)
    assert result["x"][-1] == pytest.approx(follower_end, abs=5e-6)
    assert result.counts["events"] in (17, 18)  # a step may end beyond the last row


def rain(level: float) -> float:
    """Rain of 100 s: 18 humps of a sine above the level."""
    start = math.asin(level)
    return 18 * (2 * math.cos(start) - level * (math.pi - 2 * start)) / 1.1


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("level", [0.9, 0.999])
@pytest.mark.parametrize("scene", ["rain", "waves"])
def test_a_clamp_that_is_left_for_less_than_a_step(load, scene, level, method):
    result = load("kinks", scene).simulate(**method, parameters={"level": level})
    drift = 200 * method.get("rtol", 1e-6)  # of the oscillator, over 18 periods
    assert result["p"][-1] == pytest.approx(rain(level), abs=drift)
    assert result.counts["events"] == 36


@pytest.mark.parametrize("method", METHODS)
def test_every_form_of_a_kink(load, method):
    result = load("kinks", "forms").simulate(**method)
    forms = {
        "larger": lambda t: max(math.sin(t), math.cos(t)),
        "size": lambda t: abs(math.sin(t)),
        "product": lambda t: abs(math.cos(t)),
        "nearest": lambda t: min(math.sin(t), math.cos(t), 0.5),
    }
    kinks = np.arange(1, 7 * 12) * math.pi / 12
    for name, form in forms.items():
        edges = [0, *(k for k in kinks if k < 20), 20]
        exact = sum(quad(form, a, b)[0] for a, b in itertools.pairwise(edges))
        assert result[name][-1] == pytest.approx(exact, abs=5e-6)


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("ros34prw", 3), ("rodas23w", 2)])
def test_fixed_steps_keep_their_order_across_kinks(load, follower_end, method, order):
    steps = (0.02, 0.01, 0.005, 0.0025, 0.00125)
    model = load("kinks", "driven")
    runs = [model.simulate(solver=method, step=step, every=0.2) for step in steps]
    errors = [abs(run["x"][-1] - follower_end) for run in runs]
    assert np.log2(errors[0] / errors[-1]) / 4 > order - 0.2


@pytest.mark.parametrize("method", [{}, {"solver": "ros34prw", "step": 0.01}])
def test_the_rounding_of_a_body_at_rest_ends_no_step(load, method):
    result = load("kinks", "settling").simulate(**method)
    assert result["x"][-1] == pytest.approx(-0.0981, abs=1e-7)
    assert 2 <= result.counts["events"] <= 20


@pytest.fixture(scope="module")
def valve_at_rest(tmp_path_factory):
    """p rests from 0.4 s on at the edge, 1, about which it moves by rounding; then it is lifted."""
    path = tmp_path_factory.mktemp("rest") / "rest.bg"
    path.write_text("""
model Rest {
  state p = 0.5;
  let rounding = 1e6*sin(time)*cos(time) - 5e5*sin(2*time);
  let since = max(time - 12, 0);
  der(p) = 100*max(1 - p, 0) - 200*max(p - 1, 0) + rounding + since^2;
}
scene s of Rest { observe p; run 13 s every 0.1 s; }
""")
    return bgc.compile(path)


@pytest.mark.parametrize(
    ("method", "error", "stages"),
    [
        ({"rtol": 1e-10}, 1e-10, None),
        ({"solver": "ros23", "step": 0.01}, 1e-6, 2),
        ({"solver": "ros34prw", "step": 0.01}, 1e-9, 4),
    ],
)
def test_rest_on_the_edge_of_a_kink_costs_little_and_is_left_in_time(
    valve_at_rest, method, error, stages
):
    """Only about every eighth step looks at how much f changes, for three evaluations of f."""
    result = valve_at_rest.simulate(**method, error=False)
    lifted = 1 / 200 - 2 / 200**2 + 2 / 200**3
    assert result["p"][-1] == pytest.approx(1 + lifted, abs=error)
    assert np.abs(result["p"][10:120] - 1).max() < 1e-9
    if stages is not None:
        assert result.counts["rhs"] < (stages + 0.6) * result.counts["steps"]


@pytest.mark.slow
@pytest.mark.parametrize("method", [{}, {"solver": "dopri5"}, {"solver": "ros34prw", "step": 0.01}])
def test_instances_of_an_ensemble_cross_kinks_as_alone(load, method):
    limits = np.linspace(0.7, 1.4, 9)
    model: bgc.Model = load("kinks", "driven")
    together = model.simulate_many({"limit": limits}, **method)
    assert together.together == 9
    exact = [saturated_follower(5.0, limit) for limit in limits]
    np.testing.assert_allclose(together["x"][:, -1], exact, atol=1e-5)


@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize(
    ("law", "end"),
    [
        ("if s > 0 then s else 0", 1 + math.exp(-2)),
        ("if s > 0 then 1 else 0", 1 - math.exp(-2)),
        ("max(s, 0) - max(-s, 0)", 1 + math.exp(-2)),
    ],
)
def test_a_switch_of_time_behind_another_that_begins_at_the_same_instant(
    tmp_path, method, law, end
):
    """The second is one bit of the time later: the samples of that step are rounded to its ends."""
    path = tmp_path / "m.bg"
    path.write_text(
        f"model M {{ state x = 0; let s = max(time - 1, 0); der(x) = ({law}) - x; }}\n"
        "scene s of M { observe x; run 3 s; }\n"
    )
    result = bgc.compile(path).simulate(**method)
    assert result["x"][-1] == pytest.approx(end, rel=1e-4)


@pytest.mark.parametrize("method", [{}, {"solver": "dopri5"}, {"solver": "rk4", "step": 0.1}])
def test_a_kink_that_no_state_feels_is_right_in_the_rows(tmp_path, method):
    """The step that passes it over shows the value of the branch at each row."""
    path = tmp_path / "slack.bg"
    path.write_text("""
model Slack {
  state q = 0.5;
  der(q) = cos(time);
  output pull = 1000*max(q, 0);
  state total = 1e13;
  der(total) = pull;
}
scene s of Slack { observe pull, q, total; run 12 s every 0.05 s; }
""")
    result = bgc.compile(path).simulate(**method)
    np.testing.assert_allclose(result["pull"], 1000 * np.maximum(result["q"], 0), atol=1e-9)


@pytest.fixture(scope="module")
def piston(tmp_path_factory):
    """A mass behind dampers of c abs(v)^n at a force that turns its motion round."""
    forms = {
        "literal": "2*sign(f)*abs(f)^0.3",
        "parameter": "2*sign(f)*abs(f/1 m/s)^n",
        "chosen": "if f > 0 then 2*f^0.3 else -2*(-f)^0.3",
        "hypotenuse": "2*sign(f)*hypot(f, 0)^0.3",
    }
    path = tmp_path_factory.mktemp("piston") / "piston.bg"
    models = "".join(
        f"model {name.title()} {{ param n = 0.3; mass : I(1 kg, f0 = 1 m/s); motion : J1; "
        f"push : Se(-3 N); oil : MR {{ e = {law}; }} "
        f"push -> motion -> mass, oil; }}\n"
        f"scene {name} of {name.title()} {{ observe motion.f; run 2 s every 0.1 s; }}\n"
        for name, law in forms.items()
    )
    path.write_text(models, encoding="utf-8")
    return path


@pytest.mark.parametrize("method", METHODS[:1] + METHODS[3:6])
@pytest.mark.parametrize("scene", ["literal", "parameter", "chosen", "hypotenuse"])
def test_a_damper_of_a_power_below_one_lets_its_mass_turn_round(piston, scene, method):
    """The slope of abs(v)^0.3 is infinite at v = 0: no step may be held there."""
    result = bgc.compile(piston, scene=scene).simulate(**method)
    turned, _ = quad(lambda v: 1 / (3 + 2 * v**0.3), 0, 1, epsabs=1e-12)
    speed = -result["motion.f"][-1]
    back, _ = quad(lambda v: 1 / (3 - 2 * v**0.3), 0, speed, epsabs=1e-12)
    assert turned + back == pytest.approx(2, abs=2e-3 if "step" in method else 2e-5)
