"""The tutorials' models against equations that are written here by hand, and closed formulas."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import bgc
from bgc.runtime.model import Model

EXAMPLES = Path(__file__).parents[2] / "library" / "examples"
GRAVITY = 9.81


@cache
def example(name: str, scene: str) -> Model:
    return bgc.compile(EXAMPLES / f"{name}.bg", scene=scene)


def reference(rates, start, times, method="DOP853"):
    """Rows of y' = rates(t, y) at the times, by SciPy."""
    found = solve_ivp(rates, (0, times[-1]), start, method, times, rtol=1e-10, atol=1e-12)
    assert found.success
    return found.y.T


# --- motor with gearbox -------------------------------------------------------------------

MOTOR = {"U": 24, "R": 1.2, "L": 1.5e-3, "k": 0.05, "J": 20e-6, "b": 15e-6}
LOAD = {"n": 20, "J": 0.05, "b": 0.2, "stiffness": 150, "damping": 0.05}


def drive_matrix(m, d):
    """Rates of current, motor speed, twist and load speed."""
    n, c, k = d["n"], d["damping"], d["stiffness"]
    return np.array(
        [
            [-m["R"] / m["L"], -m["k"] / m["L"], 0, 0],
            [m["k"] / m["J"], -(m["b"] + c / n**2) / m["J"], -k / n / m["J"], c / n / m["J"]],
            [0, 1 / n, 0, -1],
            [0, c / n / d["J"], k / d["J"], -(c + d["b"]) / d["J"]],
        ]
    )


def from_rest(matrix, push, times):
    """x of x' = A x + b from 0."""
    return np.array([np.linalg.solve(matrix, (expm(matrix * t) - np.eye(len(push))) @ push)
                     for t in times])  # fmt: skip


@pytest.mark.parametrize("changed", [{}, {"R": 3, "k": 0.08, "L": 0.01}, {"J": 1e-4, "U": -12}])
def test_the_motor_runs_up(changed):
    m = MOTOR | changed
    result = example("motor_gearbox", "motor").simulate(parameters=changed, rtol=1e-9)
    matrix = [[-m["R"] / m["L"], -m["k"] / m["L"]], [m["k"] / m["J"], -m["b"] / m["J"]]]
    exact = from_rest(np.array(matrix), np.array([m["U"] / m["L"], 0]), result.time)
    np.testing.assert_allclose(result["current"], exact[:, 0], atol=1e-6)
    np.testing.assert_allclose(result["speed"], exact[:, 1], atol=1e-4)


@pytest.mark.parametrize("changed", [{}, {"n": 5}, {"n": 60, "J": 1, "b": 0.5}])
def test_a_rigid_gear_adds_the_loads_inertia_by_the_square_of_its_ratio(changed):
    m, d = MOTOR, LOAD | changed
    model = example("motor_gearbox", "rigid")
    assert len(model.states) == 2
    result = model.simulate(parameters=changed, rtol=1e-9)
    inertia, friction = m["J"] + d["J"] / d["n"] ** 2, m["b"] + d["b"] / d["n"] ** 2
    matrix = [[-m["R"] / m["L"], -m["k"] / m["L"]], [m["k"] / inertia, -friction / inertia]]
    exact = from_rest(np.array(matrix), np.array([m["U"] / m["L"], 0]), result.time)
    np.testing.assert_allclose(result["motor_speed"], exact[:, 1], atol=1e-4)
    np.testing.assert_allclose(result["load_speed"], exact[:, 1] / d["n"], atol=1e-4)


