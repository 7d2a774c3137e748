"""Ensembles change between the implicit method and its explicit partner as single runs do."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from model_files import model_file

import bgc
from bgc.language.methods import SWITCHING, SWITCHING_FIXED
from bgc.runtime.model import Model
from bgc.runtime.results.ensemble import Ensemble
from bgc.runtime.running import batches

# Oscillators of van der Pol, each of which pulls at all others, so that explicit steps cost half.
# The first may meet a wall, and `late` becomes fast, if at all, while the run goes on.


@pytest.fixture(scope="module")
def ring() -> Model:
    model = bgc.compile(model_file("lane_switching_ring"))
    assert 0.0 < model.library.explicit_cost < 0.56
    return model


@pytest.fixture(scope="module")
def arm() -> Model:
    return bgc.compile(model_file("lane_switching_arm"))


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> dict[int, Mapping[str, float]]:
    """The counts of the instances of the last ensemble, by their numbers."""
    found: dict[int, Mapping[str, float]] = {}
    original = batches.Work._warn

    def keep(work, number, instance, rows):
        found[number] = instance.counts
        original(work, number, instance, rows)

    monkeypatch.setattr(batches.Work, "_warn", keep)
    return found


def errors(model: Model, ensemble: Ensemble, **options: float | str) -> np.ndarray:
    """The largest difference of each instance from a run alone, by default at a tight tolerance."""
    options = options or {"solver": "rodas5p", "rtol": 1e-10}
    found = []
    for k in range(ensemble.count):
        values = {name: each[k] for name, each in ensemble.parameters.items()}
        run = model.simulate(parameters=values, **options)
        alone = np.column_stack([run[name] for name in ensemble.names])
        found.append(np.abs(ensemble.values[k] - alone).max())
    return np.array(found)


def test_instances_that_are_alike_change_as_one_alone(ring, counts) -> None:
    """Every estimate and every decision is that of the run alone, by rounding."""
    ensemble = ring.simulate_many({"mu": [1.0] * 4})
    run = ring.simulate()
    assert ensemble.solver == run.solver == SWITCHING
    assert ensemble.together == 4
    np.testing.assert_allclose(ensemble["y[1]"][2], run["y[1]"], atol=1e-6)
    for name in ("steps", "explicit_steps", "method_changes", "jacobians"):
        assert counts[2][name] == pytest.approx(run.counts[name], abs=2)
    assert run.counts["explicit_steps"] > 0.9 * run.counts["steps"]


def test_the_stiffest_instance_decides_for_all(ring, counts) -> None:
    """dopri5 would take eight times as many steps."""
    ensemble = ring.simulate_many({"mu": [0.1, 0.5, 1.0, 100.0, 0.3, 300.0]})
    assert ensemble.together == 6
    assert errors(ring, ensemble).max() < 5e-4
    several = counts[0]
    assert 0 < several["explicit_steps"] < 0.3 * several["steps"]
    assert several["steps"] < 1000


def test_it_returns_where_an_instance_becomes_stiff(ring, counts) -> None:
    """dopri5 would follow the one instance that becomes fast in 1e6 steps."""
    ensemble = ring.simulate_many({"fast": [0.0, 0.0, 1e6, 0.0], "mu": [0.5, 0.4, 0.3, 0.2]})
    assert ensemble.together == 4
    assert errors(ring, ensemble).max() < 1e-4
    assert counts[0]["explicit_steps"] > 0.3 * counts[0]["steps"]
    assert counts[0]["jacobians"] > 20
    assert counts[0]["steps"] < 1500


def test_instances_meet_events_by_themselves_between_explicit_steps(ring, counts) -> None:
    ensemble = ring.simulate_many({"wall": [100.0, 1.9, 1.7, 1.5], "mu": [0.5, 0.6, 0.7, 0.8]})
    assert ensemble.together == 4
    assert errors(ring, ensemble).max() < 1e-4
    assert [counts[k]["events"] > 0 for k in range(4)] == [False, True, True, True]
    assert counts[0]["explicit_steps"] > 0.8 * counts[0]["steps"]


def test_rounding_is_sampled_under_both_methods(ring, counts) -> None:
    """Accurate steps of both are not taken for rounding."""
    ensemble = ring.simulate_many({"mu": [0.5, 0.4, 0.3, 0.2]}, rtol=1e-9, duration=60.0)
    assert counts[0]["rounding_samples"] >= 3
    assert 0 < counts[0]["explicit_steps"] < counts[0]["steps"]
    assert not ensemble.run_warnings


def test_an_arm_swings_by_explicit_steps(arm, counts) -> None:
    """Energy accounts, which error control watches, hold after the changes."""
    ensemble = arm.simulate_many({"joint[1].friction": [0.4, 0.5, 0.6, 0.7]}, rtol=1e-7)
    assert ensemble.solver == SWITCHING and ensemble.together == 4
    assert counts[0]["explicit_steps"] > 0.5 * counts[0]["steps"]
    assert counts[0]["method_changes"] >= 2
    assert errors(arm, ensemble, solver="rodas5p", rtol=1e-9).max() < 1e-5
    assert np.abs(ensemble["rest"]).max() < 1e-5


@pytest.mark.parametrize("rtol", [1e-4, 1e-7])
def test_a_step_begins_with_f_of_the_last_stage_before(arm, counts, rtol) -> None:
    """Six evaluations of f in a step of dopri5, as alone, and one for the first step."""
    ensemble = arm.simulate_many({"joint[1].friction": [0.5] * 4}, solver="dopri5", rtol=rtol)
    run = arm.simulate(solver="dopri5", rtol=rtol)
    np.testing.assert_allclose(ensemble["first"][2], run["first"], rtol=0, atol=1e-12)
    attempts = counts[2]["steps"] + counts[2]["rejected"]
    assert attempts == run.counts["steps"] + run.counts["rejected"]
    assert counts[2]["rhs"] == 6 * attempts + 1


@pytest.mark.parametrize("step", [0.01, 0.1, 0.4])
def test_fixed_steps_of_instances_that_are_alike_are_those_of_one_alone(ring, counts, step) -> None:
    """To rounding, with the same warnings of steps that are too long."""
    options = {"step": step, "substeps": 1}
    ensemble = ring.simulate_many({"mu": [1.0] * 4}, **options)
    run = ring.simulate(**options)
    assert ensemble.solver == run.solver == SWITCHING_FIXED
    assert ensemble.together == 4
    np.testing.assert_allclose(ensemble["y[1]"][2], run["y[1]"], atol=1e-10)
    assert counts[2]["explicit_steps"] == run.counts["explicit_steps"]
    assert counts[2]["method_changes"] == run.counts["method_changes"]
    assert (counts[2]["explicit_steps"] > 0) == (step < 0.2)
    alone = [(w.code, w.message) for w in run.warnings]
    assert [(w.code, w.message) for w in ensemble.run_warnings.get(2, ())] == alone


@pytest.mark.parametrize("soft", [0.3, 1e-3])
def test_fixed_steps_are_implicit_while_an_instance_is_stiff(ring, counts, soft) -> None:
    """Also where it becomes so within a step, which the implicit method takes again."""
    values = {"fast": [0.0, 0.0, 1e6, 0.0], "soft": [soft] * 4, "waking": [10.0] * 4}
    ensemble = ring.simulate_many(values, step=0.01, substeps=1)
    assert ensemble.together == 4
    assert errors(ring, ensemble).max() < 1e-4
    several = counts[2]
    assert several["method_changes"] >= 2
    assert 0.2 < several["explicit_steps"] / several["steps"] < 0.8


def test_fixed_steps_meet_events_by_the_method_of_all(ring, counts) -> None:
    """Those that an instance cuts at an event are explicit too: rows agree to rounding."""
    ensemble = ring.simulate_many({"wall": [1.5] * 4}, step=0.01)
    assert ensemble.together == 4
    assert errors(ring, ensemble, step=0.01).max() < 1e-10
    assert all(counts[k]["events"] > 0 for k in range(4))
    assert counts[0]["explicit_steps"] > 0.9 * counts[0]["steps"]
