"""Poses that no hand can have, and the energy that ramp and limits of the loop create."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from held import Bench, prepare
from refusals import refusal

import bgc
from bgc.runtime.realtime.loop_records import forces_of, poses_of
from bgc.runtime.realtime.loop_report import Report
from bgc.runtime.realtime.servo_binding import End, Servo

WALL = """import haptics.coupling;
scene wall of VirtualWall {
  device operator = trace(file = "still.csv");
  drive x = operator.position.x;
  drive held = operator.held_force.x;
  drive operator.force = [force, 0 N, 0 N];
  set hand.stiffness = 2 kN/m;
  step 1 ms;
  observe x, force;
  run 5 s every 1 ms;
}
scene plain is wall { use hand.guard = NoGuard[1]; }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = prepare(tmp_path_factory.mktemp("faults"))
    (folder / "wall.bg").write_text(WALL)
    return folder


@pytest.fixture(scope="module")
def held(folder: Path) -> Any:
    return bgc.compile(folder / "held.bg")


@pytest.fixture(scope="module")
def wall(folder: Path) -> Any:
    return bgc.compile(folder / "wall.bg")


# --- poses --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "options", "words"),
    [
        ("fault=jump,size=0.05", {}, "0.05 m in 1 ms"),
        ("fault=jump,size=5", {}, "5 m in 1 ms"),
        ("fault=jump,size=1e30", {}, "1e+30 m outside its workspace"),
        ("fault=jump,size=1e30", {"workspace_margin": 0.0}, "1e+30 m in 1 ms"),
        ("fault=jump,size=10.2", {"max_speed": 0.0}, "0.2 m outside its workspace"),
    ],
)
def test_a_pose_that_no_hand_can_have_ends_the_loop_without_force(
    held: Any, folder: Path, fault: str, options: dict[str, float], words: str
) -> None:
    bench = Bench(held, folder)
    loop = bench.make(fault, **options)
    report = loop.run_here()
    assert report.end is End.JUMP and report.failed and report.refused == 1
    assert report.problem is not None and report.problem.code == "BG778"
    assert words in report.problem.message and "--max-speed" in report.problem.help
    assert bench.force == [0.0] * 3
    assert report.zero_after is not None and report.zero_after <= 1e-3
    assert not loop.forces()[1:, 2].any()  # nothing answers the pose


@pytest.mark.parametrize(
    ("fault", "options", "words"),
    [
        ("fault=jump,size=1e30,from=0", {}, "1e+30 m outside its workspace"),
        ("", {"max_speed": 0.5}, "a velocity of 0.7 m/s"),
        ("", {"max_turn_rate": 1.0}, "a turn rate of 2 rad/s"),
    ],
)
def test_a_first_pose_that_no_hand_can_have_starts_no_loop(
    held: Any, folder: Path, fault: str, options: dict[str, float], words: str
) -> None:
    found = refusal(Bench(held, folder).make, fault, **options)
    assert found.code == "BG706" and words in found.message


def test_what_a_hand_can_do_is_taken(held: Any, folder: Path) -> None:
    """The same step over a longer time, a device without news, and a limit of 0."""
    for fault, options in (
        ("fault=jump,size=4 mm", {}),
        ("fault=jump,size=0.0049", {}),
        ("fault=jump,size=1e30", {"max_speed": 0.0, "workspace_margin": 0.0}),
    ):
        report = Bench(held, folder).make(fault, 0.3, **options).run_here()
        assert report.end is End.DONE and report.refused == 0
    report = Bench(held, folder).make(duration=0.3).run_here()
    assert report.fastest == pytest.approx(0.7, rel=1e-3)
    (line,) = (line for line in report.lines() if line.startswith("fastest motion 0.7 m/s, "))
    assert line.endswith("samples without a new pose: 0, poses refused: 0")