@pytest.mark.parametrize(
    "changed", [{}, {"n": 5, "stiffness": 2000}, {"damping": 0, "motor.R": 0.3, "motor.U": 48}]
)
def test_the_elastic_drive_in_time_and_frequency(changed):
    d = LOAD | changed
    m = MOTOR | {k.removeprefix("motor."): v for k, v in changed.items() if "motor." in k}
    matrix = drive_matrix(m, d)
    push = np.array([1 / m["L"], 0, 0, 0])
    model = example("motor_gearbox", "drive")
    result = model.simulate(parameters=changed, rtol=1e-9)
    exact = from_rest(matrix, m["U"] * push, result.time)
    np.testing.assert_allclose(result["current"], exact[:, 0], atol=1e-5)
    np.testing.assert_allclose(result["motor_speed"], exact[:, 1], atol=1e-4)
    np.testing.assert_allclose(result["load_speed"], exact[:, 3], atol=1e-5)
    np.testing.assert_allclose(result["torque"], d["stiffness"] * exact[:, 2], atol=1e-4)
    for name, value in changed.items():
        model.parameters[name] = value
    linear = model.linearise(["motor.supply.e"])
    for name in changed:
        model.parameters[name] = (LOAD | {f"motor.{k}": v for k, v in MOTOR.items()})[name]
    row = list(linear.outputs).index("load_speed")
    for omega in np.geomspace(0.1, 1e4, 30):
        by_hand = np.linalg.solve(1j * omega * np.eye(4) - matrix, push)[3]
        inner = np.linalg.solve(1j * omega * np.eye(4) - linear.A, linear.B[:, 0])
        assert linear.C[row] @ inner + linear.D[row, 0] == pytest.approx(by_hand, rel=1e-9)


# --- two tanks ------------------------------------------------------------------------------


@pytest.mark.parametrize("changed", [{}, {"area": 1, "level0": 3}, {"hole": 5e-4, "level0": 0.5}])
def test_a_tank_empties_as_torricelli_says(changed):
    p = {"area": 0.5, "level0": 2, "hole": 2e-3} | changed
    result = example("two_tanks", "emptying").simulate(parameters=changed, rtol=1e-9)
    root = math.sqrt(p["level0"]) - p["hole"] / p["area"] * math.sqrt(GRAVITY / 2) * result.time
    assert root[-1] > 0.1, "it must not run empty"
    np.testing.assert_allclose(result["level"], root**2, rtol=1e-5)


def torricelli(pressure):
    """Flow through a unit hole."""
    return math.copysign(math.sqrt(abs(pressure) / 500), pressure)


@pytest.mark.parametrize(
    "changed",
    [{}, {"pumped": 3e-3, "change": 50}, {"hole[1]": 1e-3, "slope": 1, "level0[2]": 0.2}],
)
def test_two_tanks_by_their_levels(changed):
    p = {"pumped": 8e-3, "pumped_later": 4e-3, "change": 200, "slope": 0.5, "area": 0.5}
    p |= {"hole[1]": 2e-3, "hole[2]": 2e-3, "level0[1]": 1, "level0[2]": 0.5} | changed
    result = example("two_tanks", "tanks").simulate(parameters=changed, rtol=1e-9)

    def rates(pumped):
        def levels(_, h):
            between = p["hole[1]"] * torricelli(9810 * (h[0] - h[1]))
            out = p["hole[2]"] * torricelli(9810 * h[1])
            surface = math.pi * (p["slope"] * h[1]) ** 2
            return [(pumped - between) / p["area"], (between - out) / surface]

        return levels

    before = result.time < p["change"]
    early = np.append(result.time[before], p["change"])
    first = reference(rates(p["pumped"]), [p["level0[1]"], p["level0[2]"]], early)
    late = np.insert(result.time[~before], 0, p["change"]) - p["change"]
    late = late[1:] if late[1] == 0 else late
    second = reference(rates(p["pumped_later"]), first[-1], late)
    exact = np.vstack([first[:-1], second[-np.count_nonzero(~before) :]])
    np.testing.assert_allclose(result["level"], exact, rtol=1e-5)
    exchanged = result["energy.supplied"][-1]
    assert np.abs(result["energy.residual"]).max() < 1e-6 * exchanged


