"""A sphere that enters the water, a box that turns in deep water: formulas and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

G, RHO, RADIUS, MASS = 9.81, 1025.0, 0.6, 900.0
WHOLE = RHO * 2 / 3 * np.pi * RADIUS**3  # half of the displaced water


@pytest.fixture(scope="module")
def ball(load):
    """Fall with a spin about the vertical of 3 rad/s and a sideways speed of 2 m/s."""
    return load("splash", "ball").simulate()


def closed(result, share=2e-8):
    return np.abs(result["energy.residual"]).max() < share * result.counts["exchanged"]


def test_a_sphere_displaces_its_cap(ball):
    """Integrate the discs up to the depth; the closed formula of a cap is the part's own."""
    depth, volume = ball["depth"], ball["volume"]
    levels = np.linspace(0, 2 * RADIUS, 20001)
    discs = np.pi * (RADIUS**2 - (levels - RADIUS) ** 2)
    caps = np.concatenate([[0], np.cumsum((discs[1:] + discs[:-1]) / 2 * np.diff(levels))])
    expected = np.interp(depth, levels, caps)
    np.testing.assert_allclose(volume, expected, atol=1e-7)
    np.testing.assert_allclose(ball["share"], expected / caps[-1], atol=1e-7)
    assert depth.min() < 0 and depth.max() > 2 * RADIUS
    assert (volume[depth <= 0] == 0).all()


def test_the_added_mass_of_a_sphere_grows_to_half_of_its_water(ball):
    depth, added, slope = ball["depth"], ball["added"], ball["slope"]
    assert (added[depth <= 0] == 0).all()
    np.testing.assert_allclose(added[depth > 2 * RADIUS], WHOLE, rtol=1e-12)
    # The largest coefficient of slamming, 2 dA/dh/(density area), is 3.
    assert slope.max() == pytest.approx(3 / 2 * RHO * np.pi * RADIUS**2, rel=1e-3)
    sinking = slice(0, np.argmax(depth > 2 * RADIUS))
    areas = (slope[sinking][1:] + slope[sinking][:-1]) / 2 * np.diff(depth[sinking])
    assert areas.sum() == pytest.approx(WHOLE, rel=1e-3)


def test_a_spinning_sphere_crosses_the_surface(ball):
    """Sideways the kinetic energy of body and water stays, and no force turns the motion.

    Upwards there is one equation, with the half of the slam that goes to the spray.
    """
    entry = 3 * WHOLE / (RHO * np.pi * RADIUS**2 * 3)

    def rates(t, y):
        _, z, v = y
        depth = RADIUS - z
        wet = min(max(depth, 0), 2 * RADIUS)
        volume = np.pi * wet**2 * (RADIUS - wet / 3)
        u = min(max(depth / entry, 0), 1)
        added, slope = WHOLE * u * u * (3 - 2 * u), WHOLE * 6 * u * (1 - u) / entry
        force = (RHO * volume - MASS) * G + slope * v * v / 2
        force -= slope / 2 * abs(v) * min(v, 0)
        share = volume / (4 / 3 * np.pi * RADIUS**3)
        return [2 * np.sqrt(MASS / (MASS + WHOLE * share**2)), v, force / (MASS + added)]

    answer = solve_ivp(
        rates, (0, 2), [0, 1, 0], t_eval=ball.time, rtol=1e-9, atol=1e-10, max_step=5e-3
    )
    np.testing.assert_allclose(ball["r[1]"], answer.y[0], atol=1e-5)
    np.testing.assert_allclose(ball["r[2]"], 0, atol=1e-5)
    np.testing.assert_allclose(ball["r[3]"], answer.y[1], atol=1e-5)
    assert closed(ball)


def test_a_box_turns_in_deep_water_by_kirchhoffs_equations(load):
    """dp/dt = p x w, dL/dt = L x w + p x v: the gyristor with Munk's moment, weight afloat."""
    result = load("splash", "box").simulate()

    def added(a, b, h):
        table = np.interp(max(a, b) / min(a, b), [4 / 3, 1.5, 2], [plate_4_3, 0.69, 0.757])
        plate = RHO * table * np.pi / 4 * min(a, b) ** 2 * max(a, b)
        x = np.sqrt(a * b) / (h + np.sqrt(a * b))
        return plate * (1 + np.sqrt((1 - x * x) / (2 * (1 + x * x))))

    plate_4_3 = 0.642 + (4 / 3 - 1.25) / 0.25 * (0.69 - 0.642)
    masses = 3075 + np.array([added(1.5, 1, 2), added(2, 1, 1.5), added(2, 1.5, 1)])
    moments = np.array([800.0, 1500.0, 1100.0])

    def rates(t, y):
        p, turn = y[:3], y[3:]
        v, w = p / masses, turn / moments
        return [*np.cross(p, w), *(np.cross(turn, w) + np.cross(p, v))]

    twist0 = np.array([1, 0.5, 0.3, 0.6, 0.4, -1])
    inertia = np.concatenate([masses, moments])
    answer = solve_ivp(rates, (0, 5), inertia * twist0, t_eval=result.time, rtol=1e-10, atol=1e-8)
    twist = np.stack([result[f"twist[{i}]"] for i in range(1, 7)])
    np.testing.assert_allclose(twist, answer.y / inertia[:, None], atol=2e-6)
    assert np.ptp(answer.y[3] / moments[0]) > 0.5  # Munk's moment counts
    assert closed(result, 1e-7)