def test_the_force_rises_at_a_rate_by_default(held: Any, folder: Path) -> None:
    """12 N in 5 ms; a fault writes zero at once."""
    loop = Bench(held, folder).make("fault=jump,size=0.0049", 0.3, parameters={"push": 1e3})
    loop.run_here()
    steps = np.linalg.norm(np.diff(loop.forces()[:, :3], axis=0), axis=1)
    assert steps.max() <= 12 / 5e-3 * 1e-3 * (1 + 1e-12)


# --- the ledger ---------------------------------------------------------------------------------


def work_of(loop: Any) -> np.ndarray:
    """The energy that the hand has received up to each sample, from the records, J."""
    x, force = poses_of(loop._records, 0)[:, 0], forces_of(loop._records, 0)[:, 0]
    return np.concatenate([[0.0], np.cumsum(force[:-1] * np.diff(x))])


def test_what_a_start_creates_is_taken_back(
    wall: Any, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hand presses a lossless wall while the force rises, and is let out at more of it."""
    found = {}
    for taken in (False, True):
        bench = Bench(wall, folder, "operator")
        with monkeypatch.context() as patch:
            if not taken:
                patch.setattr(Servo, "take_back", lambda *_: None)
            loop = bench.make(
                "fault=hand,from=0", 0.94, ramp=0.5, parameters={"hand.guard.damping": 0.0}
            )
        loop.run_here()
        found[taken] = loop.report, work_of(loop), poses_of(loop._records, 0)[:, 0]
        assert loop.report.given == pytest.approx(hand_work(bench), abs=1e-9)
    (loose, work, x), (report, bounded, out) = found[False], found[True]
    assert x[-1] < 0.0 and out[-1] < 0.0  # outside the wall: nothing is stored
    assert work[-1] == pytest.approx(loose.given, abs=1e-9) and loose.given > 0.02
    assert loose.owed == pytest.approx(loose.given, abs=1e-6)
    assert bounded[-1] < 1e-6 and report.given < 1e-6 and report.owed < 1e-6
    assert "taken back" in "".join(report.lines())


@pytest.mark.parametrize(
    ("end", "takes_back"), [(60.0, False), pytest.param(600.0, True, marks=pytest.mark.slow)]
)
def test_no_energy_comes_from_ramps_exchanges_resets_and_the_button(
    wall: Any, folder: Path, monkeypatch: pytest.MonkeyPatch, end: float, takes_back: bool
) -> None:
    """A lossless wall, a limited rate, a button let go every 7.3 s, a reset every 11.3 s.

    The loop's account is that of the hand, within 1e-6 J. Without taking back the hand receives
    more than it gives; with it, never.
    """
    if not takes_back:
        monkeypatch.setattr(Servo, "take_back", lambda *_: None)
    bench = Bench(wall, folder, "operator")
    given = {"hand.guard.damping": 0.0}
    seen: list[tuple[Report, float]] = []

    def exchange(at: float) -> None:
        seen.append((loop.report, hand_work(bench)))
        if at < end - 22.0:
            loop.exchange(wall, parameters=given, wait=False)
        bench.at(at + 11.3, lambda: exchange(at + 11.3))

    loop = bench.make(
        "fault=hand,from=0,letting=7.3",
        end,
        ramp=0.5,
        dead_man=2,
        max_force_rate=400.0,
        parameters=given,
        keep=1,
    )
    bench.at(11.3, lambda: exchange(11.3))
    report = loop.run_here()
    seen.append((report, hand_work(bench)))
    assert report.end is End.DONE and report.exchanges == len(seen) - 3 and report.limited > 50
    for present, work in seen:
        assert present.given == pytest.approx(work, abs=1e-6)
        assert (present.given < 1e-6 and present.owed < 1e-6) or not takes_back
    assert report.created > 0.1 and takes_back is (report.given < 1e-6)


def hand_work(bench: Bench) -> float:
    """The energy that the hand has received by its own account, J."""
    return ctypes.c_double.in_dll(bench.library, "hand_work").value
