"""Contact with a moving deck, hook, tugger line and splash zone, against SciPy and formulas."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

G = 9.81


def integrate(rates, start, time, **options):
    options = {"rtol": 1e-10, "atol": 1e-10, "max_step": 2e-3, "method": "LSODA"} | options
    answer = solve_ivp(rates, (time[0], time[-1]), start, t_eval=time, **options)
    assert answer.success
    return answer.y


def closed(result, share=2e-8):
    return np.abs(result["energy.residual"]).max() < share * result.counts["exchanged"]


def pushing(depth, rate, stiffness, loss):
    """Force of a contact: Hunt and Crossley's, which never pulls."""
    return stiffness * max(depth, 0) * max(1 + loss * rate, 0)


@pytest.mark.parametrize(("amplitude", "loss"), [(0.0, 0.0), (0.0, 0.1), (0.3, 0.5)])
def test_a_ball_bounces_on_a_deck(load, amplitude, loss):
    result = load("rigging", "bouncing").simulate(parameters={"amplitude": amplitude, "loss": loss})

    def rates(t, y):
        up, speed = amplitude * (1 - np.cos(3 * t)), 3 * amplitude * np.sin(3 * t)
        return [y[1], pushing(up - y[0], speed - y[1], 1e6, loss) / 500 - G]

    height, _ = integrate(rates, [0.2, 0.0], result.time, max_step=5e-4)
    np.testing.assert_allclose(result["r[3]"], height, atol=2e-6)
    apart = result["gap"] > 0
    assert apart.any() and not apart.all()
    assert (result["force"][apart] == 0).all() and result["force"].min() >= 0
    assert closed(result)


def test_no_energy_is_left_in_a_contact_at_lift_off(load):
    """Apart, the stored energy is that of motion alone."""
    result = load("rigging", "bouncing").simulate(parameters={"amplitude": 0.3})
    moving = 250 * result["twist[3]"] ** 2
    apart = result["gap"] > 0
    scale = result.counts["exchanged"]
    assert np.abs(result["energy.stored"] - moving)[apart].max() < 1e-12 * scale
    assert (result["energy.stored"] - moving)[~apart].max() > 1e-2 * scale


def test_a_sliding_ball_stops_by_coulombs_law(load):
    start = {"slide": 1.0, "gap0": -500 * G / 1e6, "loss": 0.0}
    result = load("rigging", "bouncing").simulate(parameters=start)
    way = result["r[1]"] - 0.3
    assert way[-1] == pytest.approx(1 / (2 * 0.3 * G), abs=2e-4)
    assert way[result.time <= 0.2] == pytest.approx(
        (result.time - 0.15 * G * result.time**2)[result.time <= 0.2], abs=1e-4
    )


def test_a_load_stays_on_a_slope_below_the_angle_of_friction(load):
    """0.3 m of height per m of slope hold it for an hour; it slides beyond."""
    scene = load("rigging", "on_a_slope")
    rest = scene.simulate(error=False)
    assert np.abs(rest["r"][:, :2]).max() < 2e-6
    assert np.abs(rest["slip"][1:]).max() < 1e-12
    steep = np.radians(20)
    sliding = scene.simulate(4, every=1, parameters={"tilt": steep}, error=False)
    # Bent bristles push off the plane, by 0.76*friction*stiffness*give.
    lifted = 0.76 * 0.3 * 1e7 * 1e-5 / 1000
    expected = G * np.sin(steep) - 0.3 * (G * np.cos(steep) - lifted)
    assert np.diff(sliding["slip[1]"])[1:] == pytest.approx(expected, rel=1e-3)
    assert lifted < 3e-3 * G
    assert (sliding["heat"] >= 0).all() and closed(sliding, 1e-6)


def test_a_load_stays_on_a_deck_that_rolls(load):
    """By +-5 deg, 360 times, at rows of a quarter of the period."""
    result = load("rigging", "on_a_rolling_deck").simulate(error=False)
    assert 1e-8 < np.abs(result["r"][:, :2]).max() < 1e-6
    assert np.abs(result["r"][-4:, :2] - result["r"][41:45, :2]).max() < 1e-8


