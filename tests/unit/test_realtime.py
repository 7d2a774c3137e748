"""The servo loop on a clock of its own: policies, limits, injected faults, records.

The driver `devices/faulty.c` injects the faults and holds the clock, which only the loop and the
faults move, so that every figure here is the same on any machine.
"""

from __future__ import annotations

import ctypes
import io
import re
import resource
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from held import DAMPING, SCENE, STIFFNESS, Bench, prepare
from manual import whole_manual
from refusals import refusal, refusals
from rich.console import Console

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source
from bgc.driver import check_source, compile_scene
from bgc.grammar.format import format_source
from bgc.options import Options
from bgc.runtime.cli.realtime import shown as view_of
from bgc.runtime.realtime import loop as loop_module
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.loop_records import forces_of
from bgc.runtime.realtime.servo_binding import POLICIES, End


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return prepare(tmp_path_factory.mktemp("realtime"))


@pytest.fixture(scope="module")
def model(folder: Path) -> Any:
    return bgc.compile(folder / "held.bg")


@pytest.fixture
def bench(model: Any, folder: Path) -> Bench:
    return Bench(model, folder)


def wanted_force(time: np.ndarray) -> np.ndarray:
    return -STIFFNESS * 0.1 * np.sin(7 * time) - DAMPING * 0.7 * np.cos(7 * time)