def test_the_tanks_settle_where_the_pump_runs_through_both_holes():
    for pumped in (8e-3, 5e-3):
        model = example("two_tanks", "tanks")
        model.parameters["pumped"] = pumped
        linear = model.linearise(["pumped"], at="steady")
        model.parameters["pumped"] = 8e-3
        step = 500 * (pumped / 2e-3) ** 2 / 9810
        volumes = [0.5 * 2 * step, math.pi / 3 * 0.25 * step**3]
        np.testing.assert_allclose(linear.point, volumes, rtol=1e-6)


# --- quarter car ----------------------------------------------------------------------------

CAR = {"wheel_mass": 40, "body_mass": 300, "tyre": 2e5, "suspension": 2e4, "damping": 1500}


def car_rates(c, road):
    """Rates of wheel and body, their heights and velocities, over a road height of time."""

    def rates(t, y):
        wheel, body, wheel_rate, body_rate = y
        strut = c["suspension"] * (wheel - body) + c["damping"] * (wheel_rate - body_rate)
        contact = c["tyre"] * (road(t) - wheel)
        return [
            wheel_rate, body_rate, (contact - strut) / c["wheel_mass"], strut / c["body_mass"]
        ]  # fmt: skip

    return rates


CARS = [{}, {"car.damping": 300, "bump.speed": 4}, {"car.body_mass": 500, "bump.length": 3}]


@pytest.mark.parametrize("changed", CARS)
def test_the_car_over_the_bump(changed):
    c = CAR | {k.removeprefix("car."): v for k, v in changed.items()}
    length = changed.get("bump.length", 1) / changed.get("bump.speed", 10)

    def road(t):
        return 0.025 * (1 - math.cos(2 * math.pi * np.clip((t - 0.5) / length, 0, 1)))

    result = example("quarter_car", "over_bump").simulate(parameters=changed, rtol=1e-9)
    found = solve_ivp(
        car_rates(c, road), (0, 3), np.zeros(4), "DOP853", result.time,
        rtol=1e-10, atol=1e-13, max_step=0.01,
    ).y.T  # fmt: skip
    heights = np.array([road(t) for t in result.time])
    np.testing.assert_allclose(result["z"][:, 0], heights, atol=1e-7)
    np.testing.assert_allclose(result["z"][:, 1:], found[:, :2], atol=1e-7)
    np.testing.assert_allclose(result["grip"], c["tyre"] * (heights - found[:, 0]), atol=1e-2)
    accelerations = [car_rates(c, road)(t, y)[3] for t, y in zip(result.time, found, strict=True)]
    np.testing.assert_allclose(result["acceleration"], accelerations, atol=1e-4)


def test_the_car_in_matrices_moves_as_the_other():
    changed = {"car.mass[2]": 500, "car.damping[2]": 800, "bump.height": 0.08}
    names = {"car.body_mass": 500, "car.damping": 800, "bump.height": 0.08}
    one = example("quarter_car", "matrices").simulate(parameters=changed, rtol=1e-9)
    two = example("quarter_car", "over_bump").simulate(parameters=names, rtol=1e-9)
    np.testing.assert_allclose(one["z"], two["z"], atol=1e-8)


def test_the_car_on_the_recorded_road():
    rows = np.loadtxt(EXAMPLES / "road.csv", delimiter=",", skiprows=1)
    result = example("quarter_car", "on_track").simulate(parameters={"body_mass": 250})

    def road(t):
        return np.interp(t, rows[:, 0], rows[:, 3])

    found = solve_ivp(
        car_rates(CAR | {"body_mass": 250}, road), (0, 10), np.zeros(4), "DOP853", result.time,
        rtol=1e-8, atol=1e-10, max_step=0.01,
    ).y.T  # fmt: skip
    assert np.ptp(found[:, 1]) > 0.05
    np.testing.assert_allclose(result["z"][:, 1:], found[:, :2], atol=2e-5)


