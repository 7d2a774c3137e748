"""Fixed steps that are subdivided where their error is too large, within a budget."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bgc.language.methods import METHODS

DIVISIBLE = tuple(method.name for method in METHODS.values() if method.embedded_order)
STIFF = tuple(m.name for m in METHODS.values() if m.embedded_order and m.family.jacobian)
WHOLE = tuple(method.name for method in METHODS.values() if not method.embedded_order)
ENDS = np.linspace(0.1, 2.0, 20)


def transient(c_model: Any, method: str, **options: float) -> Any:
    """y' = -100 (y - cos t) - sin t from y = 2, which is at cos t within a step of 0.1 s."""
    instance = c_model("prothero_robinson")
    instance.set(p0=-1e2)
    instance.start(method, step=0.1, **options)
    instance.state[0] = 2.0
    assert instance.call("bgc_restart") == "OK"
    return instance


@pytest.mark.parametrize("method", DIVISIBLE)
@pytest.mark.parametrize("accounts", [False, True])
def test_a_step_whose_error_is_small_has_the_same_bits(
    c_model: Any, method: str, accounts: bool
) -> None:
    runs = []
    for options in ({}, {"substeps": 8, "rtol": 0.5}):
        stop = c_model("stop")
        stop.start(method, accounts, step=0.01, **options)
        runs.append((stop.finish(ENDS), stop.counts))
    (whole, _), (divisible, counts) = runs
    assert np.array_equal(whole, divisible)
    assert (counts.subdivided, counts.over_budget, counts.rejected) == (0, 0, 0)
    assert counts.most_attempts <= 1
    assert counts.events > 3  # which do not count as attempts


@pytest.mark.parametrize("method", STIFF)
def test_the_first_step_is_divided_and_the_later_ones_are_not(c_model: Any, method: str) -> None:
    # Steps grow within the budget until the transient is over.
    divided = transient(c_model, method, substeps=64, rtol=1e-2)
    rows = divided.finish(ENDS)
    counts = divided.counts
    assert counts.subdivided >= 1 and counts.over_budget == 0
    assert 4 < counts.most_attempts <= 64
    assert np.abs(rows[:, 0] - np.cos(ENDS)).max() < 1e-2
    smooth = 20 - counts.subdivided
    assert counts.steps + counts.rejected <= smooth + counts.subdivided * counts.most_attempts


@pytest.mark.parametrize("method", DIVISIBLE)
@pytest.mark.parametrize("substeps", [2, 3, 5, 17])
def test_no_step_takes_more_attempts_than_its_budget(
    c_model: Any, method: str, substeps: int
) -> None:
    tight = transient(c_model, method, substeps=substeps, rtol=1e-12)
    for end in ENDS:
        before = tight.counts.steps + tight.counts.rejected, tight.counts.rhs
        if tight.run([end])[0] == "NOT_FINITE":  # explicit methods are unstable
            assert method in ("rk4", "heun")
            break
        taken = tight.counts.steps + tight.counts.rejected - before[0]
        assert 1 <= taken <= substeps + 1
        assert tight.counts.rhs - before[1] <= (substeps + 1) * 4 + 1
    assert tight.counts.most_attempts <= substeps + 1
    assert tight.counts.subdivided >= tight.counts.over_budget > 0
    assert tight.counts.largest_excess > 1.0


def test_the_largest_excess_and_its_time_are_reported(c_model: Any) -> None:
    tight = transient(c_model, "ros34prw", substeps=2, rtol=1e-2)
    tight.finish(ENDS)
    assert tight.counts.over_budget == 1
    assert tight.counts.excess_time == 0.0
    assert 1.0 < tight.counts.largest_excess < 1e4


@pytest.mark.parametrize("method", DIVISIBLE)
def test_the_quick_check_of_a_first_attempt_agrees_with_its_error(
    c_model: Any, method: str
) -> None:
    """The counts report the error of an attempt of 0.05 s that the budget forces."""

    def run(step: float, rtol: float) -> Any:
        instance = c_model("prothero_robinson")
        instance.set(p0=-10.0)
        instance.start(method, step=step, substeps=2, rtol=rtol)
        instance.state[0] = 2.0
        assert instance.call("bgc_restart") == "OK"
        instance.finish([step])
        return instance

    forced = run(0.1, 1e-9)
    assert forced.counts.excess_time == 0.0
    for part, subdivided in ((1.01, 0), (0.99, 1)):
        rtol = part * 1e-9 * forced.counts.largest_excess
        assert run(0.05, rtol).counts.subdivided == subdivided


@pytest.mark.parametrize("method", DIVISIBLE)
def test_steps_end_on_the_grid(c_model: Any, method: str) -> None:
    stop = c_model("stop")
    stop.start(method, step=0.1, substeps=7, rtol=1e-6)
    for k in range(1, 21):
        stop.finish([k / 10])
        assert stop.time == k / 10


@pytest.mark.parametrize("method", ["ros34prw", "ros23", "rk4"])
def test_events_within_subdivided_steps_are_located(c_model: Any, method: str) -> None:
    exact = c_model("stop")
    exact.start("rodas5p", rtol=1e-12, atol=1e-13)
    errors = []
    for options in ({}, {"substeps": 50, "rtol": 1e-7}):
        stop = c_model("stop")
        stop.start(method, step=0.1, **options)
        errors.append(np.abs(stop.finish(ENDS) - exact.finish(ENDS)).max())
        assert stop.counts.events == exact.counts.events
        exact.start("rodas5p", rtol=1e-12, atol=1e-13)
    assert errors[1] < min(1e-4, 0.02 * errors[0])


@pytest.mark.parametrize("method", DIVISIBLE)
@pytest.mark.parametrize("keep", [1, 3])
def test_calls_and_saving_in_between_do_not_change_the_bits(
    c_model: Any, method: str, keep: int
) -> None:
    options = {"step": 0.1, "substeps": 6, "rtol": 1e-5, "keep": keep}
    times = np.linspace(0.013, 2.0, 61)  # within sub-steps, too
    stop = c_model("stop")
    stop.start(method, **options)
    whole = stop.finish(times)
    assert stop.counts.subdivided > 0
    parts = c_model("stop")
    parts.start(method, **options)
    rows = []
    for time in times:
        rows.append(parts.finish([time])[0])
        memory = parts.save()
        parts = c_model("stop")
        assert parts.restore(memory) == "OK"
    assert np.array_equal(whole, np.array(rows))


@pytest.mark.parametrize("method", WHOLE)
def test_methods_without_an_embedded_solution_for_it_refuse(c_model: Any, method: str) -> None:
    oscillator = c_model("stop")
    assert oscillator.options(method, step=0.1, substeps=8) == "BAD_ARGUMENT"
    assert oscillator.options(method, step=0.1, substeps=1) == "OK"


def test_a_negative_budget_is_refused(c_model: Any) -> None:
    assert c_model("stop").options("ros34prw", step=0.1, substeps=-1) == "BAD_ARGUMENT"


def test_a_step_that_overflows_is_divided(c_model: Any) -> None:
    """A root of a negative number at a stage of the whole step, not of shorter ones."""
    for substeps, status in ((1, "NOT_FINITE"), (8, "OK")):
        instance = c_model("draining")
        instance.start("ros34prw", step=0.16, substeps=substeps, rtol=1e-2)
        assert instance.run([0.16])[0] == status
