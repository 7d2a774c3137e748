"""The knuckle-boom crane against Lagrange's equations by SymPy, and with its whole hydraulics."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bgc
import bgc.library

G = 9.81
SCENE = Path(bgc.library.__path__[0]) / "scenes" / "knuckle_boom_hydraulic.bg"


@cache
def lagrange():
    """Mass matrix, its derivatives by the angles, and gravity's torques, as functions of angles."""
    import sympy as sp

    q = sp.symbols("q1:4", real=True)
    slew, luff, fold = q[0], q[1], q[1] + q[2]
    turn = sp.rot_ccw_axis3(slew)

    def up(angle):
        """Turned axes to those of the base: about the vertical, then upwards."""
        c, s = sp.cos(angle), sp.sin(angle)
        return turn * sp.Matrix([[c, 0, -s], [0, 1, 0], [s, 0, c]])

    foot = sp.Matrix([0, 0, sp.Rational("2.2")])
    boom, jib = up(luff), up(fold)
    x = sp.Matrix([1, 0, 0])
    bodies = (
        (1524, sp.Matrix([0, 0, sp.Rational("1.55")]), turn, (1178, 1265, 328)),
        (2236, foot + boom * x * sp.Rational("3.458"), boom, (371, 7971, 7995)),
        (1264, foot + boom * x * 7 + jib * x * sp.Rational("2.105"), jib, (129, 3114, 3162)),
    )
    mass = sp.zeros(3, 3)
    height = 0
    for m, centre, axes, moments in bodies:
        linear = centre.jacobian(q)
        columns = []
        for each in q:
            spin = axes.T * axes.diff(each)
            columns.append(sp.Matrix([spin[2, 1], spin[0, 2], spin[1, 0]]))
        angular = sp.Matrix.hstack(*columns)
        mass += m * linear.T * linear + angular.T * sp.diag(*moments) * angular
        height += m * centre[2]
    changes = [mass.diff(each) for each in q]
    torque = [-sp.Float(G) * sp.diff(height, each) for each in q]
    functions = sp.lambdify(q, [mass, *changes, torque, height], "numpy", cse=True)

    def evaluate(angles):
        m, *rest, pull, lifted = functions(*angles)
        return np.array(m, float), np.array(rest, float), np.array(pull, float), G * lifted

    return evaluate


def angles_of(boom, jib):
    """Angles at which the cylinders have these lengths."""
    a1, b1, a2, b2 = 1.485, 2.831, 2.955, 1.002
    luff = np.arccos((a1**2 + b1**2 - boom**2) / (2 * a1 * b1)) - 0.7869
    fold = np.arccos((a2**2 + b2**2 - jib**2) / (2 * a2 * b2)) + 3.2074 - 2 * np.pi
    return luff, fold


@pytest.mark.parametrize(
    ("slew", "boom", "jib", "rates", "torque"),
    [
        (0.0, 2.9, 2.9, (0.3, -0.2, 0.5), (0, 0, 0)),
        (-2.0, 2.1, 3.7, (-0.8, 0.4, -0.3), (2e4, 1.8e5, 4e4)),
        (3.0, 3.7, 2.1, (0.5, -0.6, 0.2), (-3e4, 1e5, 5e4)),
    ],
)
def test_the_mechanism_moves_as_lagranges_equations_say(load, slew, boom, jib, rates, torque):
    given = {
        "crane.slew0": slew,
        "crane.boom_cylinder0": boom,
        "crane.jib_cylinder0": jib,
        "rate0": rates,
        "torque": torque,
    }
    result = load("knuckle_boom", "free").simulate(parameters=given)

    def slope(_, state):
        angles, speed = state[:3], state[3:]
        mass, changes, pull, _ = lagrange()(angles)
        turning = np.einsum("kij,k,j->i", changes, speed, speed)
        centrifugal = np.einsum("kij,i,j->k", changes, speed, speed) / 2
        forces = np.array(torque) + pull + centrifugal - turning
        return np.concatenate([speed, np.linalg.solve(mass, forces)])

    start = np.array([slew, *angles_of(boom, jib), *rates])
    exact = solve_ivp(slope, (0, 2), start, "DOP853", result.time, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(result["angles"], exact.y[:3].T, atol=1e-9)
    np.testing.assert_allclose(result["rates"], exact.y[3:].T, atol=1e-9)
    assert np.abs(exact.y[1, -1] - exact.y[1, 0]) > 0.1
    assert np.abs(result["energy.residual"]).max() < 1e-9 * result.counts["exchanged"]


def test_momentum_about_the_slew_axis_needs_a_torque(load):
    """The inertia about it halves while the boom falls: d/dt(M q') with +dT/dq, not C q'."""
    model = load("knuckle_boom", "free")
    result = model.simulate()
    states = zip(result["angles"], result["rates"], strict=True)
    found = [(m[0] @ rate, m[0, 0]) for angles, rate in states for m in [lagrange()(angles)[0]]]
    momentum, inertia = np.array(found).T
    assert np.ptp(inertia) > 0.1 * inertia[0]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)

    still = model.simulate(parameters={"rate0": (0.0, 0.6, -0.5)})
    assert np.abs(still["rates"][:, 0]).max() < 1e-12, "nothing turns it"
    assert np.ptp(still["rates"][:, 1]) > 0.1


