"""The method `switching`: explicit steps where nothing is stiff, and the way back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bgc
from bgc.language.methods import SWITCHING, SWITCHING_FIXED, default_method
from bgc.runtime.results.summary import summarise
from bgc.runtime.trade.trade import adaptive_and_fixed

MODELS = Path(__file__).parents[1] / "models"
TIMES = np.linspace(0.0, 60.0, 121)


def test_it_is_explicit_but_for_the_stiff_part_of_a_run(c_model: Any) -> None:
    waking = c_model("waking")
    waking.start(None, rtol=1e-6)  # the default of a model with an explicit cost
    parts = {}
    for name, grid in (("before", TIMES[:40]), ("stiff", TIMES[40:80]), ("after", TIMES[80:])):
        steps, explicit = waking.counts.steps, waking.counts.explicit_steps
        rows = waking.finish(grid)
        np.testing.assert_allclose(rows[:, 2], np.cos(grid), atol=1e-4)
        taken = waking.counts.steps - steps
        parts[name] = (taken, waking.counts.explicit_steps - explicit)
    assert parts["before"][1] > 0.7 * parts["before"][0]
    assert parts["stiff"][1] < 300  # explicit steps alone: 600,000
    assert parts["after"][1] > 0.4 * parts["after"][0]
    assert waking.counts.method_changes >= 3
    assert waking.counts.jacobians < 0.7 * waking.counts.steps


def test_a_run_that_is_stiff_has_the_bits_of_the_implicit_method(c_model: Any) -> None:
    rows = []
    for name in ("rodas5p", SWITCHING):
        waking = c_model("waking")
        waking.set(p1=-10.0, p2=1000.0)
        waking.start(name, rtol=1e-6)
        rows.append(waking.finish(TIMES))
        assert waking.counts.explicit_steps == waking.counts.method_changes == 0
    assert rows[0].tobytes() == rows[1].tobytes()


class _Run:
    """Counts of a run of `springs`, and `work`: the number of implicit steps that cost as much."""

    def __init__(self, c_model: Any, method: str, rtol: float, **values: float) -> None:
        springs = c_model("springs")
        springs.set(**values)
        springs.start(method, rtol=rtol)
        springs.finish(TIMES)
        counts = springs.counts
        attempts = counts.steps + counts.rejected - counts.factorisations
        self.work = counts.factorisations + 0.3 * attempts
        self.explicit, self.implicit = counts.explicit_steps, counts.steps - counts.explicit_steps
        self.changes = counts.method_changes


@pytest.mark.parametrize(
    ("w", "rtol"),
    [(w, rtol) for w in (3.0, 10.0, 1e4) for rtol in (1e-3, 1e-4, 1e-6) if w > 3 or rtol > 1e-5],
)
def test_a_fast_motion_that_is_not_excited_costs_nothing(
    c_model: Any, w: float, rtol: float
) -> None:
    run = _Run(c_model, SWITCHING, rtol, p0=w)
    assert run.changes == 0
    assert run.work == _Run(c_model, "rodas5p", rtol, p0=w).work


def test_a_motion_that_wanted_steps_nearly_resolve_is_explicit(c_model: Any) -> None:
    """The steps that the rest of the motion wants are a little longer than its period over 2 pi."""
    run = _Run(c_model, SWITCHING, 1e-6, p0=3.0)
    assert run.work < 0.6 * _Run(c_model, "rodas5p", 1e-6, p0=3.0).work
    assert run.work < 1.15 * _Run(c_model, "dopri5", 1e-6, p0=3.0).work


@pytest.mark.parametrize(("rtol", "most"), [(1e-3, 0.55), (1e-4, 0.55), (1e-6, 0.6)])
@pytest.mark.parametrize("w", [10.0, 100.0])
def test_a_fast_motion_that_tolerances_resolve_is_explicit(
    c_model: Any, w: float, rtol: float, most: float
) -> None:
    """Trials of the implicit method, each later than the one before, take few of the steps."""
    run = _Run(c_model, SWITCHING, rtol, p0=w, p1=0.3)
    assert run.work < most * _Run(c_model, "rodas5p", rtol, p0=w, p1=0.3).work
    assert run.implicit < 0.03 * run.explicit
    assert run.changes < 0.02 * run.explicit


@pytest.mark.parametrize(
    ("w", "b", "most"), [(30.0, 0.3, 0.85), (100.0, 3.0, 0.85), (300.0, 3.0, 0.65)]
)
@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-6])
def test_the_run_returns_where_a_fast_motion_has_decayed(
    c_model: Any, w: float, b: float, most: float, rtol: float
) -> None:
    run = _Run(c_model, SWITCHING, rtol, p0=w, p1=0.3, p2=b)
    assert run.work < most * _Run(c_model, "rodas5p", rtol, p0=w, p1=0.3, p2=b).work
    assert run.explicit > 80
    assert run.implicit > 80  # of the slow motion alone
    assert run.changes < 20


def test_the_run_returns_where_a_fast_motion_has_decayed_slowly(c_model: Any) -> None:
    """At loose tolerances the implicit method damps it; explicit steps follow it to the end."""
    values = {"p0": 300.0, "p1": 0.3, "p2": 0.3}
    run = _Run(c_model, SWITCHING, 1e-3, **values)
    assert run.work < 0.8 * _Run(c_model, "rodas5p", 1e-3, **values).work


def test_entries_that_cancel_do_not_count_as_fast(c_model: Any) -> None:
    """Steps are chosen by the eigenvalues, here -i and i, not by the entries, which are 10."""
    cancelling = c_model("cancelling")
    cancelling.start(SWITCHING, rtol=1e-6)
    cancelling.finish(TIMES)
    counts = cancelling.counts
    assert counts.explicit_steps > 0.9 * counts.steps


@pytest.mark.parametrize(
    ("d", "options", "explicit"), [(0.3, {}, False), (0.0, {"max_step": 0.008}, True)]
)
def test_short_steps_for_rows_are_explicit_where_they_are_stable(
    c_model: Any, d: float, options: dict[str, float], explicit: bool
) -> None:
    """An explicit step of 0.58 of the cost does not pay if it is shorter than the implicit one."""
    costly = c_model("costly")
    costly.set(p0=100.0, p1=d)
    costly.start(SWITCHING, rtol=1e-9, **options)
    costly.finish(TIMES[: 4 if d else 20])
    assert (costly.counts.explicit_steps > 0.9 * costly.counts.steps) == explicit
    assert explicit or costly.counts.method_changes == 0


def test_a_restored_run_goes_on_with_the_same_method(c_model: Any) -> None:
    waking, other = c_model("waking"), c_model("waking")
    waking.start(SWITCHING, rtol=1e-6)
    waking.finish(TIMES[:20])
    assert waking.counts.explicit_steps > 0
    assert other.restore(waking.save()) == "OK"
    assert other.finish(TIMES[20:]).tobytes() == waking.finish(TIMES[20:]).tobytes()


def test_it_does_not_change_without_an_explicit_cost(c_model: Any) -> None:
    rows = []
    for name in ("rodas5p", SWITCHING):
        kaps = c_model("kaps")
        kaps.start(name, rtol=1e-6)
        rows.append(kaps.finish(TIMES[:20]))
    assert rows[0].tobytes() == rows[1].tobytes()


@pytest.mark.parametrize("b", [0.0, 30.0, 99.0])
def test_fixed_steps_are_explicit_where_they_resolve_the_fastest_motion(
    c_model: Any, b: float
) -> None:
    """Up to 0.35 over the frequency of 100 rad/s, whatever its damping is."""
    explicit, short, long = [], c_model("springs"), c_model("springs")
    for springs, step in ((short, 0.0034), (long, 0.0036)):
        springs.set(p0=100.0, p2=b)
        springs.start(SWITCHING_FIXED, step=step)
        rows = springs.finish(np.linspace(0.0, 2000 * step, 11))
        explicit.append(springs.counts.explicit_steps)
    assert explicit[0] > 1950
    assert explicit[1] == 0
    long.start("ros34prw", step=0.0036)
    assert long.finish(np.linspace(0.0, 7.2, 11)).tobytes() == rows.tobytes()


@pytest.mark.parametrize("sharp", [4.0, 1e5])
def test_fixed_steps_are_implicit_in_the_stiff_part_of_a_run(c_model: Any, sharp: float) -> None:
    """Also where the stiffness comes at once: the implicit method takes that step again."""
    waking, other = c_model("waking"), c_model("waking")
    waking.set(p3=sharp, p4=1e-7)  # apart, so that unstable steps show
    waking.start(SWITCHING_FIXED, step=0.01, substeps=1)
    parts, rows = [], []
    for grid in (TIMES[:39], TIMES[39:83], TIMES[83:]):
        before = waking.counts.explicit_steps
        rows.append(waking.finish(grid))
        parts.append(waking.counts.explicit_steps - before)
        assert other.restore(waking.save()) == "OK"
    np.testing.assert_allclose(np.vstack(rows)[:, 2], np.cos(TIMES), atol=1e-6)
    assert parts[0] > 0.95 * 1900
    assert parts[1] < 0.15 * 2200
    assert parts[2] > 0.5 * 1900
    later = TIMES + 60.0
    assert other.finish(later).tobytes() == waking.finish(later).tobytes()


@pytest.mark.parametrize("reuse", [True, False])
def test_the_last_stage_of_dopri5_is_the_first_of_the_next_step(c_model: Any, reuse: bool) -> None:
    """f is evaluated six times a step, and rows or restarts in between change no bit."""
    waking = c_model("waking")
    waking.start("dopri5", rtol=1e-6)
    if reuse:
        rows = waking.finish(TIMES[:20])
        counts = waking.counts
        assert counts.rhs <= 6 * (counts.steps + counts.rejected) + 3
    else:
        rows = np.vstack([waking.finish(TIMES[k : k + 1]) for k in range(20)])
    again = c_model("waking")
    again.start("dopri5", rtol=1e-6)
    assert again.finish(TIMES[:20]).tobytes() == rows.tobytes()


def test_a_mechanism_chooses_explicit_steps_by_itself() -> None:
    model = bgc.compile(MODELS / "ivp" / "five_bodies.bg")
    assert 0.1 < model.library.explicit_cost < 0.6
    run = model.simulate(rtol=1e-7)
    reference = model.simulate(solver="rodas5p", rtol=1e-10)
    assert run.solver == SWITCHING
    assert run.counts["explicit_steps"] > 0.5 * run.counts["steps"]
    assert run.counts["explicit_steps"] < run.counts["steps"]
    for name in run.columns:
        spread = np.ptp(reference[name]) or 1.0
        assert np.abs(run[name] - reference[name]).max() < 1e-4 * spread
    assert "of them explicit" in summarise(run)
    adaptive, fixed = adaptive_and_fixed(model, None)
    assert SWITCHING in adaptive and SWITCHING_FIXED in fixed
    assert model.simulate(0.01, step=1e-3).solver == SWITCHING_FIXED


def test_a_small_or_implicit_model_keeps_its_default() -> None:
    model = bgc.compile(MODELS / "duffing.bg")
    assert model.library.explicit_cost == 0.0
    assert model.simulate().solver == "rodas5p"
    adaptive, fixed = adaptive_and_fixed(model, None)
    assert SWITCHING not in adaptive and SWITCHING_FIXED not in fixed
    assert default_method(fixed=False, changes=True) == SWITCHING
    assert default_method(fixed=True, changes=True) == SWITCHING_FIXED
