"""Drivers in processes of their own: twelve faults and more, each with zero force at the hardware.

The hardware of `devices/standin.c` is a file, which keeps the force that any process wrote last.
Times are those of the model, in periods of 10 ms, so that a busy machine changes nothing.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from held import build_driver, prepare
from processes import started
from refusals import refusal

import bgc
from bgc.runtime.realtime import driver_process
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.servo_binding import End

PERIOD, STALE = 10e-3, 0.1
BGC = (sys.executable, "-c", "from bgc.runtime.cli import main; main()")
NAMES = "force writer opened closed fault_at fault_time zero_at first most".split()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = prepare(tmp_path_factory.mktemp("process"))
    build_driver("standin", folder)
    return folder


@pytest.fixture(scope="module")
def model(folder: Path) -> Any:
    return bgc.compile(folder / "held.bg")


class Unit:
    """A stand-in for a device; `state` is that of its hardware."""

    def __init__(self, folder: Path, tmp_path: Path) -> None:
        self.file, self._driver = tmp_path / "unit", folder / "standin.so"

    def device(self, fault: str) -> str:
        return f"{self._driver}(file={self.file}, fault={fault})"

    @property
    def state(self) -> dict[str, float]:
        return dict(zip(NAMES, np.fromfile(self.file).tolist(), strict=True))


@pytest.fixture
def unit(folder: Path, tmp_path: Path) -> Unit:
    return Unit(folder, tmp_path)


def run(model: Any, unit: Unit, fault: str, duration: float = 1.0) -> tuple[Any, list[int]]:
    """Run a loop with a fault; return it and the numbers of the processes that it had."""
    options = RealtimeOptions(ramp=0.05, burst=0.0, watchdog=0.0, policy="hold", stale=STALE)
    loop = model.realtime(
        duration, devices={"hand": unit.device(fault)}, options=options, step=PERIOD
    )
    found = [process.pid for one in loop._processes for process in one._processes]
    with loop:
        loop.wait()
    return loop, found


FAULTS = [  # fault, code, words, seconds until it is decided, who writes zero
    ("hang", "BG763", "`read` of its driver does not return", STALE, "another"),
    ("hang_write", "BG763", "`write` of its driver does not return", STALE, "another"),
    ("segv", "BG706", "SIGSEGV in `read` of its driver", 0.0, "the first"),
    ("segv_write", "BG706", "SIGSEGV in `write` of its driver", 0.0, "the first"),
    ("abrt", "BG706", "SIGABRT in `read` of its driver", 0.0, "the first"),
    ("fpe", "BG706", "SIGFPE in `read` of its driver", 0.0, "the first"),
    ("killed", "BG706", "the process of its driver has ended", 0.0, "another"),
    ("exit", "BG706", "the process of its driver has ended", 0.0, "another"),
    ("nan", "BG762", "not finite", 0.0, "the first"),
    ("infinite", "BG762", "not finite", 0.0, "the first"),
    ("jump, size=0.07", "BG778", "0.06 m in", 0.0, "the first"),
    ("jump, size=5", "BG778", "4.9 m outside its workspace", 0.0, "the first"),
    ("jump, size=1e30", "BG778", "1e+30 m outside its workspace", 0.0, "the first"),
    ("stuck", "BG763", "nothing new for 0.1 s", STALE, "the first"),
    ("freeze, delay=0.5", "BG763", "`read` of its driver does not return", STALE, "another"),
    ("unplugged", "BG706", "the cable is out", 0.0, "the first"),
]


@pytest.mark.parametrize(
    ("fault", "code", "words", "limit", "writer"), FAULTS, ids=[f[0] for f in FAULTS]
)
def test_a_fault_of_a_driver_ends_in_zero_force(
    model: Any, unit: Unit, fault: str, code: str, words: str, limit: float, writer: str
) -> None:
    loop, processes = run(model, unit, fault, 60.0)
    report, found = loop.report, unit.state
    assert report.failed and report.problem.code == code
    assert words in report.problem.message
    assert report.time - found["fault_time"] <= limit + 2.001 * PERIOD
    assert found["most"] > 0.0 and found["force"] == 0.0
    assert report.zero_after is not None and not report.unsettled
    assert (found["writer"] == found["first"]) is (writer == "the first")
    for process in processes:
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)


@pytest.mark.parametrize("fault", ["none", "freeze, delay=0.05", "hang_close"])
def test_what_ends_no_loop(model: Any, unit: Unit, fault: str) -> None:
    """A quiet device; one that freezes for 50 ms, which is counted; one that does not close."""
    loop, _ = run(model, unit, fault)
    found = unit.state
    assert loop.report.end is End.DONE and loop.report.problem is None
    assert found["most"] > 0.0 and found["force"] == 0.0 and found["writer"] == found["first"]
    assert found["closed"] == (fault != "hang_close")
    assert loop.report.no_news >= 3 or "freeze" not in fault
    assert loop.latest()["x"] == 0.01


def test_the_passivity_of_a_loop_counts_how_early_a_pose_is_read(model: Any, unit: Unit) -> None:
    """A fifth of a period of 1 ms as a delay, and 0.2 ms of longer ones."""
    for step, lag in ((1e-3, 0.2), (PERIOD, 0.02)):
        loop = model.realtime(1.0, devices={"hand": unit.device("none")}, step=step)
        (coupling,) = loop.couplings()
        loop.stop(at_once=True)
        assert coupling.lag == pytest.approx(lag)
        assert f"with {lag:.2g} samples of delay" in coupling.line()


def test_a_device_that_nobody_can_reach_is_said(model: Any, unit: Unit) -> None:
    """Its driver is killed and does not open again: BG759, and no time of zero force."""
    loop, _ = run(model, unit, "killed_for_good", 60.0)
    report = loop.report
    assert report.problem.code == "BG706" and report.unsettled and report.zero_after is None
    assert "BG759" in [warning.code for warning in report.warnings()]


def test_a_driver_that_does_not_open_is_refused(
    model: Any, unit: Unit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driver_process, "_OPENING", 0.3)
    monkeypatch.setattr(driver_process, "_FIRST_POSE", 0.3)
    for fault, words in (
        ("hang_open", "a call of `open` of its driver does not return"),
        ("segv_open", "a signal (11) in `open` of its driver"),
        ("hang, from=-1", "a call of `read` of its driver does not return"),
        ("none, missing=1", "no hardware"),
    ):
        found = refusal(model.realtime, devices={"hand": unit.device(fault)})
        unit.file.unlink(missing_ok=True)
        assert found.code == "BG074" and words in found.message


@pytest.mark.parametrize("fault", ["hang", "hang_write", "hang_close", "none"])
def test_a_command_ends_with_zero_force_whatever_its_driver_does(
    folder: Path, unit: Unit, fault: str
) -> None:
    """SIGTERM, with limits that would let the loop go on for ever and a slow ramp."""
    device = ["--device", f"hand={unit.device(fault)}", "--ramp", "20 s", "--stale", "0 s"]
    command = [*BGC, "haptic", str(folder / "held.bg"), *device, "--burst", "0", "--quiet"]
    with started(command) as process:
        waited_for = "fault_at" if fault in ("hang", "hang_write") else "force"
        while not unit.file.exists() or unit.file.stat().st_size == 0 or not unit.state[waited_for]:
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        assert process.wait(60) == 128 + signal.SIGTERM
    assert unit.state["force"] == 0.0


def test_a_device_in_python_that_does_not_return_ends_the_loop(model: Any) -> None:
    release = threading.Event()

    class Hanging:
        def __init__(self) -> None:
            self.calls = 0

        def read(self) -> dict[str, Any]:
            self.calls += 1
            if self.calls > 5:
                release.wait(60.0)
            return {"position": [0.01, 0.0, 0.0]}

    options = RealtimeOptions(watchdog=0.0, burst=0.0)
    with model.realtime(60.0, devices={"hand": Hanging()}, options=options) as loop:
        report = loop.wait()
    release.set()
    assert report.end is End.STOPPED
    (warning,) = [found for found in loop.warnings if found.code == "BG779"]
    assert "a call has not returned for 0.1 s" in warning.message
