"""Pulses narrower than a step count in full, whatever the method and its step."""

import math

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