@pytest.mark.parametrize("damping", [0, 1500, 20000])
def test_the_modes_of_the_car(damping):
    mass = np.diag([1 / CAR["wheel_mass"], 1 / CAR["body_mass"]])
    k, c, kt = CAR["suspension"], damping, CAR["tyre"]
    stiffness = mass @ [[kt + k, -k], [-k, k]]
    friction = mass @ [[c, -c], [-c, c]]
    companion = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, -friction]])
    model = example("quarter_car", "on_track")
    model.parameters["damping"] = damping
    found = np.sort_complex(model.eigenvalues())
    model.parameters["damping"] = 1500
    exact = np.sort_complex(np.concatenate([np.linalg.eigvals(companion), np.zeros(3)]))
    assert len(found) == 7
    for value in exact:
        assert np.abs(found - value).min() < 1e-6 * np.abs(exact).max()


# --- hydraulic cylinder -----------------------------------------------------------------------


@pytest.mark.parametrize("changed", [{}, {"mass": 50, "volume[1]": 5e-3, "speed0": -0.2}])
def test_oil_is_a_spring(changed):
    p = {"mass": 500, "area": 2e-3, "volume[1]": 1e-3, "volume[2]": 2e-3, "speed0": 0.1} | changed
    stiffness = [p["area"] ** 2 * 1.6e9 / p[f"volume[{k}]"] for k in (1, 2)]
    omega = math.sqrt(sum(stiffness) / p["mass"])
    result = example("hydraulic_cylinder", "closed").simulate(parameters=changed, rtol=1e-9)
    travel = p["speed0"] / omega * np.sin(omega * result.time)
    np.testing.assert_allclose(
        result["speed"], p["speed0"] * np.cos(omega * result.time), atol=1e-7
    )
    np.testing.assert_allclose(result["left_pressure"], -stiffness[0] / p["area"] * travel, atol=1)
    np.testing.assert_allclose(result["right_pressure"], stiffness[1] / p["area"] * travel, atol=1)


def orifice(drop, small=1e4):
    return drop / (drop**2 + small**2) ** 0.25


@pytest.mark.parametrize("changed", [{}, {"mass": 300, "hose": 1e-4, "friction": 4000}])
def test_the_lift_by_its_pressures(changed):
    p = {"mass": 500, "hose": 1e-5, "friction": 1e4} | changed
    area, bulk, weight = 1e-3, 1.6e9, p["mass"] * GRAVITY

    def rates(t, y):
        hose, chamber, speed, _ = y
        opening = np.clip((t - 0.1) / 0.1, 0, 1) - np.clip((t - 0.6) / 0.1, 0, 1)
        supplied = opening * 20e-3 / 60 / 1e3 * orifice(1e7 - hose)
        passed = 60e-3 / 60 / 1e3 * orifice(hose - chamber)
        force = area * chamber - weight - p["friction"] * speed
        return [
            (supplied - passed) * bulk / p["hose"],
            (passed - area * speed) * bulk / 1e-3,
            force / p["mass"],
            speed,
        ]

    result = example("hydraulic_cylinder", "lift").simulate(parameters=changed, rtol=1e-8)
    at_rest = [weight / area, weight / area, 0, 0]
    exact = solve_ivp(
        rates, (0, 1), at_rest, "Radau", result.time, rtol=1e-8, atol=1e-8, max_step=0.01
    ).y.T
    assert exact[-1, 3] > 0.1
    np.testing.assert_allclose(result["pressure"], exact[:, 1], atol=300)
    np.testing.assert_allclose(result["height"], exact[:, 3], atol=1e-6)


