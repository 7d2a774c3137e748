"""Features in time alone are found, however narrow, at no cost to slow ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

ADAPTIVE = [
    {},
    {"rtol": 1e-9},
    {"rtol": 1e-3, "atol": 1e-9},
    {"solver": "rodas4p2"},
    {"solver": "radau5"},
    {"solver": "dopri5"},
]
FIXED = [
    {"solver": name, "step": step} for name in ("ros34prw", "rk4", "heun") for step in (0.01, 0.1)
]


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-5])
def test_a_pulse_counts_in_full(load, width, method):
    result = load("timed", "pulse").simulate(parameters={"width": width}, every=10, **method)
    assert result["x"][-1] == pytest.approx(math.sqrt(math.pi) * width, rel=2e-3, abs=2e-7)
    assert result.counts["steps"] < 300


@pytest.mark.parametrize("method", ADAPTIVE)
def test_every_pulse_of_a_train_counts(load, method):
    result = load("timed", "train").simulate(every=10, **method)
    assert result["x"][-1] == pytest.approx(10 * math.sqrt(math.pi) * 1e-3, rel=1e-2)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_flanks_and_flat_tops_count(load, method):
    result = load("timed", "hats").simulate(every=10, **method)
    assert result["hat"][-1] == pytest.approx(1e-3, rel=1e-2)
    end = 1e-3 * math.sqrt(math.log(2))
    exact = quad(lambda t: math.exp(-((t / 1e-3) ** 2)) - 0.5, -end, end)[0]
    assert result["top"][-1] == pytest.approx(exact, rel=1e-2)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_pulse_in_a_product_counts(load, method):
    result = load("timed", "product").simulate(every=10, **method)
    exact = math.pi * 1e-4 * (2 + math.sin(6.1))
    assert result["x"][-1] == pytest.approx(exact, rel=2e-2)


@pytest.mark.parametrize("method", FIXED)
def test_fixed_steps_are_cut_for_a_pulse(load, method):
    result = load("timed", "pulse").simulate(every=1, **method)
    assert result["x"][-1] == pytest.approx(math.sqrt(math.pi) * 1e-3, rel=3e-2)
    whole = round(10 / method["step"])
    assert whole + 10 < result.counts["steps"] < whole + 200


def test_slow_components_limit_no_step(load):
    """With bounds, but without narrow features, steps are those of error control."""
    result = load("timed", "sea").simulate()
    assert result.counts["steps"] < 900
    steps = load("timed", "sea").simulate(solver="rk4", step=0.1).counts["steps"]
    assert steps == 10000


@pytest.mark.slow
@pytest.mark.parametrize("method", [{}, {"solver": "ros34prw", "step": 0.01}])
def test_each_instance_of_an_ensemble_finds_its_own_pulse(load, method):
    times = np.linspace(1.234, 8.765, 9)
    together = load("timed", "pulse").simulate_many({"at": times}, every=1, **method)
    assert together.together == 9
    np.testing.assert_allclose(together["x"][:, -1], math.sqrt(math.pi) * 1e-3, rtol=3e-2)


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5"])
def test_a_pulse_behind_the_second_switch_counts(load, solver):
    result = load("timed", "gated").simulate(solver=solver)
    np.testing.assert_allclose(result["x"][1:], 1.0, rtol=1e-6)
    np.testing.assert_allclose(result["y"], [0, 0, 0.01 * np.sqrt(np.pi)], rtol=2e-3, atol=1e-9)


@pytest.mark.parametrize(
    "method",
    [
        {},
        {"solver": "dopri5"},
        {"solver": "ros34prw", "step": 0.5},
        {"solver": "rk4", "step": 0.07},
    ],
)
def test_edges_after_long_stretches_without_one_are_met(load, method):
    """The rate is linear between the edges, so that a step that ends at each is exact."""
    result = load("timed", "ramps").simulate(**method)
    exact = sum(970 - start - 0.5 for start in (3.25, 66.125, 966))
    assert result["x"][-1] == pytest.approx(exact, rel=1e-11)
    assert result.counts["events"] == 6
