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


ENTRY = 3 * WHOLE / (RHO * np.pi * RADIUS**2 * 3)


def water(z):
    """Submerged volume, added mass in heave and sideways, and their derivatives by the depth."""
    depth = RADIUS - z
    wet = np.clip(depth, 0, 2 * RADIUS)
    ball = 4 / 3 * np.pi * RADIUS**3
    volume, section = np.pi * wet**2 * (RADIUS - wet / 3), np.pi * wet * (2 * RADIUS - wet)
    u = np.clip(depth / ENTRY, 0, 1)
    heave, slope = WHOLE * u * u * (3 - 2 * u), WHOLE * 6 * u * (1 - u) / ENTRY
    side, growth = WHOLE * (volume / ball) ** 2, 2 * WHOLE * volume * section / ball**2
    return volume, heave, slope, side, growth


def momentum_rates(t, y):
    """Rates of place, height, speeds, spray and wake, by momentum balances in the inertial frame.

    Sinking, each direction entrains water at rest: the force is d(A v)/dt. Rising, sideways
    momentum stays with the water that is left, and the vertical kinetic energy comes back.
    """
    _, z, u, v, _, _ = y
    volume, heave, slope, side, growth = water(z)
    # New water by time; on exit it is left at the speed of the load, without a force.
    push = -growth * max(-v, 0) * u
    lift = (RHO * volume - MASS) * G + slope * v * v * (1 if v < 0 else 0.5)
    # Energy that enters the water less its kinetic energy.
    spray, wake = slope / 2 * max(-v, 0) * v * v, growth / 2 * abs(v) * u * u
    return [u, v, push / (MASS + side), lift / (MASS + heave), spray, wake]


@pytest.mark.parametrize(("scene", "start"), [("ball", [1, 2, 0]), ("out", [-2, 2, 9])])
def test_a_spinning_sphere_crosses_the_surface(load, ball, scene, start):
    """Follow momentum balances in the inertial frame; the spin turns nothing."""
    result = ball if scene == "ball" else load("splash", scene).simulate()
    z, u, v = start
    answer = solve_ivp(
        momentum_rates,
        (0, result.time[-1]),
        [0, z, u, v, 0, 0],
        t_eval=result.time,
        rtol=1e-9,
        atol=1e-10,
        max_step=5e-3,
    )
    np.testing.assert_allclose(result["r[1]"], answer.y[0], atol=1e-5)
    np.testing.assert_allclose(result["r[2]"], 0, atol=1e-5)
    np.testing.assert_allclose(result["r[3]"], answer.y[1], atol=1e-5)
    lost = [np.trapezoid(result[name], result.time) for name in ("spray", "entrained")]
    np.testing.assert_allclose(lost, answer.y[4:, -1], rtol=2e-4, atol=1e-3)
    assert closed(result)


def test_entry_keeps_the_sideways_momentum(load, ball):
    """Keep (m + A) u while a sphere sinks, and u while one leaves; both lose energy."""
    speed = np.hypot(ball["twist[1]"], ball["twist[2]"])
    side = water(ball["r[3]"])[3]
    sinking = np.argmax(ball["r[3]"] < -RADIUS)
    np.testing.assert_allclose(((MASS + side) * speed)[:sinking], MASS * 2, rtol=1e-6)
    assert speed[sinking] == pytest.approx(MASS * 2 / (MASS + WHOLE), rel=1e-3)
    # Of the kinetic energy that is lost sideways, all is in the account.
    kept = (MASS + side[sinking]) * speed[sinking] ** 2 / 2
    taken = np.trapezoid(ball["entrained"][: sinking + 1], ball.time[: sinking + 1])
    assert MASS * 2**2 / 2 - kept == pytest.approx(taken, rel=1e-4)

    out = load("splash", "out").simulate()
    assert out["depth"].min() < 0 < 2 * RADIUS < out["depth"].max()
    np.testing.assert_allclose(out["twist[1]"], 2, rtol=2e-6)
    assert out["spray"].max() == 0 and out["entrained"].min() >= 0


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


def plate_by_doublets(ratio, n, m):
    """Coefficient of added mass of a plate of 1 by `ratio`, by m x n panels of constant doublets.

    The normal velocity of a panel at a point is a sum over its corners; panels are finer at the
    edges, where the potential has the slope of a square root.
    """
    x, y = (
        length / 2 * (1 - np.cos(np.pi * np.arange(k + 1) / k))
        for length, k in ((ratio, m), (1, n))
    )
    dx = ((x[:-1] + x[1:]) / 2)[:, None, None, None] - x[:, None]
    dy = ((y[:-1] + y[1:]) / 2)[:, None, None] - y
    corners = np.hypot(dx, dy) / (dx * dy)
    influence = np.diff(np.diff(corners, axis=2), axis=3).reshape(m * n, m * n) / (4 * np.pi)
    strength = np.linalg.solve(influence, np.ones(m * n))
    return abs(strength @ np.outer(np.diff(x), np.diff(y)).ravel()) / (np.pi / 4 * ratio)


def test_the_added_mass_of_plates_is_that_of_a_doublet_lattice(load):
    """The error of a lattice halves with its panels, so two of them are extrapolated."""
    found = load("splash", "plates").simulate()["coefficients"][-1]
    ratios = [1, 1.25, 1.5, 1.59, 2, 2.5, 3, 3.17, 4, 5, 6.25, 8, 10, 20, 40]
    assert found[0] == 0.579
    for ratio, value in zip(ratios, found, strict=True):
        m = round(6 * min(ratio, 3)) if ratio < 10 else 24
        coarse, fine = (plate_by_doublets(ratio, 6 * k, m * k) for k in (1, 2))
        assert value == pytest.approx(2 * fine - coarse, rel=5.1e-3)
