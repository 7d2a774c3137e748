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


def test_peaks_count_wherever_they_lie_in_a_step(load):
    """A peak beside the end of a step, and one narrower than the error of a parabola."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        level, frequency = 1 - 10 ** rng.uniform(-8, -2), 10 ** rng.uniform(0, 1.5)
        phase = rng.uniform(0, 6)
        values = {"level": level, "frequency": frequency, "phase": phase}
        found = load("pulses", "peaks").simulate(solver="rodas5p", parameters=values)["x"][-1]
        half = math.acos(level) / frequency
        peaks = (math.pi / 2 + 2 * math.pi * np.arange(60) - phase) / frequency
        within = np.minimum(peaks + half, 10) - np.maximum(peaks - half, 0)
        assert found == pytest.approx(1000 * within[within > 0].sum(), rel=1e-6), values
