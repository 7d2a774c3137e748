"""A U-tube roll tank: its period, and the roll of a ship with it, by Lagrange's equations."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from ships_at_speed import free_horizontally

import bgc

G, RHO = 9.81, 1000.0
HULL, STIFFNESS, LOST, MOMENT, RATE = 1.6e8, 6e7, 4e6, 1.5e6, 0.55


class Tank(NamedTuple):
    """Lengths in m; the duct's centre stands `below` from the axis of roll."""

    width: float = 12.0
    reservoir: float = 3.0
    duct: float = 1.0
    length: float = 4.0
    depth: float = 3.0
    below: float = -2.0

    @property
    def area(self):
        return self.reservoir * self.length


TANK = Tank()


def middles(low, high, n=2000):
    return low + (np.arange(n) + 0.5) * (high - low) / n


def rectangle(y, z):
    """Return its moment of inertia about x by the midpoint rule, for each unit of area."""
    return (middles(*y) ** 2).mean() + (middles(*z) ** 2).mean()


def mass_matrix(t=TANK, hull=HULL):
    """Integrate the kinetic energy of the stream tube over its sections, for roll and flow."""
    column = rectangle(
        ((t.width - t.reservoir) / 2, (t.width + t.reservoir) / 2), (t.below, t.below + t.depth)
    )
    channel = rectangle((-t.width / 2, t.width / 2), (t.below - t.duct / 2, t.below + t.duct / 2))
    still = RHO * (2 * t.area * t.depth * column + t.duct * t.length * t.width * channel)
    # Along the tube, down at starboard, across, and up at port: y dz - z dy.
    carried = RHO * t.width * (t.depth - t.below)
    flow = RHO * (t.width / (t.duct * t.length) + 2 * t.depth / t.area)
    return np.array([[hull + still, carried], [carried, flow]])


def potential(roll, passed, t=TANK, stiffness=STIFFNESS):
    """Weigh both columns at their levels and the duct; add the ship's restoring energy."""
    total = RHO * G * t.duct * t.length * t.width * t.below * np.cos(roll)
    total += stiffness * roll**2 / 2
    for side in (1, -1):
        height = t.depth + side * passed / t.area
        arm = side * t.width / 2 * np.sin(roll) + (t.below + height / 2) * np.cos(roll)
        total += RHO * G * t.area * height * arm
    return total


def slopes(roll, passed, *about, step=1e-20):
    """Differentiate the potential by complex steps."""
    by_roll = potential(roll + 1j * step, passed, *about).imag
    by_passed = potential(roll, passed + 1j * step, *about).imag
    return np.array([by_roll, by_passed]) / step


def curvature(*about, step=1e-4):
    ends = [slopes(*(side * step * unit), *about) for unit in np.eye(2) for side in (1, -1)]
    return np.array([ends[0] - ends[1], ends[2] - ends[3]]) / (2 * step)


@pytest.fixture(scope="module")
def ship(load):
    return load("roll_tank", "roll_tank")


@pytest.mark.parametrize("loss", [1.5, 40.0])
def test_a_ship_rolls_with_its_tank_by_lagranges_equations(ship, loss):
    result = ship.simulate(parameters={"tank.loss": loss})
    masses = mass_matrix()
    inverse = np.linalg.inv(masses)
    linear = 2 * 0.06 * np.sqrt(masses[1, 1] * 2 * RHO * G / TANK.area)

    def rates(t, y):
        roll, passed, turning, flow = y
        wall = linear * flow + loss * RHO / 2 * abs(flow) * flow / (TANK.duct * TANK.length) ** 2
        force = [MOMENT * np.sin(RATE * t) - LOST * turning, -wall] - slopes(roll, passed)
        return [turning, flow, *(inverse @ force)]

    passed0 = TANK.area * TANK.width / 2 * np.tan(np.radians(-3))
    answer = solve_ivp(
        rates, (0, 60), [0.1, passed0, 0, 0], t_eval=result.time, rtol=1e-9, atol=1e-10
    )
    np.testing.assert_allclose(result["roll"], answer.y[0], atol=1e-6)
    np.testing.assert_allclose(result["level"], answer.y[1] / TANK.area, atol=1e-5)
    assert np.abs(result["level"]).max() > 0.4
    assert np.abs(result["energy.residual"]).max() < 1e-8 * result.counts["exchanged"]


def test_the_natural_periods_are_those_of_the_energies(ship):
    """The tank alone has Lloyd's period; with the ship, both of the pair of masses."""
    still = {"moment": 0.0, "roll0": 0.0, "tank.angle0": 0.0, "tank.damping": 0.0}
    lloyd = np.sqrt(2 * G * TANK.duct / (TANK.reservoir * TANK.width + 2 * TANK.depth * TANK.duct))
    assert ship.simulate(parameters=still)["period"][0] == pytest.approx(2 * np.pi / lloyd)
    hessian = curvature()
    expected = np.sqrt(eigh(hessian, mass_matrix(), eigvals_only=True))
    values = ship.eigenvalues(parameters=still)
    found = np.sort(values.imag[values.imag > 1e-3])
    np.testing.assert_allclose(found, expected, rtol=1e-3)  # the hull's own damping
    assert lloyd**2 == pytest.approx(hessian[1, 1] / mass_matrix()[1, 1], rel=1e-6)


