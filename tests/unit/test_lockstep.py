"""Guards of the steps that instances take together: errors, pivots, states that are set."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from model_files import compiled, model_text

from bgc.runtime.model import Model
from bgc.runtime.results.ensemble import Ensemble

MODELS = Path(__file__).parents[1] / "models"


def alone(model: Model, ensemble: Ensemble, **options: float | str) -> np.ndarray:
    """The outputs of each instance, simulated by itself."""
    sets = zip(*ensemble.parameters.values(), strict=True)
    runs = [
        model.simulate(parameters=dict(zip(ensemble.parameters, each, strict=True)), **options)
        for each in sets
    ]
    return np.array([np.column_stack([run[name] for name in ensemble.names]) for run in runs])


SWING = model_text("lockstep_swing")
RUNS = [
    {"solver": "rodas5p", "rtol": 1e-4},
    {"solver": "rodas5p", "rtol": 1e-4, "step": 3.0},  # the first one
    {"solver": "rodas4p2", "rtol": 1e-4},
    {"solver": "dopri5", "rtol": 1e-4},
    {"solver": "dopri5", "rtol": 1e-3, "max_step": 0.1},
    {"solver": "ros34prw", "step": 0.05},
    {"solver": "rk4", "step": 0.05},
]


def test_instances_that_are_alike_take_the_steps_of_one_alone(tmp_path: Path) -> None:
    """Other steps differ by the tolerance, the same ones by rounding."""
    model = compiled(tmp_path, SWING)
    for options in RUNS:
        ensemble = model.simulate_many({"k": [10.0] * 4}, **options)
        assert ensemble.together == 4
        expected = alone(model, ensemble, **options)
        np.testing.assert_allclose(ensemble.values, expected, atol=1e-7)


def test_long_steps_along_stiff_solutions_are_right_inside_too(tmp_path: Path) -> None:
    """y = cos t at any rate: the error estimate of such a method is zero."""
    model = compiled(
        tmp_path,
        "model Lag { param rate = 1e8; state y = 1;"
        " der(y) = (rate*(cos(time / 1 s) - y) - sin(time / 1 s)) / 1 s; }"
        "scene s of Lag { observe y; run 20 s every 0.7 s; }",
    )
    values = {"rate": np.geomspace(1e7, 1e9, 6)}
    ensemble = model.simulate_many(values, solver="rodas4p2", rtol=1e-5, step=5.0)  # the first
    assert ensemble.together == 6
    assert np.abs(ensemble.values[:, :, 0] - np.cos(ensemble.time)).max() < 1e-3


@pytest.mark.parametrize("solver", ["rodas5p", "rodas4p2"])
def test_a_singular_start_is_resolved(tmp_path: Path, solver: str) -> None:
    """Lane-Emden equation of index 5: 2/t falls at once, which no error estimate sees."""
    model = compiled(
        tmp_path,
        "model Star { param k = 1; state y = 1; state v = 0; der(y) = v / 1 s;"
        " der(v) = (-k*y^5 - 2*v / ((time + 1 ns) / 1 s)) / 1 s; }"
        "scene s of Star { observe y; run 10 s every 10 s; }",
    )
    ensemble = model.simulate_many({"k": [1.0, 1.0, 1.0, 1.1]}, solver=solver, rtol=1e-8)
    assert ensemble.together == 4
    assert ensemble.values[0, -1, 0] == pytest.approx((1 + 100 / 3) ** -0.5, abs=1e-8)


def test_a_step_that_meets_a_pulse_is_tried_again(tmp_path: Path) -> None:
    model = compiled(
        tmp_path,
        "model Pulsed { param at = 5; state y = 0;"
        " der(y) = (exp(-((time / 1 s - at)/0.1)^2) - y/100) / 1 s; }"
        "scene s of Pulsed { observe y; run 10 s every 0.2 s; }",
    )
    at = np.linspace(5, 6, 6)
    ensemble = model.simulate_many({"at": at}, rtol=1e-7)
    assert ensemble.together == 6
    s = np.linspace(0, 10, 100_001)
    pushed = np.exp(-(((s - at[:, None]) / 0.1) ** 2) - (10 - s) / 100)
    np.testing.assert_allclose(ensemble.values[:, -1, 0], np.trapezoid(pushed, s), rtol=1e-5)


def test_a_lane_that_needs_steps_of_no_length_leaves(tmp_path: Path) -> None:
    """y' = y^2 ends at 1 / y(0), in one lane within the run."""
    model = compiled(
        tmp_path,
        "model Escape { param start = 0.1; state y = start; der(y) = y^2 / 1 s; }"
        "scene s of Escape { observe y; run 2 s every 0.5 s; }",
    )
    start = np.array([0.1, 0.2, 0.8, 0.3, 0.4])
    ensemble = model.simulate_many({"start": start}, rtol=1e-7)
    assert ensemble.status == ("done", "done", "failed", "done", "done")
    assert ensemble.together == 4
    exact = start / (1 - start * ensemble.time[:, None])
    good = ensemble.done
    np.testing.assert_allclose(ensemble["y"][good], exact.T[good], rtol=1e-5)


def test_a_lane_whose_pivots_are_lost_leaves(tmp_path: Path) -> None:
    """Elimination begins with `1/(h gamma) - a`."""
    model = compiled(
        tmp_path,
        "model Lost { param a = 1; state x = 1; state y = 0;"
        " der(x) = (a*x + y) / 1 s; der(y) = (-x - y) / 1 s; }"
        "scene s of Lost { observe x; run 0.4 s every 0.1 s; }",
    )
    step, gamma = 0.1, 0.435866521508459
    lost = (1 + 1e-14) / (step * gamma)
    options = {"solver": "ros34prw", "step": step}
    ensemble = model.simulate_many({"a": [1.0, lost, 2.0, 3.0, 4.0]}, **options)
    assert ensemble.together == 4
    np.testing.assert_allclose(ensemble.values, alone(model, ensemble, **options), rtol=1e-9)


def test_quaternions_have_length_one_after_every_step(tmp_path: Path) -> None:
    text = (MODELS / "tumbling.bg").read_text()
    model = compiled(tmp_path, text.replace("observe linear", "observe pose.attitude.h as h", 1))
    options = {"solver": "ros23", "step": 0.05, "duration": 2.0, "every": 0.05}
    ensemble = model.simulate_many({"com[1]": np.linspace(0.05, 0.2, 5)}, **options)
    assert ensemble.together == 5
    np.testing.assert_allclose(np.linalg.norm(ensemble["h"], axis=2), 1, rtol=1e-14)
