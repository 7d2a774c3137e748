"""Advice of a run on its steps: rounding that limits them, explicit methods that suffice."""

from __future__ import annotations

import numpy as np
import pytest

from bgc.runtime.results.summary import summarise

NOT_STIFF = [("arms", "falling", 1e-6), ("ivp/pleiades", "ivp", 1e-9)]
STIFF = [("valve_cylinder", "out_and_in"), ("ivp/van_der_pol", "ivp"), ("ivp/plate", "ivp")]


# --- rounding (BG731) ---------------------------------------------------------------------------


def test_rounding_of_a_fine_mesh_is_reported_where_it_limits_the_steps(load) -> None:
    mesh = load("fine_mesh", "settle")
    coarse, fine = (mesh.simulate(rtol=rtol) for rtol in (1e-8, 1e-10))
    assert not coarse.warnings
    (warning,) = fine.warnings
    assert warning.code == "BG731"
    assert "of 6 steps that were examined" in warning.message
    # It took more than the 1.6 times as many steps of a method of order 5, for the same digits.
    assert fine.counts["steps"] > 4 * coarse.counts["steps"]
    assert fine["middle"][-1] == pytest.approx(coarse["middle"][-1], rel=1e-8)


@pytest.mark.parametrize(
    ("name", "solver"),
    [(f"ivp/{name}", "rodas5p") for name in ("plate", "crane", "beam", "pleiades")]
    + [("ivp/pleiades", "dopri5")],
)
def test_tight_tolerances_alone_are_not_blamed_on_rounding(load, name, solver) -> None:
    result = load(name, "ivp").simulate(rtol=1e-9, solver=solver)
    assert result.counts["rounding_samples"] >= 2
    assert result.counts["rounding"] == 0


def test_the_samples_change_neither_results_nor_counts(load) -> None:
    """Steps are examined every 256 steps: rows before and after are those of one run."""
    mesh = load("ivp/pleiades", "ivp")
    result = mesh.simulate(rtol=1e-9, solver="rodas5p")
    counts = result.counts
    assert counts["rounding_samples"] >= 2
    # 8 stages in each attempt, whose first f is that of the attempt before where it was rejected.
    attempts = counts["steps"] + counts["rejected"]
    assert 7 * attempts < counts["rhs"] <= 8 * attempts + 2
    assert counts["factorisations"] == attempts


# --- advice -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "scene", "rtol"), NOT_STIFF)
def test_an_explicit_method_is_advised_where_it_takes_less_work(load, name, scene, rtol) -> None:
    model = load(name, scene)
    run = model.simulate(rtol=rtol, solver="rodas5p")
    assert run.faster == "dopri5"
    assert "nothing in it is stiff: `--solver dopri5`" in summarise(run)
    other = model.simulate(solver="dopri5", rtol=rtol)
    assert other.counts["steps"] + other.counts["rejected"] < 1.3 * run.counts["steps"]
    assert other.faster == ""


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize(("name", "scene"), STIFF)
def test_it_is_not_where_something_is_stiff(load, name, scene, rtol) -> None:
    assert load(name, scene).simulate(solver="rodas5p", rtol=rtol).faster == ""


def test_fixed_steps_that_resolve_every_motion_are_advised_an_explicit_method(load) -> None:
    arms = load("arms", "falling")
    run = arms.simulate(1.0, solver="ros34prw", step=1e-4)
    assert run.faster == "rk4"
    reference = arms.simulate(1.0, solver="rodas5p", rtol=1e-11)
    other = arms.simulate(1.0, solver="rk4", step=1e-4)
    for name in reference:
        exact = reference[name]
        assert np.abs(other[name] - exact).max() <= np.abs(run[name] - exact).max() + 1e-9
    assert arms.simulate(1.0, solver="ros34prw", step=0.05).faster == ""