def test_a_load_is_lifted_off_a_heaving_deck(load):
    """On four feet: slack, snap, lift-off and touches, as one equation has them."""
    result = load("rigging", "lift_off").simulate()
    sink, stiffness, ea = 20e3 * G / 8e6, 2e6, 4e7

    def rates(t, y):
        height, speed, paid = y
        grown, growing = 1 - np.exp(-(t**2) / 9), 2 * t / 9 * np.exp(-(t**2) / 9)
        up = 0.6 * grown * np.sin(0.9 * t)
        rising = 0.6 * (growing * np.sin(0.9 * t) + 0.9 * grown * np.cos(0.9 * t))
        winding = -0.8 * min(t, 1)
        force = 4 * pushing(up - (height - 1), rising - speed, stiffness, 0.3)
        distance = 12 - (height + 1)
        stretch = distance - paid
        pull = 0.0
        if stretch > 0:
            spring = ea * stretch / paid
            pull = spring + max(ea * 0.01 / paid * (-speed - winding), -spring)
        return [speed, (force + pull) / 20e3 - G, winding]

    start = [1 - sink, 0.0, 10 + sink + 0.3]
    height, speed, _ = integrate(rates, start, result.time, max_step=1e-3)
    np.testing.assert_allclose(result["height"], height, atol=1e-5)
    np.testing.assert_allclose(result["twist[3]"], speed, atol=1e-4)
    assert result["force"][0] == pytest.approx(20e3 * G, rel=1e-6)
    assert result["force"][-1] == 0 and result["tension"][0] == 0
    assert result["height"][-1] > 3
    assert closed(result)


def entered(u):
    u = min(max(u, 0.0), 1.0)
    return u * u * (3 - 2 * u), 6 * u * (1 - u)


@pytest.mark.parametrize(
    "given",
    [
        {},  # from the air
        {"height0": -1.5, "speed0": 5.0},  # out of the water and back
        {"amplitude": 1.0},
    ],
    ids=["falls", "exits", "wave"],
)
def test_a_box_crosses_the_surface(load, given):
    """One equation: d/dt(A v), spray and wake of entry and exit, buoyancy and drag."""
    result = load("rigging", "falling").simulate(parameters=given)
    rho, area, w, a = 1025.0, 3.0, 0.8, given.get("amplitude", 0.0)
    x = np.sqrt(area) / (1 + np.sqrt(area))
    plate = rho * np.interp(2 / 1.5, [1.25, 1.5], [0.642, 0.69]) * np.pi / 4 * 1.5**2 * 2
    whole = plate * (1 + np.sqrt((1 - x**2) / (2 * (1 + x**2))))
    entry = 3 * whole / (rho * area * 5)

    side = rho * np.interp(1.5, [1.5], [0.69]) * np.pi / 4 * 1.5
    ratio = np.sqrt(1.5) / (2 + np.sqrt(1.5))
    side *= 1 + np.sqrt((1 - ratio**2) / (2 * (1 + ratio**2)))
    k = w * w / G

    def rates(t, y):
        x, z, u, v = y
        angle, deep = w * t + 0.3 - k * x, w * a * np.exp(k * min(z, 0))
        c, s, turning = np.cos(angle), np.sin(angle), w - k * u
        sinking = k * v if z < 0 else 0.0
        # Velocity of the water there, its acceleration, and its rate where the box is.
        water, rising = deep * np.array([c, -s]), w * deep * np.array([-s, -c])
        there = sinking * water + turning * deep * np.array([-s, -c])
        depth, depth_rate = a * c - z + 0.5, -a * s * turning - v
        wet = min(max(depth, 0), 1)
        wetting = depth_rate if 0 < depth < 1 else 0.0
        share, slope = entered(depth / entry)
        added = np.array([side * wet**2, whole * share])
        growing = np.array([2 * side * wet * wetting, whole * slope / entry * depth_rate])
        through = np.array([u, v]) - water
        force = rho * area * wet * (np.array([0, G]) + rising) - [0, 3e3 * G]
        force -= rho / 2 * wet * np.sqrt(through @ through + 1e-6) * np.array([2, 6]) * through
        force[1] -= whole * slope / entry / 2 * abs(through[1]) * min(through[1], 0)
        # The halves of dA/dt u that set new water in motion, and leave it behind.
        force[0] -= side * wet * (0 < depth < 1) * abs(through[1]) * through[0]
        # sqrt(A) d/dt(sqrt(A) v), v relative to the water.
        force += added * there - growing / 2 * through
        return [u, v, *(force / (3e3 + added))]

    start = [0.0, given.get("height0", 1.5), 0.0, given.get("speed0", 0.0)]
    x, height, _, speed = integrate(rates, start, result.time, method="DOP853")
    np.testing.assert_allclose(result["r[1]"], x, atol=1e-4)
    np.testing.assert_allclose(result["r[3]"], height, atol=1e-4)
    np.testing.assert_allclose(result["twist[3]"], speed, atol=1e-3)
    assert result["depth"].max() > 1.2 and result["depth"].min() < 0
    assert closed(result, 1e-7)