@pytest.mark.parametrize("changed", [{}, {"gain": 8, "mass": 1500, "drive.leak": 1e-11}])
def test_the_servo_by_its_pressures(changed):
    p = {"gain": 20, "mass": 500, "drive.leak": 1e-13} | changed
    big, small, bulk, volume = 20e-4, 15e-4, 1.6e9, 1e-3

    def rates(t, y):
        spool, front, back, speed, position = y
        command = np.clip(p["gain"] * ((0 if t < 0.1 else 0.2) - position), -1, 1)
        opening, closing = (20e-3 / 60 / 1e3 * max(s, 0) for s in (spool, -spool))
        leak = p["drive.leak"] * (front - back)
        into_front = opening * orifice(1e7 - front) - closing * orifice(front) - leak
        into_back = closing * orifice(1e7 - back) - opening * orifice(back) + leak
        force = big * front - small * back - 5e3 - 4e3 * speed
        return [
            (command - spool) / 0.01,
            (into_front - big * speed) * bulk / volume,
            (into_back + small * speed) * bulk / volume,
            force / p["mass"],
            speed,
        ]

    result = example("hydraulic_cylinder", "servo").simulate(parameters=changed, rtol=1e-9)
    start = [0, 50e5, (50e5 * big - 5e3) / small, 0, 0]
    exact = solve_ivp(
        rates, (0, 2), start, "Radau", result.time, rtol=1e-8, atol=1e-8, max_step=0.01
    ).y.T
    assert exact[-1, 4] > 0.15
    np.testing.assert_allclose(result["position"], exact[:, 4], atol=1e-5)
    np.testing.assert_allclose(result["front"], exact[:, 1], atol=2e4)


# --- hanging load -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("use", "tolerance"), [({}, 5e-3), ({"load.swivel.lock": "Rigid[3]"}, 2e-6)]
)
@pytest.mark.parametrize(("lean", "length"), [(0.5236, 6.0), (-2.0, 2.5)])
def test_the_pendulum(use, tolerance, lean, length):
    model = bgc.compile(EXAMPLES / "hanging_load.bg", scene="pendulum", uses=use)
    given = {"lean": lean, "load.length": length}
    result = model.simulate(parameters=given, rtol=1e-9)
    inertia = length**2 + 0.4 * 0.5**2

    def rates(_, y):
        return [y[1], -GRAVITY * length * math.sin(y[0]) / inertia]

    angle = reference(rates, [lean, 0], result.time)[:, 0]
    exact = np.stack([0 * angle, length * np.sin(angle), 10 - length * np.cos(angle)], axis=1)
    np.testing.assert_allclose(result["load"], exact, atol=tolerance * length)


@pytest.mark.parametrize("rate", [0.6, 0.9])
def test_the_load_of_the_carousel_swings_out(rate):
    result = example("hanging_load", "carousel").simulate(parameters={"rate": rate})
    angle = brentq(
        lambda a: math.tan(a) - rate**2 * (8 + 6 * math.sin(a)) / GRAVITY, 0, 1.5, xtol=1e-14
    )
    assert result["angle"][-1] == pytest.approx(angle, abs=2e-4)


def turn(axis, angle):
    """Rotation about a unit axis."""
    x, y, z = axis
    s = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * s + (1 - np.cos(angle)) * (s @ s)