def test_a_quiet_loop_keeps_its_periods(bench: Bench) -> None:
    loop = bench.make(ramp=0.2)
    report = loop.run_here()
    assert report.end is End.DONE and report.problem is None
    assert (report.samples, report.missed, report.overruns, report.behind) == (1001, 0, 0, 0.0)
    np.testing.assert_allclose(loop.time, np.arange(1001) * 1e-3, atol=1e-12)
    # The force rises in 0.2 s, and falls in the last 0.2 s.
    gain = np.minimum(1.0, np.minimum(np.arange(1, 1002), np.arange(1000, -1, -1)) * 1e-3 / 0.2)
    forces = loop.forces()
    wanted = gain * wanted_force(loop.time)
    np.testing.assert_allclose(forces[1:, 0], wanted[1:], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(forces[:, 1], gain, atol=1e-12)
    assert bench.force == [0.0] * 3
    assert ctypes.c_int.in_dll(bench.library, "faulty_open").value == 0
    for name, count in (("lateness", 1001), ("jitter", 1000), ("work", 1000)):
        histogram, times = loop.histogram(name), getattr(report, name)
        assert histogram[:, 1].sum() == count and (np.diff(histogram[:, 0]) > 0).all()
        assert histogram[-1, 0] * (1 - 1 / 32) - 1e-9 <= times.worst <= histogram[-1, 0]
        place = np.searchsorted(np.cumsum(histogram[:, 1]), 0.5 * count)
        assert times.p50 == min(histogram[place, 0], times.worst)
    assert 0.0 < report.lateness.worst < 5e-6  # the spin of a clock that moves by 1 us a look


@pytest.mark.parametrize("fault", ["", "fault=late,from=0.2,to=0.2005,delay=5.2 ms"])
def test_a_recording_replays_to_the_same_bits(bench: Bench, tmp_path: Path, fault: str) -> None:
    """Also where samples were skipped: their poses are those that the model had."""
    record = tmp_path / "motion.csv"
    loop = bench.make(fault, record=record)
    report = loop.run_here()
    assert report.skipped == (4 if fault else 0)
    replayed = bench.model.simulate(1.0, devices={"hand": str(record)})
    columns = np.column_stack([replayed[name] for name in loop.columns])
    assert columns.tobytes() == np.ascontiguousarray(loop.rows).tobytes()


@pytest.mark.parametrize(
    ("policy", "samples", "dropped", "skipped", "behind"),
    [("hold", 497, 4, 0, 0.004), ("skip", 501, 0, 4, 0.0), ("slow", 497, 0, 0, 0.00421)],
)
def test_the_policy_decides_what_a_late_period_becomes(
    bench: Bench, policy: str, samples: int, dropped: int, skipped: int, behind: float
) -> None:
    """Work of 5.2 ms at 0.1 s: the samples of the four periods after it are missed."""
    loop = bench.make("fault=late,from=0.1,to=0.1005,delay=5.2 ms", 0.5, policy=policy)
    report = loop.run_here()
    assert report.end is End.DONE and report.samples == 501
    assert (report.dropped, report.skipped) == (dropped, skipped)
    assert report.overruns >= 1 and report.missed >= 1
    assert report.behind == pytest.approx(behind, abs=3e-5)
    assert report.elapsed == pytest.approx(0.5 + behind, abs=1e-3)
    (warning,) = report.warnings()
    assert warning.code == "BG767" and "get real-time priority" in warning.help
    (warning,) = replace(report, fifo=True).warnings()
    assert "priority" not in warning.help
    assert any(policy in line for line in report.lines())
    kept_time = policy == "skip"
    held = loop.forces()[101:105, 0] == loop.forces()[100, 0]
    assert held.all() == kept_time  # blind samples leave the force as it was


FAULTS = [
    ("fault=unplugged", {}, End.LOST, "BG706", "the cable is out"),
    ("fault=write_lost", {}, End.LOST, "BG706", "device `hand` reported a fault"),
    ("fault=nan", {}, End.BAD_POSE, "BG762", "not finite"),
    ("fault=no_orientation", {}, End.BAD_POSE, "BG762", "not finite"),
    ("fault=stuck", {}, End.STUCK, "BG763", "nothing new for 0.1 s"),
    ("fault=no_news", {}, End.STUCK, "BG763", "nothing new"),
    ("fault=late,delay=1.1 ms", {}, End.LATE, "BG764", "deadlines were missed"),
    ("fault=stalled,delay=0.3", {}, End.STALLED, "BG765", "; the force is zero"),
    ("fault=stalled_driver,delay=0.3", {}, End.STALLED, "BG765", "in a call of a driver"),
    ("", {"parameters": {"limit": 0.31}}, End.MODEL, "BG705", "the pendulum is too high"),
    ("", {"parameters": {"limit": 1.7e308, "push": 1.7e308}}, End.MODEL, "BG703", ""),
]


@pytest.mark.parametrize(
    ("fault", "options", "end", "code", "words"),
    FAULTS,
    ids=[f[0][6:20] or "model" for f in FAULTS],
)
def test_a_fault_ends_the_loop_without_force(
    bench: Bench, fault: str, options: dict[str, Any], end: End, code: str, words: str
) -> None:
    loop = bench.make(fault, 3.0, **options)
    bench.watched()
    report = loop.run_here()
    assert report.end is end and report.failed
    assert report.problem is not None and report.problem.code == code
    assert words in report.problem.message and report.problem.help
    assert bench.force == [0.0] * 3
    assert report.zero_after is not None
    if end is not End.LATE and "driver" not in fault:
        assert report.zero_after <= 1.1e-3  # within a period of the sample that failed
    if end is End.STALLED and "driver" not in fault:
        zero_at = ctypes.c_double.in_dll(bench.library, "faulty_zero_at").value
        assert 0.2 < zero_at < 0.2035  # the watchdog, while the loop still stood
    assert np.isfinite(loop._courses[0].instance.state).all()
    assert loop._courses[0].instance.time == pytest.approx(
        report.time, abs=0.002
    )  # the state is kept


def test_a_saturated_motor_and_a_patient_loop_go_on(bench: Bench) -> None:
    report = bench.make("fault=saturated", 0.3).run_here()
    assert (report.end is End.DONE and report.saturated == 200) or report.saturated == 201
    report = bench.make("fault=late,delay=1.1 ms,to=0.3", 0.5, burst=0.0).run_here()
    assert report.end is End.DONE and report.missed >= 150
    report = bench.make("fault=stuck,to=0.15", 0.5).run_here()
    assert report.end is End.DONE and report.no_news == 49


def test_a_loop_that_ended_before_its_first_sample_has_no_rows(bench: Bench) -> None:
    """Its arrays are empty, although the loop of C is gone."""
    loop = bench.make(duration=0.1)
    loop.stop()
    assert loop.rows.shape == (0, len(loop.columns)) and len(loop.time) == 0


def test_a_lag_beyond_the_one_that_a_device_states_is_said(bench: Bench) -> None:
    """BG783 with the largest lag and the samples above it; at the stated lag nothing is said."""
    report = bench.make("fault=old,delay=3", 0.5).run_here()
    assert report.lag == pytest.approx(3) and report.late_poses == 0
    assert "BG783" not in [warning.code for warning in report.warnings()]
    report = bench.make("fault=old,delay=5.5,to=0.15", 0.5).run_here()
    assert report.end is End.DONE and report.late_poses == 50 and report.late_device == "hand"
    (found,) = (warning for warning in report.warnings() if warning.code == "BG783")
    assert found.message.startswith("`hand` answered up to 5.5 samples late, in 50 of 501 samples")
    assert "`lag = 6`" in found.help and "largest lag measured: 5.5 samples" in [*report.lines()]


def test_news_are_waited_for_from_the_first_sample_on(bench: Bench) -> None:
    """The clock is far from zero; the device has nothing new since it was opened."""
    loop = bench.make("fault=no_news,from=0", since=10**12)
    assert loop.run_here().end is End.STUCK
    assert 0.09 < loop.time[-1] < 0.11


def test_a_device_that_is_absent(bench: Bench) -> None:
    diagnostic = refusal(bench.make, "fault=absent")
    assert diagnostic.code == "BG074" and "no device found" in diagnostic.message


def test_limits_of_force_rate_and_power(bench: Bench) -> None:
    loop = bench.make(duration=0.25, max_force=4.0, max_force_rate=0.0)
    report = loop.run_here()
    size = np.linalg.norm(loop.forces()[:, :3], axis=1)
    free = np.hypot(wanted_force(loop.time), 1.0)
    np.testing.assert_allclose(size[1:], np.minimum(free, 4.0)[1:], rtol=1e-9)
    assert report.limited >= (free > 4.0).sum() > 50
    loop = bench.make(duration=0.25, max_force_rate=100.0)
    loop.run_here()
    change = np.linalg.norm(np.diff(loop.forces()[:, :3], axis=0), axis=1)
    assert change.max() == pytest.approx(0.1, rel=1e-9)
    loop = bench.make(duration=1.0, max_power=0.3, max_force=0.0)
    report = loop.run_here()
    power = loop.forces()[:, 0] * 0.7 * np.cos(7 * loop.time)
    assert power.max() == pytest.approx(0.3, rel=1e-6) and report.worst_power == 0.3
    assert power.min() < -2.0  # what the hand gives is not limited


def test_the_dead_mans_button_takes_the_force_away_at_once(bench: Bench) -> None:
    loop = bench.make(duration=0.6, dead_man=2, ramp=0.05)
    loop.run_here()
    force = np.abs(loop.forces()[:, 1])
    time = loop.time
    assert (force[(time > 0.2995) & (time < 0.4005)] == 0.0).all()
    assert force[299] == 1.0 and force[401] == pytest.approx(0.02) and force[460] == 1.0


def test_a_normal_stop_lets_the_force_fall(bench: Bench) -> None:
    """Asked to stop at 0.3 s, the loop runs on for the ramp of 0.1 s; at once, it does not."""
    loop = bench.make(duration=9.0, ramp=0.1)
    bench.at(0.2995, lambda: loop._servo.stop())
    report = loop.run_here()
    assert report.end is End.STOPPED and report.samples == 401
    force = loop.forces()[:, 1]
    np.testing.assert_allclose(force[301:], np.arange(99, -1, -1) / 100, atol=1e-12)
    assert report.gain == 0.0 and bench.force == [0.0] * 3

    loop = bench.make(duration=9.0, ramp=0.1)
    bench.at(0.2995, lambda: loop._servo.stop(at_once=True))
    assert loop.run_here().samples == 301 and bench.force == [0.0] * 3

    # A limit of the rate holds too: 11 N fall by 20 N/s in 0.55 s, whatever the ramp.
    loop = bench.make(duration=9.0, ramp=0.1, max_force_rate=20.0)
    bench.at(1.0, lambda: loop._servo.stop())
    report = loop.run_here()
    size = np.linalg.norm(loop.forces()[:, :3], axis=1)
    assert report.end is End.STOPPED and size[-1] == 0.0 and size[1000] > 1.5
    assert np.abs(np.diff(size)).max() <= 0.0200001
    # So it does before the end of the duration: 12 N would take 0.6 s.
    loop = bench.make(duration=1.5, ramp=0.1, max_force_rate=20.0)
    size = np.linalg.norm(loop.forces()[:, :3], axis=1) if loop.run_here() else None
    assert size[-1] == 0.0 and np.abs(np.diff(size)).max() <= 0.0200001

    # A fault while it falls is a fault.
    loop = bench.make("fault=unplugged,from=0.35", 9.0, ramp=0.1)
    bench.at(0.2995, lambda: loop._servo.stop())
    assert loop.run_here().end is End.LOST and bench.force == [0.0] * 3


def test_a_model_takes_the_place_of_another_in_the_running_loop(
    bench: Bench, folder: Path, tmp_path: Path
) -> None:
    other = bgc.compile(folder / "held.bg", scene="heavier")
    record = tmp_path / "motion.csv"
    # The device moves in the time of the model, which begins again.
    loop = bench.make(duration=1.0, ramp=0.1, record=record, max_speed=0.0, max_turn_rate=0.0)
    seen: list[tuple[tuple[str, ...], np.ndarray, np.ndarray]] = []
    loop._on_records = lambda _: seen.append((loop.columns, loop._records.copy(), loop.rows.copy()))
    bench.at(0.2995, lambda: loop.exchange(other, parameters={"limit": 20}))
    report = loop.run_here()
    assert report.end is End.DONE and (report.samples, report.exchanges) == (1001, 1)
    assert report.missed == 0 and "2 models" in next(report.lines())
    assert ctypes.c_int.in_dll(bench.library, "faulty_open").value == 0  # opened once

    # The force falls to zero under the first model, and rises from zero under the second.
    (columns, records, rows), after = seen[-2], loop.forces()
    assert (columns, loop.columns) == (("angle", "rate", "x"), ("angle", "lift"))
    before = forces_of(records, 0)
    assert len(before) == 401 and len(after) == 600
    np.testing.assert_allclose(before[301:, 1], np.arange(99, -1, -1) / 100, atol=1e-12)
    gain = np.minimum(1.0, np.minimum(np.arange(1, 601), np.arange(599, -1, -1)) / 100)
    np.testing.assert_allclose(after[:, 1], 2.0 * gain, atol=1e-12)

    # The new model starts at its own time and start; both parts replay to the same bits.
    assert loop.time[0] == 0.0 and loop.rows[0, 0] == 0.1
    np.testing.assert_allclose(loop.time, np.arange(600) * 1e-3, atol=1e-12)
    for model, path, expected, duration in (
        (bench.model, record, rows, 0.4),
        (other, tmp_path / "motion_2.csv", loop.rows, 0.599),
    ):
        result = model.simulate(duration, devices={"hand": str(path)})
        columns = tuple(variable.name for variable in model.measured)
        replayed = np.column_stack([result[name] for name in columns])
        assert replayed.tobytes() == np.ascontiguousarray(expected).tobytes()


def test_tolerances_of_adaptive_methods_hold_in_the_loop(bench: Bench) -> None:
    """A loose one takes a step a period, a tight one several; the period stays the scene's."""
    options = RealtimeOptions(priority=False, policy="hold", burst=0.0)
    steps = []
    for tolerance in (1e-3, 1e-14):
        loop = bench.model.realtime(
            0.1, options=options, solver="rodas4p2", rtol=tolerance, atol=tolerance
        )
        assert loop.run_here().samples == 101
        steps.append(loop._courses[0].instance.counts["steps"])
    assert steps[0] <= 103 < 150 < steps[1]


def test_a_start_at_rest_has_the_hand_at_rest(bench: Bench) -> None:
    """The device is 20 mm off the middle: the pendulum hangs, then takes the pose of the hand."""
    loop = bench.model.realtime(
        0.01,
        devices={"hand": str(bench.model.folder / "still.csv")},
        options=RealtimeOptions(priority=False, policy="hold"),  # no sample without the device
        start="rest",
    )
    loop.run_here()
    assert loop.at_rest is not None
    assert loop.rows[0].tolist() == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert loop.rows[1:, 2].tolist() == [0.02] * 10


def test_an_exchange_that_is_refused_changes_nothing(bench: Bench, folder: Path) -> None:
    found: list[str] = []

    def refused(**arguments: Any) -> None:
        with pytest.raises(BgError) as caught:
            loop.exchange(arguments.pop("model", bench.model), **arguments)
        (diagnostic,) = caught.value.diagnostics
        found.append(f"{diagnostic.code} {diagnostic.message}")

    def attack() -> None:
        refused(model=bgc.compile(folder / "held.bg", scene="other_device"))
        refused(step=2e-3)
        refused(parameters={"gravity": 0, "push": 1}, start="rest")  # there is no rest
        loop.exchange(bench.model, wait=False)
        refused()

    loop = bench.make(duration=0.6, ramp=0.1)
    bench.at(0.2, attack)
    assert loop.run_here().exchanges == 1
    refused()
    words = ("`stick`, the loop `hand`", "period of 0.002", "BG7", "under way", "has ended")
    for line, word in zip(found, words, strict=True):
        assert word in line and line.startswith("BG757") == (word != "BG7")


def test_a_process_that_was_stopped_returns_with_zero_force(bench: Bench) -> None:
    """Loop and watchdog stand still together for 0.3 s; nothing but zero is written after that."""
    bench.make("fault=stalled,delay=0.3", 3.0)  # and no watchdog that acts meanwhile
    report = bench.loop.run_here()
    assert report.end is End.STALLED and report.problem is not None
    assert report.problem.code == "BG765" and report.samples == 101
    zero_at = ctypes.c_double.in_dll(bench.library, "faulty_zero_at").value
    assert zero_at - (0.1 + 1e-3 + 0.3) == pytest.approx(0.85e-3, abs=2e-5)  # less the spin
    assert bench.force == [0.0] * 3


def test_a_reader_that_is_gone_does_not_stop_the_loop(bench: Bench) -> None:
    """Nobody takes the records of 20 s until the end: the ring has room for 16,384."""
    loop = bench.make(duration=20.0)
    report = loop.run_here()
    assert report.end is End.DONE and report.samples == 20_001
    assert report.lost_records == 20_001 - 16_384
    assert [warning.code for warning in report.warnings()] == ["BG768"]


def test_the_manual_names_twenty_faults_and_their_tests() -> None:
    head = "| fault | answer | message | status | test |\n"
    table = whole_manual().partition(head)[2].partition("\n\n")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines()[1:]]
    texts = [path.read_text("utf-8") for path in Path(__file__).parent.glob("test_*.py")]
    assert len(rows) >= 20
    for _, _, _, status, test in rows:
        assert status in ("0", "1", "2", "137", "143")
        assert any(f"def {test.strip('`')}(" in text for text in texts), test