def test_holding_torques_are_those_of_gravity(load):
    result = load("knuckle_boom", "free").simulate()
    pull = np.array([lagrange()(angles)[2] for angles in result["angles"]])
    np.testing.assert_allclose(result["holding"], -pull, rtol=1e-9, atol=1e-6)


def test_it_is_a_crane_like_the_others(load):
    """The drives carry its weight, and the handle moves the tip."""
    held = load("knuckle_boom", "held").simulate()
    assert np.ptp(held["angles"], axis=0).max() < 1e-12
    start = [held["reach0"][0], 0, held["rise0"][0]]
    np.testing.assert_allclose(held["reach"][0], start, atol=1e-12)
    assert held["tilt0"][0] == pytest.approx(held["angles"][0, 1:].sum(), abs=1e-12)
    steered = load("knuckle_boom", "session").simulate()
    assert steered["reach"][-1, 2] - steered["reach"][0, 2] > 0.3
    assert np.abs(steered["energy.residual"]).max() < 1e-2


@cache
def scene(name):
    return bgc.compile(SCENE, scene=name)


@cache
def reference():
    return scene("knuckle_boom_hydraulic").simulate(solver="rodas5p", rtol=1e-9)


def test_the_hydraulic_crane_is_one_model_at_a_millisecond():
    """The stroke within 1 mm, as the issue asks; 1.1 um were measured."""
    result = scene("knuckle_boom_hydraulic").simulate()
    assert len(scene("knuckle_boom_hydraulic").initial_state()) == 50
    assert np.ptp(reference()["stroke"], axis=0).min() > 0.2
    assert np.abs(result["stroke"] - reference()["stroke"]).max() < 1e-5
    assert np.abs(result["angles"] - reference()["angles"]).max() < 1e-4


def test_the_hydraulic_crane_takes_few_adaptive_steps():
    model = scene("knuckle_boom_hydraulic")
    result = model.simulate(solver="rodas4p2", rtol=1e-4)
    assert result.counts["steps"] + result.counts["rejected"] <= 1000
    assert np.abs(result["stroke"] - reference()["stroke"]).max() < 5e-5


def test_the_hydraulic_crane_starts_at_rest_and_closes_its_energies():
    result = scene("energies").simulate()
    before = result.time < 1
    assert np.ptp(result["stroke"][before], axis=0).max() < 1e-10
    assert np.diff(result["energy.dissipated"]).min() > -1e-3
    assert np.abs(result["energy.residual"]).max() < 1e-7 * result.counts["exchanged"]


def test_thrown_valves_and_end_stops_keep_the_step_of_a_millisecond(load):
    model = load("knuckle_boom", "thrown")
    exact = model.simulate(solver="rodas5p", rtol=1e-7)
    stroke = exact["stroke"]
    assert (stroke.max(axis=0) > 1.6).any() and (stroke.min(axis=0) < 0).any(), "on both stops"
    assert (stroke > -0.01).all() and (stroke < 1.611).all()
    result = model.simulate()
    assert np.abs(result["stroke"] - stroke).max() < 1e-4
    assert np.abs(result["energy.residual"]).max() < 1e-3 * result.counts["exchanged"]
