"""A U-tube roll tank: its period, and the roll of a ship with it, by Lagrange's equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import bgc

G, RHO = 9.81, 1000.0
WIDTH, RESERVOIR, DUCT, LENGTH, DEPTH, BELOW = 12.0, 3.0, 1.0, 4.0, 3.0, -2.0
AREA = RESERVOIR * LENGTH
HULL, STIFFNESS, LOST, MOMENT, RATE = 1.6e8, 6e7, 4e6, 1.5e6, 0.55


def middles(low, high, n=2000):
    return low + (np.arange(n) + 0.5) * (high - low) / n


def rectangle(y, z):
    """Return its moment of inertia about x by the midpoint rule, for each unit of area."""
    return (middles(*y) ** 2).mean() + (middles(*z) ** 2).mean()


def mass_matrix():
    """Integrate the kinetic energy of the stream tube over its sections, for roll and flow."""
    column = rectangle(
        (WIDTH / 2 - RESERVOIR / 2, WIDTH / 2 + RESERVOIR / 2), (BELOW, BELOW + DEPTH)
    )
    channel = rectangle((-WIDTH / 2, WIDTH / 2), (BELOW - DUCT / 2, BELOW + DUCT / 2))
    still = RHO * (2 * AREA * DEPTH * column + DUCT * LENGTH * WIDTH * channel)
    # Along the tube, down at starboard, across, and up at port: y dz - z dy.
    carried = RHO * (WIDTH / 2 * DEPTH - BELOW * WIDTH + WIDTH / 2 * DEPTH)
    flow = RHO * (WIDTH / (DUCT * LENGTH) + 2 * DEPTH / AREA)
    return np.array([[HULL + still, carried], [carried, flow]])


def potential(roll, passed):
    """Weigh both columns at their levels and the duct; add the ship's restoring energy."""
    total = RHO * G * DUCT * LENGTH * WIDTH * BELOW * np.cos(roll) + STIFFNESS * roll**2 / 2
    for side in (1, -1):
        height = DEPTH + side * passed / AREA
        arm = side * WIDTH / 2 * np.sin(roll) + (BELOW + height / 2) * np.cos(roll)
        total += RHO * G * AREA * height * arm
    return total


def slopes(roll, passed, step=1e-20):
    """Differentiate the potential by complex steps."""
    by_roll = potential(roll + 1j * step, passed).imag
    by_passed = potential(roll, passed + 1j * step).imag
    return np.array([by_roll, by_passed]) / step


@pytest.fixture(scope="module")
def ship(load):
    return load("roll_tank", "roll_tank")


@pytest.mark.parametrize("loss", [1.5, 40.0])
def test_a_ship_rolls_with_its_tank_by_lagranges_equations(ship, loss):
    result = ship.simulate(parameters={"tank.loss": loss})
    masses = mass_matrix()
    inverse = np.linalg.inv(masses)
    linear = 2 * 0.06 * np.sqrt(masses[1, 1] * 2 * RHO * G / AREA)

    def rates(t, y):
        roll, passed, turning, flow = y
        wall = linear * flow + loss * RHO / 2 * abs(flow) * flow / (DUCT * LENGTH) ** 2
        force = [MOMENT * np.sin(RATE * t) - LOST * turning, -wall] - slopes(roll, passed)
        return [turning, flow, *(inverse @ force)]

    passed0 = AREA * WIDTH / 2 * np.tan(np.radians(-3))
    answer = solve_ivp(
        rates, (0, 60), [0.1, passed0, 0, 0], t_eval=result.time, rtol=1e-9, atol=1e-10
    )
    np.testing.assert_allclose(result["roll"], answer.y[0], atol=1e-6)
    np.testing.assert_allclose(result["level"], answer.y[1] / AREA, atol=1e-5)
    assert np.abs(result["level"]).max() > 0.4
    assert np.abs(result["energy.residual"]).max() < 1e-8 * result.counts["exchanged"]


def test_the_natural_periods_are_those_of_the_energies(ship):
    """The tank alone has Lloyd's period; with the ship, both of the pair of masses."""
    still = {"moment": 0.0, "roll0": 0.0, "tank.angle0": 0.0, "tank.damping": 0.0}
    lloyd = np.sqrt(2 * G * DUCT / (RESERVOIR * WIDTH + 2 * DEPTH * DUCT))
    assert ship.simulate(parameters=still)["period"][0] == pytest.approx(2 * np.pi / lloyd)
    step = 1e-4
    ends = [slopes(*(side * step * unit)) for unit in np.eye(2) for side in (1, -1)]
    hessian = np.array([ends[0] - ends[1], ends[2] - ends[3]]) / (2 * step)
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
    total = 4e5 + RHO * (2 * AREA * DEPTH + DUCT * LENGTH * WIDTH)
    scale = total * 2
    for axis, pull in (("1", 0), ("2", 0), ("3", -total * G)):
        momentum = result[f"momentum[{axis}]"]
        expected = momentum[0] + pull * result.time
        np.testing.assert_allclose(momentum, expected, atol=1e-7 * scale)
    assert np.abs(result["energy.residual"]).max() < 1e-7 * result.counts["exchanged"]
