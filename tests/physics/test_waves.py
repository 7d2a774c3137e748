"""Seas: spectra, their components, the surface, and what it costs to integrate with it."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

G = 9.81
HOURS = {"rtol": 1e-3}


def spectrum(w: float, height: float, peak: float, gamma: float, factor: bool = True) -> float:
    sigma = 0.07 if w <= peak else 0.09
    wave = 5 / 16 * height**2 * peak**4 / w**5 * math.exp(-1.25 * (peak / w) ** 4)
    raised = gamma ** math.exp(-((w - peak) ** 2) / (2 * sigma**2 * peak**2))
    return wave * raised * (1 - 0.287 * math.log(gamma) if factor else 1)


def moment(k: int, height: float, peak: float, gamma: float, factor: bool = True) -> float:
    """Moment m_k of the part of the spectrum from 0.5 to 5 times the peak."""
    ends = peak * np.array([0.5, 0.8, 1, 1.2, 2, 5])
    return sum(
        quad(lambda w: w**k * spectrum(w, height, peak, gamma, factor), a, b, epsabs=1e-12)[0]
        for a, b in pairwise(ends)
    )


def surface(result, amplitude, frequency, phase, direction, x, y) -> np.ndarray:
    wave = np.outer(result.time, frequency) + phase
    wave -= frequency**2 / G * (np.outer(x, np.cos(direction)) + np.outer(y, np.sin(direction)))
    return np.cos(wave) @ amplitude


@pytest.fixture(scope="module")
def formulas(load):
    return load("waves", "formulas")


@pytest.mark.parametrize(("height", "period"), [(3, 10), (0.5, 4), (12, 16)])
def test_spectra_are_those_of_their_formulas(formulas, height, period):
    result = formulas.simulate(parameters={"height": height, "period": period})
    peak = 2 * math.pi / period
    for name, gamma in (("pm", 1), ("js", 3.3)):
        expected = [spectrum(w, height, peak, gamma) for w in result["frequency"]]
        np.testing.assert_allclose(result[name], expected, rtol=1e-10, atol=1e-300)
        assert abs(result["frequency"][np.argmax(result[name])] - peak) <= 0.01


@pytest.mark.parametrize(
    ("k", "gamma"),
    [
        (0.1, 5),
        (3.6, 5),
        (3.61, math.exp(1.5985)),
        (4, math.exp(1.15)),
        (4.95, math.exp(0.0575)),
        (5, 1),
        (5.01, 1),
        (20, 1),
    ],
)
def test_the_usual_peak_factor_at_its_pieces(formulas, k, gamma):
    last = formulas.simulate(parameters={"k": k, "period": k * 2, "height": 4})
    assert last["default_gamma"][-1] == pytest.approx(gamma, rel=1e-6)
    assert last["usual"][-1] == pytest.approx(gamma, rel=1e-6)


@pytest.mark.parametrize("angle", [0, 0.7, math.pi / 2, math.pi])
def test_frequency_of_encounter(formulas, angle):
    result = formulas.simulate(parameters={"angle": angle})
    w = result["frequency"]
    expected = np.abs(w - w**2 / G * 5 * math.cos(angle))
    np.testing.assert_allclose(result["met"], expected, atol=1e-13)


def test_significant_height_of_jonswap():
    """The factor keeps it at 3.00 m; without the factor it is 3.70 m at gamma 3.3."""
    assert 4 * math.sqrt(moment(0, 3, 1, 3.3)) == pytest.approx(3, rel=2e-3)
    assert 4 * math.sqrt(moment(0, 3, 1, 3.3, factor=False)) == pytest.approx(3.70, abs=0.01)


@pytest.mark.parametrize("seed", [1, 2, 7])
def test_significant_height_over_three_hours(load, seed):
    """Each seed by itself, and the mean of the squares of the amplitudes exactly."""
    result = load("waves", "irregular").simulate(parameters={"sea.seed": seed}, **HOURS)
    m0 = np.sum(result["amplitude"][0] ** 2) / 2
    assert m0 == pytest.approx(moment(0, 3, 2 * math.pi / 10, 3.3), rel=1e-4)
    elevation = result["elevation"]
    assert 4 * elevation.std() == pytest.approx(3, rel=1e-2)
    assert abs(elevation.mean()) < 1e-2
    direct = surface(result, *(result[k][0] for k in COMPONENTS), 0, 0)
    np.testing.assert_allclose(elevation, direct.ravel(), atol=1e-8)


COMPONENTS = ("amplitude", "frequency", "phase", "direction")


def test_a_short_crested_sea_met_by_a_moving_point(load):
    given = {"sea.spread": 2, "sea.heading": 0.4, "start": [30, -50], "velocity": [3, -2]}
    result = load("waves", "irregular").simulate(60, every=1, parameters=given)
    components = (result[k][0] for k in COMPONENTS)
    x, y = 30 + 3 * result.time, -50 - 2 * result.time
    np.testing.assert_allclose(result["elevation"], surface(result, *components, x, y), atol=1e-9)


@pytest.mark.parametrize(("scene", "gamma"), [("irregular", 3.3), ("developed", 1)])
def test_moments_of_the_components(load, scene, gamma):
    """Frequencies are random within their bands: moments are met by the mean of ten seeds."""
    model = load("waves", scene)
    found = []
    for seed in range(1, 11):
        row = model.simulate(10, every=10, parameters={"sea.seed": seed})
        a, w = row["amplitude"][0], row["frequency"][0]
        found.append([np.sum(a**2 * w**k) / 2 for k in (-1, 0, 1, 2)])
    exact = [moment(k, 3, 2 * math.pi / 10, gamma) for k in (-1, 0, 1, 2)]
    np.testing.assert_allclose(np.mean(found, axis=0), exact, rtol=2e-3)
    np.testing.assert_allclose(found, np.tile(exact, (10, 1)), rtol=1e-2)


def test_bands_follow_each_other_and_phases_are_spread(load):
    row = load("waves", "irregular").simulate(10, every=10)
    w, phase = row["frequency"][0], row["phase"][0]
    edges = 2 * math.pi / 10 * 0.5 * 10 ** (np.arange(101) / 100)
    assert np.all((edges[:-1] <= w) & (w < edges[1:]))
    within = (w - edges[:-1]) / np.diff(edges)
    for share in (within, phase / (2 * math.pi)):
        assert 0 <= share.min() < 0.05 and 0.95 < share.max() < 1
        assert share.mean() == pytest.approx(0.5, abs=0.1)
    assert abs(np.corrcoef(within, phase)[0, 1]) < 0.25


def test_a_sea_is_the_same_in_each_run_and_another_by_another_seed(load):
    model = load("waves", "irregular")
    first, again, other = (
        model.simulate(100, every=1, parameters={"sea.seed": seed})["elevation"]
        for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.5


@pytest.mark.parametrize("s", [0, 1, 2.5, 10])
def test_spread_of_directions(load, s):
    """Sine squared of the angle has the mean 1/(2 s + 2) under cos^2s."""
    model = load("waves", "irregular")
    angles = []
    for seed in range(1, 21):
        given = {"sea.seed": seed, "sea.spread": s, "sea.heading": 0.4}
        angles.append(model.simulate(10, every=10, parameters=given)["direction"][0] - 0.4)
    found = np.concatenate(angles)
    if s == 0:
        assert not found.any()
        return
    density = lambda b, k: math.cos(b) ** (2 * s) * math.sin(b) ** k  # noqa: E731
    area = quad(density, -math.pi / 2, math.pi / 2, args=(0,))[0]
    for k in (1, 2, 4):
        exact = quad(density, -math.pi / 2, math.pi / 2, args=(k,))[0] / area
        power = np.sin(found) ** k
        assert power.mean() == pytest.approx(exact, abs=4 * power.std() / math.sqrt(len(found)))
    assert np.abs(found).max() < math.pi / 2


@pytest.mark.parametrize(("scene", "n"), [("alone", 1), ("regular", 2)])
def test_a_regular_wave_met_by_a_moving_point(load, scene, n):
    result = load("waves", scene).simulate()
    x, y = 10 + 4 * result.time, -20 + result.time
    w = 2 * math.pi / 8
    wave = w * result.time - w**2 / G * (x * math.cos(0.5) + y * math.sin(0.5)) + 0.3
    np.testing.assert_allclose(result["elevation"], 1.5 * np.cos(wave), atol=1e-12)
    amplitude = result["amplitude"].reshape(len(result.time), n)
    np.testing.assert_array_equal(amplitude[0], [1.5, 0][:n])


def test_given_components(load):
    result = load("waves", "given").simulate()
    a, w, e, b = (np.array(v) for v in ([1, 0.5], [0.6, 0.9], [0.3, 1], [0.5, 2]))
    expected = surface(result, a, w, e, b, 10 + 4 * result.time, -20 + result.time)
    np.testing.assert_allclose(result["elevation"], expected, atol=1e-12)


def test_a_moving_point_meets_components_at_their_frequencies_of_encounter(load):
    """One component of the sea alone, at 5 m/s against it."""
    result = load("waves", "given").simulate(
        parameters={
            "sea.amplitude[2]": 0, "sea.direction[1]": 0, "sea.phase[1]": 0,
            "start[1]": 0, "velocity[1]": -5, "velocity[2]": 0,
        }
    )  # fmt: skip
    met = 0.6 + 0.6**2 / G * 5
    np.testing.assert_allclose(result["elevation"], np.cos(met * result.time), atol=1e-12)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_a_sea_of_100_components_costs_no_steps(load, rtol):
    """As many steps as SciPy's method of the same order, which does not bound terms of time."""
    result = load("waves", "buoy").simulate(every=300, rtol=rtol, solver="dopri5")
    a, w, e = (result[k][0] for k in ("amplitude", "frequency", "phase"))
    other = solve_ivp(
        lambda t, y: [y[1], 9 * (a @ np.cos(w * t + e) - y[0]) - 0.9 * y[1]],
        (0, 300), [0, 0], rtol=rtol, atol=rtol * 1e-3,
    )  # fmt: skip
    assert result.counts["steps"] < 1.15 * len(other.t)
    if rtol < 1e-5:
        assert result["x"][-1] == pytest.approx(other.y[0, -1], abs=1e-3)


def test_a_sea_is_drawn_by_its_components(load):
    model = load("waves", "irregular")
    result = model.simulate(10, every=10, shapes=True)
    (sea,) = result.shapes
    rows = np.asarray(sea["waves"])
    rows = rows[0] if rows.ndim == 3 else rows
    expected = [result[k][0] for k in ("amplitude", "frequency", "direction", "phase")]
    np.testing.assert_allclose(rows, np.transpose(expected), rtol=1e-14)