def test_a_full_disk_ends_the_recording_alone(bench: Bench) -> None:
    loop = bench.make(duration=0.3, record=Path("/dev/full"))
    assert loop.run_here().end is End.DONE
    (warning,) = loop.warnings
    assert warning.code == "BG768" and "No space left" in warning.message
    report = replace(loop.report, lost_records=3, fifo=False, locked=False)
    codes = [warning.code for warning in report.warnings()]
    assert codes == ["BG766", "BG768"]


def test_a_recording_that_may_not_grow_ends_with_a_whole_row(bench: Bench, tmp_path: Path) -> None:
    """Of a file that reaches its limit the rows so far replay; the loop goes on."""
    path = tmp_path / "motion.csv"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    loop = bench.make(duration=0.3, record=path)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_001, before[1]))
    try:
        assert loop.run_here().end is End.DONE
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [warning.code for warning in loop.warnings] == ["BG768"]
    text = path.read_text("utf-8")
    header, *rows = text.splitlines()
    assert text.endswith("\n") and 19_000 < len(text) <= 20_001
    assert len(rows) > 30 and {row.count(",") for row in rows} == {header.count(",")}


def test_a_driver_that_does_not_return_leaves_the_loop_behind(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(loop_module, "_PATIENCE", 0.2)
    hold = ctypes.c_int.in_dll(bench.library, "faulty_hold")
    hold.value = 1
    loop = bench.make("fault=hang,from=0.0005", watchdog=0.0)
    loop.start()
    while loop._servo.report().samples < 1:  # it hangs in the second read
        time.sleep(0.001)
    time.sleep(0.05)
    assert refusals(loop.stop)[0].code == "BG775"
    hold.value = 0
    assert loop._servo.join(10.0)
    assert loop.close().end is End.STOPPED


def test_what_the_loop_refuses_before_it_starts(model: Any, folder: Path) -> None:
    for code, arguments in (
        ("BG769", {"step": 0.15e-3}),
        ("BG769", {"options": RealtimeOptions(policy="wait")}),
        ("BG066", {"options": RealtimeOptions(max_force=-1.0)}),
        ("BG066", {"options": RealtimeOptions(dead_man=9)}),
    ):
        assert refusals(model.realtime, **arguments)[0].code == code
    path = folder / "policy.bg"
    path.write_text(SCENE.replace("skip", "wait"))
    (diagnostic,) = check_source(path)
    assert diagnostic.code == "BG776" and diagnostic.span and diagnostic.span.text == "wait"


@pytest.mark.parametrize("policy", POLICIES)
def test_a_policy_is_formatted_inherited_and_reserves_no_word(tmp_path: Path, policy: str) -> None:
    text = (
        f"model M {{ state {policy} = 1; der({policy}) = -{policy}; }}\n"
        f"scene a of M {{ deadline  1 ms ,{policy} ; run 1 s; observe {policy}; }}\n"
        "scene b is a { run 2 s; }\n"
    )
    assert f"deadline 1 ms, {policy};" in format_source(Source("m.bg", text))
    (tmp_path / "m.bg").write_text(text)
    stages = compile_scene(tmp_path / "m.bg", Options("b"), until="elaborate")
    assert stages.graph.scene.overrun == policy


def test_a_pose_from_python_reaches_the_model(model: Any) -> None:
    loop = model.realtime(
        0.05, devices={"hand": "pointer"}, options=RealtimeOptions(priority=False)
    )
    loop.pointer([0.03, 0.0, 0.0], velocity=[0.5, 0.0, 0.0], buttons=[1])
    report = loop.run_here()
    assert report.end is End.DONE and report.no_news > 0
    assert loop.latest()["x"] == 0.03
    shown = io.StringIO()
    Console(file=shown, width=80).print(view_of(loop))
    # No line of the report is broken, which would move the values below it.
    lines = [line.strip() for line in shown.getvalue().splitlines()]
    assert set(loop.report.lines()) <= set(lines)
    assert re.search(r"(?m)^ x +0\.03 m *$", shown.getvalue())  # with its unit
    loop = model.realtime(0.05)
    assert refusals(loop.pointer, [0.0, 0.0, 0.0])[0].code == "BG777"
    loop.stop()
