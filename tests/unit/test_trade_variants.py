"""`bgc trade` on changes of a scene: each is held against the scene as it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from model_files import model_text
from trades import legend_of, quick, written

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.scenes.variants import Change
from bgc.runtime.activity.activity import activity_report
from bgc.runtime.activity.simplifications import stored_variants
from bgc.runtime.trade.work_precision import plot_trade

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("measured")]

MOUNTED = model_text("trade_variants_mounted")


def test_variants_are_measured_against_the_scene_as_it_is(tmp_path: Path) -> None:
    found = quick(
        written(tmp_path, MOUNTED), variants=["*t", "left"], solvers=["rodas5p"], rtols=[1e-7]
    )
    by_variant = {r.configuration.variant: found.target.error(r) for r in found.measurements}
    assert set(by_variant) == {"", "left=Stiff, right=Stiff", "left=Stiff"}
    one = np.sqrt(8.0), np.sqrt(8.04), np.sqrt(8.08)
    times = np.linspace(0, 2, 1001)
    speeds = [np.sin(w * times) / w for w in one]
    for variant, speed in (("left=Stiff", speeds[1]), ("left=Stiff, right=Stiff", speeds[2])):
        expected = np.max(np.abs(speed - speeds[0])) / 1e-3
        assert by_variant[variant] == pytest.approx(expected, rel=1e-3)
    assert legend_of(plot_trade(found))[:2] == ["rodas5p", "a variant of the model"]


ACTIVITY = Path(__file__).parents[1] / "models" / "activity.bg"


def test_what_activity_finds_that_a_scene_can_do_without_is_a_variant(tmp_path: Path) -> None:
    given: dict[str, Any] = {"solvers": ["rodas5p"], "rtols": [1e-6], "duration": 1.0}
    report = activity_report(bgc.compile(ACTIVITY, "train"), negligible=0.05)
    assert report.variants
    found = bgc.trade(ACTIVITY, "train", variants=["activity"], **given)
    by_variant = {r.configuration.changes: r for r in found.measurements}
    assert set(by_variant) == {(), *report.variants}
    joined = (Change("link", "Joined"),)
    (trial,) = (trial for trial in report.trials if trial.changes == joined)
    assert found.target.error(by_variant[joined]) == pytest.approx(trial.error, rel=0.02)


def test_activity_is_asked_where_nothing_is_stored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, MOUNTED)
    assert stored_variants(bgc.compile(path)) is None
    quick(path, variants=["activity"])
    assert stored_variants(bgc.compile(path)) is not None


def test_lines_of_a_scene_are_a_variant(tmp_path: Path) -> None:
    text = MOUNTED.replace("block : I(1 kg)", "param m = 1 kg; block : I(m)")
    lines = "use left = Stiff; set m = 2 kg"
    path = written(tmp_path, text)
    given: dict[str, Any] = {"solvers": ["rodas5p"], "rtols": [1e-7]}
    found = bgc.trade(path, variants=[lines], parameters={"m": 1}, **given)
    (row,) = (row for row in found.measurements if row.configuration.changes)
    one, other = np.sqrt(8.0), np.sqrt(8.04 / 2)
    times = np.linspace(0, 2, 1001)
    expected = np.sin(other * times) / (2 * other) - np.sin(one * times) / one
    assert row.errors[0] == pytest.approx(np.max(np.abs(expected)), rel=1e-3)
    with pytest.raises(BgError) as caught:
        bgc.trade(path, variants=["left="], **given)
    assert [d.code for d in caught.value.diagnostics] == ["BG064"]


BARE = """
model Bare is Mount { param k : N/m; port p in; spring : C(stiffness = k); p -> spring; }
"""


def test_a_type_that_does_not_fit_as_it_is_is_a_row_with_its_reason(tmp_path: Path) -> None:
    found = quick(written(tmp_path, MOUNTED + BARE), variants=["left"])
    refused = [row for row in found.measurements if row.status == "refused"]
    assert [row.configuration.variant for row in refused] == ["left=Bare"]
    assert "`k` has no value" in refused[0].message


def test_a_slip_in_lines_is_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(BgError, match="Nothing"):
        quick(written(tmp_path, MOUNTED), variants=["left = Nothing"])


def test_numbers_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    for wrong in ({"keeps": [2.5]}, {"keeps": [0]}, {"steps": [-1.0]}, {"budget": 0.0}):
        with pytest.raises(BgError) as caught:
            quick(path, **wrong)
        assert [d.code for d in caught.value.diagnostics] == ["BG066"]


def test_explicit_methods_are_tried_anew_on_what_is_no_longer_stiff() -> None:
    found = bgc.trade(
        ACTIVITY,
        "train",
        parameters={"link.stiffness": 1e7},
        variants=["use link = Joined"],
        solvers=["rodas5p", "rk4"],
        rtols=[1e-6],
        steps=[0.01],
    )
    rows = [r for r in found.measurements if r.configuration.solver == "rk4"]
    assert {(found.target.accurate(r), bool(r.configuration.changes)) for r in rows} == {
        (False, False),
        (True, True),
    }
    assert "With `use link = Joined;`, `solver " in found.sentence
