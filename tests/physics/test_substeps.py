"""Fixed steps that are subdivided: a cylinder on valves, whose relief valve opens within a step.

The relief valve multiplies the slope of the pump's pressure balance by a thousand within 1 bar. The
Jacobian at the start of a step is that of one side of this knee, and later stages are on the other.
"""

from __future__ import annotations

import numpy as np
import pytest

from bgc.runtime.model import Model
from bgc.runtime.results.result import Result

SCENE = ("valve_cylinder", "out_and_in")
BAR = 1e5


@pytest.fixture(scope="module")
def cylinder(load) -> Model:
    return load(*SCENE)


@pytest.fixture(scope="module")
def reference(cylinder) -> Result:
    return cylinder.simulate(solver="rodas5p", rtol=1e-9)


def distance(result: Result, reference: Result, name: str) -> float:
    return float(np.abs(result[name] - reference[name]).max())


def residual(result: Result) -> float:
    """The largest energy residual over the energy exchanged."""
    return float(np.abs(result["energy.residual"]).max() / result.counts["exchanged"])


def test_two_adaptive_methods_agree(cylinder, reference) -> None:
    other = cylinder.simulate(solver="radau5", rtol=1e-8)
    assert distance(other, reference, "supply_pressure") < 1e-3 * BAR
    assert distance(other, reference, "stroke") < 1e-8


def test_whole_steps_ring_behind_the_relief_valve(cylinder, reference) -> None:
    whole = cylinder.simulate(solver="ros34prw", step=1e-3, substeps=1)
    assert distance(whole, reference, "supply_pressure") > 20 * BAR
    assert residual(whole) > 0.01
    assert {warning.code for warning in whole.warnings} == {"BG716", "BG719"}


@pytest.mark.parametrize("solver", ["ros34prw", "rodas23w", "ros23"])
def test_subdivided_steps_do_not(cylinder, reference, solver) -> None:
    divided = cylinder.simulate(solver=solver, step=1e-3, substeps=16)
    assert distance(divided, reference, "supply_pressure") < 2 * BAR
    assert distance(divided, reference, "stroke") < 1e-6
    assert residual(divided) < 3e-5
    # Smooth stretches cost one step each, and no step takes more attempts than the budget.
    counts = divided.counts
    assert 0 < counts["subdivided"] < 50
    assert counts["steps"] + counts["rejected"] < 15_000 + 10 * counts["subdivided"]
    assert counts["most_attempts"] <= 17


def test_the_default_divides_steps(cylinder, reference) -> None:
    default = cylinder.simulate()
    assert default.solver == "ros34prw" and default.counts["subdivided"] > 0
    assert distance(default, reference, "supply_pressure") < 2 * BAR
    assert residual(default) < 3e-5


def test_a_tighter_tolerance_is_more_accurate(cylinder, reference) -> None:
    errors = [
        distance(
            cylinder.simulate(solver="ros34prw", step=1e-3, substeps=64, rtol=rtol),
            reference,
            "supply_pressure",
        )
        for rtol in (1e-2, 1e-4)
    ]
    assert errors[1] < 0.01 * errors[0]


@pytest.mark.parametrize("substeps", [2, 3, 4, 8])
def test_the_budget_is_kept_and_a_step_beyond_it_is_reported(cylinder, substeps) -> None:
    result = cylinder.simulate(0.02, every=1e-3, solver="ros34prw", step=1e-3, substeps=substeps)
    assert result.counts["most_attempts"] <= substeps + 1
    assert result.counts["over_budget"] == 1
    assert result.counts["steps"] + result.counts["rejected"] <= 20 + substeps
    (warning,) = (warning for warning in result.warnings if warning.code == "BG730")
    assert f"1 step of 0.001 s exceeded the tolerance although divided into {substeps}" in str(
        warning.message
    )
    assert "at t = 0" in warning.message


def test_an_ensemble_subdivides_the_same_steps_as_alone(cylinder) -> None:
    volumes = {"supply_volume": [0.5e-3, 0.7e-3, 1e-3, 1.5e-3, 2e-3, 3e-3]}
    options = {"solver": "ros34prw", "step": 1e-3, "substeps": 8}
    together = cylinder.simulate_many(volumes, 7.0, **options)
    alone = cylinder.simulate_many(volumes, 7.0, vectorised=False, **options)
    assert (together.together, alone.together) == (6, 0)
    scale = np.abs(alone.values).max(axis=(0, 1))
    assert (np.abs(together.values - alone.values) / scale).max() < 1e-7
    assert [w.code for w in together.warnings] == [w.code for w in alone.warnings] == ["BG730"]
    texts = [run.warnings[0].message.split(" was ")[0] for run in (together, alone)]
    assert texts[0] == texts[1]
