"""Pulses narrower than a step count in full, whatever the method and its step."""

import math

import numpy as np
import pytest

SOLVERS = [{}, {"solver": "radau5"}, {"solver": "ros34prw", "step": 0.01}]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("scene", "area"), [("once", 1), ("periodic", 10), ("passed", 1)])
def test_a_pulse_between_two_comparisons_counts_in_full(load, scene, area, solver):
    result = load("pulses", scene).simulate(**solver)
    assert result["x"][-1] == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("level", [0.9, 0.9999, 0.999999])
def test_peaks_of_a_function_of_time_count_from_where_they_pass_the_level(load, level, solver):
    """32 peaks; such a switch leaves its mode and comes back between two looks at it."""
    result = load("pulses", "peaks").simulate(**solver, parameters={"level": level})
    exact = 32 * 1000 * 2 * math.acos(level) / 20
    assert result["x"][-1] == pytest.approx(exact, rel=1e-7)


def drawn(count):
    """Parameters of narrow peaks, and the times for which each is above its level in 10 s."""
    rng = np.random.default_rng(1)
    values = {
        "level": 1 - 10 ** rng.uniform(-8, -2, count),
        "frequency": 10 ** rng.uniform(0, 1.5, count),
        "phase": rng.uniform(0, 6, count),
    }
    half = (np.arccos(values["level"]) / values["frequency"])[:, None]
    turns = math.pi / 2 + 2 * math.pi * np.arange(60)
    peaks = (turns - values["phase"][:, None]) / values["frequency"][:, None]
    within = np.minimum(peaks + half, 10) - np.maximum(peaks - half, 0)
    return values, np.maximum(within, 0).sum(axis=1)


@pytest.mark.parametrize("solver", [{"solver": "rodas5p"}, {"solver": "ros34prw", "step": 1.0}])
def test_peaks_count_wherever_they_lie_in_a_step(load, solver):
    """A peak beside the end of a step, many in one step, and one narrower than any of its parts."""
    values, exact = drawn(20)
    for k in range(20):
        one = {name: all_values[k] for name, all_values in values.items()}
        found = load("pulses", "peaks").simulate(**solver, parameters=one)["x"][-1]
        assert found == pytest.approx(1000 * exact[k], rel=1e-6), one


@pytest.mark.parametrize("scene", ["peaks", "clocked"])
def test_peaks_count_in_steps_that_other_instances_choose(load, scene):
    values, exact = drawn(200)
    many = load("pulses", scene).simulate_many(values, solver="rodas5p")
    assert many.together == 200
    np.testing.assert_allclose(many["x"][:, -1], 1000 * exact, rtol=1e-6)