class CraneByHand:
    """The two-beam crane with exact joints, the load and the operator's coupling, by d'Alembert.

    Coordinates are slew, luff, fold and two angles of the rope. `places` lists centres and axes
    of the bodies, each times the root of its mass or second moment, so that the kinetic energy is
    half of the square of their rates. The drives carry the beams' weights.
    """

    BEAMS = ((6e3, 3.0, 1.0), (8e3, 12.0, 0.8), (4e3, 9.0, 0.6))

    def __init__(self, mass: float, length: float) -> None:
        self.mass, self.length = mass, length

    def tip_and_load(self, q):
        first = turn((0, 0, 1), q[0])
        second = first @ turn((0, -1, 0), q[1])
        third = second @ turn((0, -1, 0), q[2])
        foot = np.array([-20, 0, 3])
        shoulder = foot + np.array([0, 0, 3])
        elbow = shoulder + 12 * second[:, 0]
        tip = elbow + 9 * third[:, 0]
        rope = np.array([np.sin(q[4]), -np.sin(q[3]) * np.cos(q[4]), -np.cos(q[3]) * np.cos(q[4])])
        frames = ((first, 2, foot), (second, 0, shoulder), (third, 0, elbow))
        return frames, tip, rope, tip + self.length * rope

    def places(self, q):
        frames, _, rope, load = self.tip_and_load(q)
        found = [math.sqrt(self.mass) * load, math.sqrt(0.4 * self.mass * 0.25) * rope]
        for (mass, length, side), (turned, axis, base) in zip(self.BEAMS, frames, strict=True):
            found.append(math.sqrt(mass) * (base + length / 2 * turned[:, axis]))
            for k in range(3):
                extent = length if k == axis else side
                found.append(math.sqrt(mass / 12) * extent * turned[:, k])
        return np.concatenate(found)

    def slopes(self, function, q):
        return np.array([function(q + 1e-30j * e).imag / 1e-30 for e in np.eye(5)]).T

    def rates(self, hand):
        def of(t, y):
            q, v, stretch, reached = y[:5], y[5:10], y[10:13], y[13:]
            slopes = self.slopes(self.places, q)
            step = 1e-6
            ahead, behind = (self.slopes(self.places, q + s * step * v) for s in (1, -1))
            turning = (ahead - behind) @ v / (2 * step)
            tip = self.slopes(lambda q: self.tip_and_load(q)[1], q)
            load = self.slopes(lambda q: self.tip_and_load(q)[3], q)
            slip = tip @ v - reached
            force = -tip.T @ (4e5 * stretch + 8e4 * slip) - self.mass * GRAVITY * load[2]
            acceleration = np.linalg.solve(slopes.T @ slopes, force - slopes.T @ turning)
            x = hand(t)
            beyond = np.sign(x) * np.maximum(np.abs(x) - 5e-3, 0)
            wanted = np.clip(12 * beyond, -0.6, 0.6)
            return np.concatenate([v, acceleration, slip, (wanted - reached) / 0.05])

        return of


@pytest.mark.parametrize(
    ("scene", "mass", "length", "tolerance"),
    [("rigid", 2000.0, 6.0, 3e-4), ("rigid", 3000.0, 4.0, 3e-4), ("crane", 2000.0, 9.0, 2e-2)],
)
def test_the_load_on_the_papers_crane(scene, mass, length, tolerance):
    rows = np.loadtxt(EXAMPLES / "slew.csv", delimiter=",", skiprows=1)

    def hand(t):  # sampled each millisecond, and held
        at = max(t - 5e-4, 0)
        return np.array([np.interp(at, rows[:, 0], rows[:, k]) for k in (1, 2, 3)])

    stretch = -mass * GRAVITY / 4e5
    given = {"payload.mass": mass, "payload.length": length, "handle.stretch0[3]": stretch}
    result = example("hanging_load", scene).simulate(16, parameters=given, every=0.1)
    by_hand = CraneByHand(mass, length)
    start = np.zeros(16)
    start[:3], start[12] = np.radians([90, 45, -60]), stretch
    exact = solve_ivp(
        by_hand.rates(hand), (0, 16), start, "LSODA", result.time,
        rtol=1e-7, atol=1e-9, max_step=0.1,
    ).y.T  # fmt: skip
    assert len(exact) == len(result.time)
    found = [by_hand.tip_and_load(row[:5]) for row in exact]
    load = np.array([x[3] for x in found])
    assert np.ptp(load[:, 0]) > 4 and np.ptp(load[:, 2]) > 0.5
    np.testing.assert_allclose(result["tip"], [x[1] for x in found], atol=tolerance)
    np.testing.assert_allclose(result["load"], load, atol=tolerance)
