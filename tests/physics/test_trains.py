"""One-dimensional mechanics, friction and heat of the library, against independent answers."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp


@pytest.fixture(scope="module")
def linear(load):
    return load("trains", "linear").simulate()


@pytest.fixture(scope="module")
def rubbing(load):
    return load("trains", "rubbing").simulate()


def solved(rates, start, result, **options):
    """States by DOP853 at the times of the rows."""
    run = solve_ivp(
        rates, (0, result.time[-1]), start, "DOP853", result.time, rtol=1e-11, atol=1e-12, **options
    )
    return run.y


def test_masses_on_struts_move_by_newtons_law(linear):
    def rates(_, y):
        x1, x2, v1, v2 = y
        first = 100 * x1 + 0.5 * v1
        middle = 50 * (x1 - x2)
        last = 80 * (x2 + 0.01)
        return [v1, v2, (middle * -1 - first) / 2, middle - last]

    x1, x2, _, _ = solved(rates, [0, 0, 1, 0], linear)
    np.testing.assert_allclose(linear["mass1.position"], x1, atol=1e-8)
    np.testing.assert_allclose(linear["mass2.position"], x2, atol=1e-8)
    np.testing.assert_allclose(linear["strut3.force"], 80 * (x2 + 0.01), atol=1e-6)


def test_rotors_are_coupled_by_a_spring_a_gear_and_a_damper(linear):
    """The wheel of the gear turns at w3; the shaft behind it at -w3/3."""

    def rates(_, y):
        _, _, twist, w1, w2, w3 = y
        spring = 20 * twist + 0.2 * (w1 - w3)
        brake = 0.7 * (-w3 / 3 - w2)
        return [w1, w2, w1 - w3, (3 - spring) / 0.5, brake / 2, (spring + brake / 3) / 0.1]

    y = solved(rates, [0, 0, 0, 0, 0.3, 0], linear)
    np.testing.assert_allclose(linear["rotor1.angle"], y[0], atol=1e-7)
    np.testing.assert_allclose(linear["rotor2.angle"], y[1], atol=1e-7)
    torque = 20 * y[2] + 0.2 * (y[3] - y[5])
    np.testing.assert_allclose(linear["winding.torque"], torque, atol=1e-6)


def test_a_screw_and_a_lever_lift_a_weight(linear):
    """Three turns a second, 5 mm each, doubled and turned round."""
    np.testing.assert_allclose(linear["lifted.position"], -0.03 * linear.time, atol=1e-12)
    np.testing.assert_allclose(linear["crank.torque"], 98.1 * 2 * 5e-3 / (2 * np.pi), rtol=1e-9)


def test_a_buffer_sends_a_mass_back(rubbing):
    """Contact lasts half a period, and begins at t = 0.5 m over 3 m/s."""
    frequency, start = np.sqrt(1e5 / 2), 0.5 / 3
    phase = np.clip(frequency * (rubbing.time - start), 0, np.pi)
    np.testing.assert_allclose(rubbing["thrown.velocity"], 3 * np.cos(phase), atol=2e-6)
    force = 3 * np.sqrt(1e5 * 2) * np.sin(phase)
    np.testing.assert_allclose(rubbing["buffer.force"], force, atol=2e-3)


def test_dry_friction_brings_a_sled_to_rest(rubbing):
    """Under a push of 0.4 of the friction: rest after 1 s and 1 m, then creep."""
    t = np.minimum(rubbing.time, 1)
    np.testing.assert_allclose(rubbing["sled.position"], 2 * t - t**2, atol=4e-5)
    creep = 1e-5 * np.arctanh(0.4)
    np.testing.assert_allclose(rubbing["sled.velocity"][rubbing.time > 1.1], creep, rtol=1e-4)


def test_bristles_hold_without_creep(rubbing):
    """The sled stands, bent by the push; when that ends, the bristles straighten again."""
    standing = (rubbing.time > 2.5) & (rubbing.time < 3)
    assert np.abs(rubbing["sled2.velocity"][standing]).max() < 1e-7
    assert np.ptp(rubbing["sled2.position"][standing]) < 1e-8
    bend = rubbing["bristles.bend"]
    np.testing.assert_allclose(bend[standing][-1], 4 / 1e4, rtol=1e-4)
    np.testing.assert_allclose(bend.max(), 10 / 1e4, rtol=1e-3)
    assert abs(bend[-1]) < 1e-8


def test_a_clutch_takes_a_rotor_along(rubbing):
    """It closes from 1 s to 2 s; the rotor follows with its capacity and reaches 50 rad/s."""
    closing = np.clip(rubbing.time - 1, 0, 1)
    rate = 20 / 0.4 * (closing**2 / 2 + np.maximum(rubbing.time - 2, 0))
    np.testing.assert_allclose(rubbing["driven.rate"], np.minimum(rate, 50), atol=1e-3)
    energy = rubbing["energy.residual"]
    assert np.abs(energy).max() < 1e-6 * 0.5 * 0.4 * 50**2 * 10


def test_a_one_way_clutch_drives_and_lets_run(rubbing):
    """Driven to 30 rad/s with the time constant 0.4/2 for 1 s, then free."""
    rate = 30 * -np.expm1(-np.minimum(rubbing.time, 1) / 0.2)
    np.testing.assert_allclose(rubbing["coasting"], rate, atol=1e-5)


def test_a_wheel_rattles_in_its_play(load):
    """Free flight through the play, then half a period against the teeth."""
    result = load("trains", "rattle").simulate()
    frequency = np.sqrt(500 / 0.05)
    flight, contact = 0.2 / 2, np.pi / frequency
    since = (result.time + flight / 2) % (2 * (flight + contact))
    side = np.where(since < flight + contact, 1, -1)
    since = since % (flight + contact)
    phase = frequency * np.clip(since - flight, 0, None)
    angle = np.where(since < flight, 2 * since - 0.1, 0.1 + 2 / frequency * np.sin(phase))
    np.testing.assert_allclose(result["wheel.angle"], side * angle, atol=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-6


def test_a_body_cools_by_all_ways(load):
    result = load("trains", "cooling").simulate()

    def rates(t, y):
        body, casing = y
        conducted = 2 * (body - casing)
        convected = (0.5 + 0.01 * t) * (casing - 290)
        radiated = 0.05 * 5.670374419e-8 * (casing**4 - 290**4)
        return [-conducted / 500, (conducted + 25 - convected - radiated) / 100]

    body, casing = solved(rates, [400, 300], result)
    np.testing.assert_allclose(result["body.temperature"], body, atol=1e-6)
    np.testing.assert_allclose(result["casing.temperature"], casing, atol=1e-6)
    radiated = 0.05 * 5.670374419e-8 * (casing**4 - 290**4)
    np.testing.assert_allclose(result["radiated"], radiated, atol=1e-6)
    whole = radiated + (0.5 + 0.01 * result.time) * (casing - 290)
    np.testing.assert_allclose(result["room.heat_flow"], whole, atol=1e-5)


@pytest.mark.parametrize("ratio", [1.0, 2.5, 60.0])
@pytest.mark.parametrize("inertia", [(0.5, 2, 3), (1e-3, 1, 1e3), (1, 1e-3, 1e-3)])
def test_a_planetary_gear_between_rotors(load, ratio, inertia):
    """Accelerations of three inertias under one constraint, and the torque of the sun."""
    way = np.array([1, -(1 + ratio), ratio])
    matrix = np.block([[np.diag(inertia), way[:, None]], [way[None, :], np.zeros((1, 1))]])
    *rates, torque = np.linalg.solve(matrix, [3, 0, 0, 0])
    given = {"ratio": ratio, "inertia": list(inertia)}
    result = load("trains", "planetary").simulate(parameters=given)
    np.testing.assert_allclose(result["rates"][-1], rates, rtol=1e-7, atol=1e-9)
    assert result["torque"][-1] == pytest.approx(torque, rel=1e-7)
    assert np.abs(result["energy.residual"]).max() < 1e-8 * result.counts["exchanged"]
