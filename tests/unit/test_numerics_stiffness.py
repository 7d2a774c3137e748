"""The bound on the spectral radius that a run keeps."""

from __future__ import annotations

import math
from typing import Any

import pytest


def test_of_a_stiff_scalar(c_model: Any) -> None:
    problem = c_model("prothero_robinson")
    problem.set(p0=-1e4)
    problem.start("rodas5p")
    problem.finish([2.0])
    assert problem.counts.fastest == pytest.approx(1e4)
    assert problem.counts.stiffness == pytest.approx(1e4 * problem.time)


@pytest.mark.parametrize("method", ["rodas5p", "radau5", "ros34prw"])
def test_of_an_oscillation_whatever_the_scales_of_its_states(c_model: Any, method: str) -> None:
    stop = c_model("stop_unlocated")  # x'' = -9 x - 40 (x - gap) behind the gap
    stop.set(p0=1e9)
    stop.start(method, **({"step": 0.01} if method == "ros34prw" else {}))
    stop.finish([2.0])
    assert 3.0 <= stop.counts.fastest < 3.6
    assert 3.0 * 2.0 <= stop.counts.stiffness < 3.6 * stop.time


def test_of_coupled_rates_there_is_none(c_model: Any) -> None:
    amplifier = c_model("amplifier")
    amplifier.start("rodas5p", rtol=1e-4)
    amplifier.finish([0.01])
    assert math.isinf(amplifier.counts.fastest)


def test_explicit_methods_do_not_know_it(c_model: Any) -> None:
    stop = c_model("stop")
    stop.start("dopri5")
    stop.finish([1.0])
    assert stop.counts.fastest == stop.counts.stiffness == 0.0


@pytest.mark.parametrize("method", ["rodas5p", "rodas4p2", "dopri5"])
def test_the_steps_that_error_control_alone_would_take_are_told_of_shorter_ones(
    c_model: Any, method: str
) -> None:
    oscillator = c_model("stop_unlocated")  # x'' = -9 x, far from its stop
    oscillator.set(p0=1e9)
    oscillator.start(method, atol=1e-7)
    oscillator.finish([20.0])
    free = oscillator.counts.steps
    oscillator.start(method, atol=1e-7, max_step=20.0 / free / 4)
    oscillator.finish([20.0])
    assert oscillator.counts.steps > 3.5 * free
    assert 0.7 * free < oscillator.counts.controlled_steps < 1.1 * free
