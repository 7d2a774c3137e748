"""Pulses of functions of states, which a step would jump over, are found by adaptive methods."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

METHODS = [{}, {"rtol": 1e-9}, {"solver": "rodas4p2"}, {"solver": "radau5"}, {"solver": "dopri5"}]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("width", [0.2, 1e-2, 1e-3])
def test_a_bump_of_a_state_counts(load, width, method):
    result = load("hidden", "bump").simulate(parameters={"width": width}, **method)
    assert result["x"][-1] == pytest.approx(math.sqrt(math.pi) * width, rel=1e-2)
    assert result.counts["steps"] < 300


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("scene", "area"),
    [
        ("peak", 1e-2 * (math.atan(7.123e2) + math.atan(12.877e2))),
        ("gap", 2e-2 * quad(lambda u: 1 - math.tanh(u * u), 0, 30)[0]),
    ],
)
def test_peaks_of_quotients_and_gaps_of_sigmoids_count(load, scene, area, method):
    result = load("hidden", scene).simulate(**method)
    assert result["x"][-1] == pytest.approx(area, rel=1e-2)


@pytest.mark.parametrize("method", METHODS)
def test_every_pass_of_a_swing_counts(load, method):
    result = load("hidden", "swing").simulate(**method)
    assert result["passed"][-1] == pytest.approx(6 * math.sqrt(math.pi) * 1e-3, rel=2e-2)


def test_smooth_functions_of_states_reject_no_step(load):
    result = load("hidden", "smooth").simulate()
    assert result.counts["rejected"] < 10
    assert result.counts["steps"] < 200


@pytest.mark.slow
@pytest.mark.parametrize("method", [{}, {"solver": "dopri5"}])
def test_each_instance_of_an_ensemble_finds_its_own_bump(load, method):
    places = np.linspace(3.21, 15.43, 9)
    parameters = {"at": places, "width": np.full(9, 0.02)}
    together = load("hidden", "bump").simulate_many(parameters, **method)
    assert together.together == 9
    np.testing.assert_allclose(together["x"][:, -1], math.sqrt(math.pi) * 0.02, rtol=1e-2)
