"""Wind, current, drag, moorings and station keeping against their formulas; a ship in all of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from bgc.driver import compile_scene
from bgc.options import Options


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    (a, b, c), (s, t, u) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = [[1, 0, 0], [0, a, -s], [0, s, a]]
    about_y = [[b, 0, t], [0, 1, 0], [-t, 0, b]]
    about_z = [[c, -u, 0], [u, c, 0], [0, 0, 1]]
    return np.array(about_z) @ about_y @ about_x


def mean_wind(speed: float, z: float) -> float:
    return speed * (1 + 0.0573 * math.sqrt(1 + 0.15 * speed) * math.log(z / 10))


def test_a_steady_wind_grows_with_height(load):
    wind = load("weather", "steady").simulate()["velocity"][-1]
    expected = mean_wind(15, 40) * np.array([math.cos(0.5), math.sin(0.5), 0])
    np.testing.assert_allclose(wind, expected, rtol=1e-12)


@pytest.mark.parametrize("seed", [1, 4])
def test_gusts_have_the_energy_of_their_spectrum(load, seed):
    """The spectrum of NORSOK N-003 at 20 m and 20 m/s, from 1/2400 to 1/2 Hz."""
    result = load("weather", "gusts").simulate(36000, every=2, parameters={"wind.seed": seed})

    def spectrum(f: float) -> float:
        scaled = 172 * f * 2 ** (2 / 3) * 2 ** (-3 / 4)
        return 320 * 2**2 * 2**0.45 / (1 + scaled**0.468) ** (5 / (3 * 0.468))

    variance = quad(
        lambda x: spectrum(math.exp(x)) * math.exp(x), math.log(1 / 2400), math.log(0.5)
    )
    deviation = math.sqrt(variance[0])
    assert result["deviation"][0] == pytest.approx(deviation, rel=2e-3)
    along = result["velocity"] @ [math.cos(0.5), math.sin(0.5), 0]
    across = result["velocity"] @ [-math.sin(0.5), math.cos(0.5), 0]
    assert np.abs(across).max() < 1e-9
    assert along.mean() == pytest.approx(mean_wind(20, 20), rel=1e-2)
    assert along.std() == pytest.approx(deviation, rel=2e-2)


TWIST = [1.5, -0.7, 0.4, 0.05, -0.02, 0.03]
ANGLES = [0.2, -0.1, 0.7]


@pytest.fixture(scope="module")
def towed(load):
    given = {f"twist[{k + 1}]": x for k, x in enumerate(TWIST)}
    given |= {f"angles[{k + 1}]": x for k, x in enumerate(ANGLES)}
    result = load("weather", "towed").simulate(parameters=given)
    return {name: result[name][-1] for name in ("wind", "hull", "damper")} | {
        "current": np.array([[result[f"current[{j},{k}]"][-1] for k in (1, 2)] for j in (1, 2, 3)])
    }


def drag(at: np.ndarray, area: np.ndarray, density: float, stream: np.ndarray) -> np.ndarray:
    """Wrench that a towed body takes, at the origin and in its axes."""
    v, w = np.array(TWIST[:3]), np.array(TWIST[3:])
    relative = v + np.cross(w, at) - rotation(*ANGLES).T @ stream
    force = density / 2 * area * np.linalg.norm(relative) * relative
    return np.concatenate([force, np.cross(at, force)])


def test_drag_of_a_point_in_the_wind(towed):
    expected = drag(np.array([2, -3, 4]), np.array([10, 30, 5]), 1.2, np.array([7, -4, 1]))
    np.testing.assert_allclose(towed["wind"], expected, rtol=1e-6)


def test_a_current_profile(towed):
    """Tide by the power 1/7, current of the wind linear to 50 m (DNV-RP-C205)."""
    z = np.array([1, 3, 5])
    tide, wind = 0.8 * (1 - z / 40) ** (1 / 7), 0.4 * (1 - z / 50)
    expected = [tide * np.cos(0.3) + wind * np.cos(2), tide * np.sin(0.3) + wind * np.sin(2)]
    np.testing.assert_allclose(towed["current"], np.transpose(expected), rtol=1e-12)


def test_a_measured_current(load):
    result = load("weather", "measured").simulate()
    found = [[result[f"current[{j},{k}]"][-1] for k in (1, 2)] for j in (1, 2, 3)]
    surface, deep = np.array([1, 0]), 0.6 * np.array([math.cos(math.pi / 3), math.sin(math.pi / 3)])
    expected = [surface + (deep - surface) * z / 10 for z in (1, 3, 5)]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_drag_of_a_hull_is_that_along_its_length_and_draught(towed):
    total = np.zeros(6)
    for i in range(40):
        for j in range(3):
            at = np.array([80 * ((i + 0.5) / 40 - 0.5), 0, -6 * (j + 0.5) / 3])
            area = np.array([20, 300, 0]) / 120
            total += drag(at, area, 1025, np.array([*towed["current"][j], 0]))
    np.testing.assert_allclose(towed["hull"], total, rtol=1e-6, atol=1)


def test_a_turning_hull_is_held_back_by_cross_flow(load):
    """Torque of rho/2 area/L times the integral of |x|^3 w^2, in still water."""
    still = {"hull.current.tide": 0, "hull.current.wind_driven": 0, "twist[6]": 0.1}
    found = load("weather", "towed").simulate(parameters=still)["hull"][-1]
    exact = 1025 / 2 * 300 / 80 * 2 * 40**4 / 4 * 0.1**2
    assert found[5] == pytest.approx(exact, rel=5e-3)


def test_quadratic_damping(towed):
    expected = np.arange(1, 7) * np.abs(TWIST) * TWIST
    np.testing.assert_allclose(towed["damper"], expected, rtol=1e-12)


def test_a_body_slowed_down_by_drag(load):
    """v = v0/(1 + rho A v0 t/(2 m))."""
    result = load("weather", "slowed").simulate()
    expected = 3 / (1 + 1025 * 40 * 3 * result.time / (2 * 100e3))
    np.testing.assert_allclose(result["v"][:, 1], expected, rtol=1e-4)
    assert np.abs(result["energy.residual"]).max() < 1e-6 * 100e3 * 9 / 2


def test_a_mooring_springs_in_six_directions(load):
    values = load("weather", "at_rest").eigenvalues()
    stiffness = np.array([1e5, 2e5, 3e6, 4e7, 5e8, 6e7])
    omega = np.sqrt(stiffness / [7e6, 7e6, 7e6, 3e8, 3e9, 3e9])
    found = np.sort(values.imag[values.imag > 1e-6])
    np.testing.assert_allclose(found, np.sort(omega), rtol=1e-6)


def test_a_mooring_keeps_its_energy_and_follows_the_pose(load):
    result = load("weather", "moored").simulate()
    start = 0.5 * np.array([1e5, 2e5, 3e6, 4e7, 5e8, 6e7]) @ np.square([3, -2, 0.5, 0.1, 0.05, 0.2])
    assert np.abs(result["energy.stored"]).max() < 1e-7 * start
    stretch = result["r"] + np.array([3, -2, 0.5])
    np.testing.assert_allclose(result["offset"][:, :3], stretch, atol=1e-6)


def test_station_keeping_holds_place_and_heading_against_a_load(load):
    """The integral takes the load over, and gives it back after it has ended."""
    load_of = {"load[1]": 1e5, "load[2]": -5e4, "load[6]": 2e6}
    result = load("weather", "held").simulate(parameters=load_of)
    k = int(np.searchsorted(result.time, 299))
    np.testing.assert_allclose(result["thrust"][k], [-1e5, 5e4, -2e6], rtol=0.25)
    np.testing.assert_allclose(result["r"][-1, :2], [5, -3], atol=0.01)
    assert np.abs(result["error"][-1]).max() < 0.01
    assert np.abs(result["thrust"][-1] / [5e5, 3e5, 1.5e7]).max() < 1e-3


def test_thrusters_keep_their_limits_and_the_integral_does_not_wind_up(load):
    """A load above the limits for 300 s: the ship is pushed away, and comes back."""
    load_of = {"load[1]": 5.1e5, "load[2]": 3.05e5}
    result = load("weather", "held").simulate(parameters=load_of)
    thrust = np.abs(result["thrust"]) / [5e5, 3e5, 1.5e7]
    assert 0.999 < thrust.max() < 1 + 1e-9
    assert result["r"][:, 0].max() > 30
    assert result["r"][:, 0].min() > -120, "without anti-windup it overshoots by 474 m"
    assert np.abs(result["r"][-1, :2] - [5, -3]).max() < 0.1


@pytest.mark.parametrize("rate", [0.05, 0.3, 0.785, 1.3])
def test_the_observer_is_a_notch_at_the_frequency_of_the_waves(load, rate):
    """Its transfer functions by Fossen and Strand, against an input that turns at a rate."""
    given = {"rate": rate, "filter.damping": 0.05, "filter.notch": 0.8, "filter.cutoff": 1.1}
    result = load("weather", "observed").simulate(parameters=given)
    s, w = 1j * rate, 0.785
    poles = (s + 1.1) * (s * s + 2 * 0.8 * w * s + w * w)
    difference = s * (s * s + 2 * 0.05 * w * s + w * w) / poles
    late = result.time > 150
    # measured = Im exp(s t), Re exp(s t)
    turning = np.exp(s * result.time[late])
    for name, gain in (("difference", difference), ("position", 1.1 / s * difference)):
        expected = gain * turning
        np.testing.assert_allclose(result[name][late, 0], expected.imag, atol=1e-5)
        np.testing.assert_allclose(result[name][late, 1], expected.real, atol=1e-5)


def test_a_wave_filter_takes_the_waves_out_of_the_thrust(load):
    """Less thrust at the frequencies of two waves; a constant force of 300 s is held as before."""
    runs = {scene: load("weather", scene).simulate() for scene in ("rocked", "filtered")}
    time = runs["rocked"].time
    early, late = (time > 200) & (time < 295), time > 600
    angles = np.outer(time[late], [0.785, 0.9])
    ones = np.ones((late.sum(), 1))
    waves = np.hstack([np.cos(angles), np.sin(angles), ones, time[late][:, None]])
    size = {}
    for scene, result in runs.items():
        fit = np.linalg.lstsq(waves, result["thrust"][late], rcond=None)[0]
        size[scene] = np.hypot(fit[:2], fit[2:4])
        held = result["thrust"][early].mean(axis=0)
        np.testing.assert_allclose(held, [-8e4, 5e4, -2e6], rtol=0.05, atol=2.5e4)
        assert np.abs(result["r"][late, :2].mean(axis=0)).max() < 0.25
    # Both waves; in yaw the derivative part is the largest.
    assert (size["filtered"] < 0.15 * size["rocked"]).all()


def test_a_ship_under_way_meets_the_waves_at_their_frequency_of_encounter(load):
    """Speed is a state here: its mean and the largest line of the spectrum of heave."""
    result = load("weather", "under_way").simulate()
    late = result.time > 200
    x, time = result["r"][late, 0], result.time[late]
    speed = np.polyfit(time, x, 1)[0]
    assert speed == pytest.approx(5, rel=0.01)
    w = 2 * np.pi / 9
    expected = w + w * w / 9.81 * speed
    rates = np.linspace(0.5, 1.5, 2001)
    heave = result["motion"][late, 0] * np.hanning(late.sum())
    lines = np.abs(np.exp(-1j * np.outer(rates, time)) @ heave)
    assert rates[lines.argmax()] == pytest.approx(expected, rel=2e-3)
    assert np.abs(result["r"][late, 1]).max() < 1e-6
    assert np.abs(result["energy.residual"]).max() < 1e-6 * result["energy.supplied"].max()


@pytest.mark.parametrize("scene", ["weather", "dynamically_positioned"])
def test_a_ship_in_all_weather_balances_its_books(load, scene):
    result = load("weather", scene).simulate(60)
    assert np.ptp(result["r"], axis=0).min() > 0.1
    assert np.abs(result["energy.residual"]).max() < 1e-6 * result["energy.supplied"].max()


def test_wind_and_current_push_a_moored_ship_to_its_static_place(load):
    """Without waves and gusts: springs times offset is the drag of air and water."""
    given = {"vessel.sea.height": 1e-3, "vessel.wind.speed": 0.1, "vessel.wind.seed": 3}
    result = load("weather", "weather").simulate(1500, every=100, parameters=given)
    z = np.array([1, 3, 5])
    current = 0.7 * (1 - z / 100) ** (1 / 7)
    area = 0.2 * 19.2 * 6 / 3
    force = 1025 / 2 * area * np.sum(current**2)
    assert result["r"][-1, 0] == pytest.approx(force / 1e5, rel=1e-2)


MODELS = Path(__file__).parents[1] / "models"


@pytest.mark.parametrize(
    "level",
    [
        "OsvAtRest", "Osv", "OsvSeakeeping", "OsvInSwell", "GunnerusAtRest", "Gunnerus",
        "SupplyAtRest", "SupplyGuided[5]", "SupplySeakeeping[5]", "Supply[5]",
        "SupplyWithMemory[5]", "SupplyInWeather[5]",
    ],
)  # fmt: skip
def test_each_level_of_each_ship_fills_one_slot(level):
    """A change of ship is one line, here `--use vessel=..`."""
    options = Options("any_ship", uses=(("vessel", level),))
    stages = compile_scene(MODELS / "weather.bg", options, until="causality")
    assert stages.causal is not None