def test_the_tank_reduces_the_roll(ship):
    """With the water all but shut off, the tank only adds its mass."""
    late = ship.simulate().time > 30
    free, shut = (
        np.abs(ship.simulate(parameters={"tank.loss": loss})["roll"][late]).max()
        for loss in (1.5, 1e6)
    )
    assert free < 0.75 * shut


def amplitude_at(result, name, rate):
    """Amplitude over the last five periods, by a least-squares sine."""
    late = result.time > result.time[-1] - 10 * np.pi / rate
    t = result.time[late]
    waves = np.stack([np.cos(rate * t), np.sin(rate * t), np.ones_like(t)], axis=1)
    return np.hypot(*np.linalg.lstsq(waves, result[name][late])[0][:2])


def test_a_tank_takes_the_roll_of_a_ship_at_its_resonance():
    """Solve the amplitudes of roll and level from the ship's data, and compare the example."""
    library = Path(str(resources.files("bgc.library")))
    data = json.loads((library / "marine" / "supply.json").read_text("utf-8"))
    met, rate = 0.603, 2 * np.pi / 10.42
    radiation, response = data["radiation"], data["response"]
    added, lost = (
        np.reshape(
            [np.interp(met, radiation["frequency"], row) for row in np.transpose(radiation[name])],
            (6, 6),
        )
        for name in ("mass", "damping")
    )
    follow = free_horizontally(data["M_RB"] + added)[:, 1]
    hull = follow @ (data["M_RB"] + added) @ follow
    lost = follow @ (data["D"] + lost) @ follow
    # The hull sways and yaws as it rolls: where the tank stands, about an axis at this height.
    axis = -(follow[1] + data["deck"][0] * follow[5])
    at = Tank(14, 4, 1.19, 5, 3.5, data["deck"][2] - 1)
    turning, stiffness = at._replace(below=at.below - axis), data["G"][1][1]
    # Waves of 0.5 m towards port: -90 deg from ahead, by starboard.
    column = np.argmin(np.abs(np.array(response["heading"]) - 1.5 * np.pi))
    force = np.array(
        [
            sum(
                factor * np.interp(rate, response["frequency"], np.array(table[part])[:, column])
                for part, factor in (("re", 1), ("im", 1j))
            )
            for table in (
                response["force"][k] for k in ("surge", "sway", "heave", "roll", "pitch", "yaw")
            )
        ]
    )
    force[5] += response["point [m]"][0] * force[1]
    moment = 0.5 * follow @ force
    bare = abs(moment / (stiffness - rate**2 * hull + 1j * rate * lost))
    masses = mass_matrix(turning, hull)
    wall = 2 * 0.1 * np.sqrt(masses[1, 1] * 2 * RHO * G / at.area)
    both = curvature(at, stiffness) - rate**2 * masses + 1j * rate * np.diag([lost, wall])
    roll, passed = np.abs(np.linalg.solve(both, [moment, 0]))

    scenes = {
        name: bgc.compile(library / "examples" / "roll_tank.bg", scene=name).simulate()
        for name in ("rolling", "roll_tank")
    }
    found = {
        name: np.radians(amplitude_at(result, "roll [deg]", rate))
        for name, result in scenes.items()
    }
    assert found["rolling"] == pytest.approx(bare, rel=2e-3)
    assert found["roll_tank"] == pytest.approx(roll, rel=1e-2)
    level = amplitude_at(scenes["roll_tank"], "level", rate)
    assert level == pytest.approx(passed / at.area, rel=1e-2)
    assert found["roll_tank"] < 0.25 * found["rolling"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"tank.reservoir": 12.5}, "the reservoirs overlap"),
        ({"moment": 6e6}, "a reservoir has run empty"),
    ],
)
def test_a_tank_beyond_its_range_is_refused(ship, given, said):
    with pytest.raises(bgc.BgError, match=said):
        ship.simulate(parameters=given)


def test_a_turning_ship_keeps_its_momentum_sideways(load):
    """In free fall only the weight changes the momentum of ship and water."""
    result = load("roll_tank", "falling").simulate()
    total = 4e5 + RHO * (2 * TANK.area * TANK.depth + TANK.duct * TANK.length * TANK.width)
    scale = total * 2
    for axis, pull in (("1", 0), ("2", 0), ("3", -total * G)):
        momentum = result[f"momentum[{axis}]"]
        expected = momentum[0] + pull * result.time
        np.testing.assert_allclose(momentum, expected, atol=1e-7 * scale)
    assert np.abs(result["energy.residual"]).max() < 1e-7 * result.counts["exchanged"]
