"""`bgc trade` on a scene that follows a recorded hand."""

from __future__ import annotations

from pathlib import Path

import pytest
from model_files import model_text
from trades import codes, quick, written

import bgc
from bgc.runtime.trade.trade_tables import unfinished

pytestmark = pytest.mark.usefixtures("measured")

FOLLOWER = model_text("trade_devices_follower")


def test_all_steps_that_divide_the_scenes_see_the_same_samples(tmp_path: Path) -> None:
    (tmp_path / "hand.csv").write_text("time,x,y,z\n0,0,0,0\n1,1,0,0\n")
    path = written(tmp_path, FOLLOWER)
    found = bgc.trade(
        path, solvers=["ros34prw", "rodas5p"], steps=[0.02, 0.01, 0.005, 0.0025], keeps=[1]
    )
    errors = {r.configuration.step: found.target.error(r) for r in found.measurements if r.done}
    assert errors[0.01] / errors[0.0025] == pytest.approx(4**3, rel=0.3)  # the method's order
    assert errors[0.02] > 100 * errors[0.01]  # fewer samples are another input
    late = {r.configuration.step: found.target.samples(r) for r in found.measurements}
    assert late == {0.02: False, 0.01: True, 0.005: True, 0.0025: True, 0.0: True}
    assert found.recommended is not None and found.recommended.step <= 0.01


def test_another_motion_of_the_hand_is_another_question(tmp_path: Path) -> None:
    trace = tmp_path / "hand.csv"
    trace.write_text("time,x,y,z\n0,0,0,0\n1,1,0,0\n")
    path = written(tmp_path, FOLLOWER.replace("step 10 ms;", "step 10 ms; solver auto;"))
    bgc.trade(path, solvers=["ros34prw"], steps=[0.01], keeps=[1])
    assert codes(bgc.compile(path).simulate()) == []
    trace.write_text("time,x,y,z\n0,0,0,0\n1,2,0,0\n")
    assert codes(bgc.compile(path).simulate()) == ["BG090"]


def test_what_cvode_does_not_serve_is_said_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "hand.csv").write_text("time,x,y,z\n0,0,0,0\n1,1,0,0\n")
    found = quick(written(tmp_path, FOLLOWER), solvers=["cvode"])
    (line,) = unfinished(found.measurements)
    assert line[:3] == ("cvode", "refused", "")
    assert line[3].startswith("BG047")