def test_a_load_hangs_at_rest_and_swings_as_its_bodies_say(load):
    """Hook and load: two axial motions less one, and the three pendulums of rope, hook, slings."""
    model = load("rigging", "hooked")
    still = model.simulate()
    assert np.ptp(still["height"]) < 1e-9
    assert still["tension"][0] == pytest.approx(1100 * G, rel=1e-9)
    hook, mass, ea = 200.0, 2000.0, 2 * 85e9 * 0.6 * np.pi / 4 * 0.02**2
    hang = 8 * (1 + 2200 * G / ea)
    # Sideways by the angles of rope, hook and slings.
    ways = np.array([[hang, 0.3, 0], [hang, 0.6, 2]])
    m = ways.T @ np.diag([hook, mass]) @ ways
    m += np.diag([0, 2 / 5 * hook * 0.3**2, mass / 6])
    k = G * np.diag([2200 * hang, hook * 0.3 + mass * 0.6, mass * 2])
    swings = np.sqrt(eigh(k, m, eigvals_only=True))
    axial = np.sqrt(ea / (8 * 2200))
    values = model.eigenvalues()
    found = np.unique(np.round(np.sort(values.imag[values.imag > 1e-2]), 6))
    expected = np.sort([*swings, axial])
    assert len(found) == len(expected)
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    lowered = model.simulate(parameters={"speed": 0.5})
    # Two falls: the hook moves at half of the rope's speed.
    assert still["height"][0] - lowered["height"][-1] == pytest.approx(1.25, abs=0.03)
    assert closed(lowered, 1e-7)


def test_a_tugger_line_holds_its_tension(load):
    result = load("rigging", "tugged").simulate()
    late = result.time > 50
    np.testing.assert_allclose(result["tension"][late], 2e3, rtol=0.02)
    assert np.abs(result["pay"]).max() <= 0.4 + 1e-9
    # In the end it pulls the load aside by about 2 kN over the weight, times 10.6 m.
    assert result["r[1]"][-1] == pytest.approx(10.6 * 2e3 / (2200 * G), rel=0.1)
    assert closed(result, 1e-6)


def test_feet_start_at_rest_under_the_load_that_they_carry(load):
    """Forces in proportion to the depth of a rigid plate: F = W/4 (1 + x x_i/a^2 + y y_i/b^2)."""
    result = load("rigging", "standing").simulate()
    for k, (x, y) in enumerate(((2, 1.5), (2, -1.5), (-2, 1.5), (-2, -1.5)), 1):
        force = 14e3 * G / 4 * (1 - 0.5 * x / 4 + 0.3 * y / 2.25)
        np.testing.assert_allclose(result[f"feet.foot[{k}].force"], force, rtol=1e-2)
    assert np.ptp(result["place"], axis=0).max() < 1e-9
