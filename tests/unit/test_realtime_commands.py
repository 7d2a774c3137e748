"""The servo loop on the clock of the system: devices in Python, commands, signals, keys."""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Self

import numpy as np
import pytest
from click.testing import CliRunner
from held import prepare
from processes import started

import bgc
from bgc.runtime.cli import haptic as haptic_module
from bgc.runtime.cli.app import application
from bgc.runtime.cli.keys import Menu
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.loop_records import held_of
from bgc.runtime.realtime.python_device import PythonThread
from bgc.runtime.realtime.servo_binding import End

BGC = (sys.executable, "-c", "from bgc.runtime.cli import main; main()")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return prepare(tmp_path_factory.mktemp("realtime"))


@pytest.fixture(scope="module")
def model(folder: Path) -> Any:
    return bgc.compile(folder / "held.bg")


class FarDevice:
    """A device behind datagrams that stands still; `forces` are those along y that it got, N."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self._socket.settimeout(0.005)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self.forces: list[float] = []

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self._socket.close()

    def until(self, process: subprocess.Popen[bytes], holds: Callable[[float], bool]) -> int:
        """Wait for such a force of a process; the number of forces until then."""
        while not (self.forces and holds(self.forces[-1])):
            assert process.poll() is None, process.stderr and process.stderr.read()
            time.sleep(0.001)
        return len(self.forces)

    def _serve(self) -> None:
        pose = [0.02, 0.0, 0.0, 1.0] + [0.0] * 18
        number = 0
        while not self._ended.is_set():
            number += 1
            text = struct.pack("<4sIQd22d", b"BGCP", 1, number, time.monotonic(), *pose)
            with suppress(OSError):  # nobody listens yet, or nothing has come
                self._socket.sendto(text, ("127.0.0.1", self.port))
                self._take(self._socket.recv(100))

    def _take(self, answer: bytes) -> None:
        self._socket.setblocking(False)
        with suppress(BlockingIOError):
            while True:
                self.forces.append(struct.unpack("<4sIQQ8d", answer)[6])
                answer = self._socket.recv(100)
        self._socket.settimeout(0.005)


class Hand:
    """A device that is a Python object, which fails after some calls."""

    def __init__(self, calls: int) -> None:
        self.left, self.written = calls, 0

    def read(self) -> dict[str, Any]:
        self.left -= 1
        if self.left < 0:
            raise RuntimeError("the tablet is gone")
        return {"position": [0.04, 0.0, 0.0]}

    def write(self, force: Any, torque: Any, gripper_force: float) -> None:
        self.written += 1


def test_half_a_second_in_real_time_with_a_device_in_python(model: Any) -> None:
    """The one test on the clock of the system: it ends and reports, however late it is."""
    hand, seen = Hand(20), []
    options = RealtimeOptions(watchdog=0.0)
    loop = model.realtime(60.0, devices={"hand": hand}, options=options, on_records=seen.append)
    with loop:
        report = loop.wait()
    assert report.end is End.STOPPED and report.samples > 0
    assert [warning.code for warning in loop.warnings] == ["BG779"]
    assert "the tablet is gone" in loop.warnings[0].message
    assert sum(map(len, seen)) == report.samples == len(loop.time)
    assert loop.latest()["x"] == 0.04 and hand.written > 0
    assert report.work.worst >= report.work.p50 > 0.0
    # The force of a read answers the one before it at the latest, 5 ms ago; before the first, none.
    ages = held_of(np.concatenate(seen), 0)[:, 3]
    assert ages[0] == 0.0 and ages[-1] >= 0.005


def test_the_age_of_a_pose_in_python_goes_by_the_stamps_of_the_device() -> None:
    """A device on a clock of its own, whose force always answers the pose before the last."""
    fed: list[dict[str, Any]] = []
    done = threading.Event()

    class Clocked:
        def read(self) -> dict[str, Any]:
            return {"position": [0.0] * 3, "stamp": 100.0 + 0.25 * len(fed)}

        def write(self, force: Any, torque: Any, gripper_force: float) -> None:
            pass

    def feed(**pose: Any) -> None:
        fed.append(pose)
        if len(fed) == 6:
            done.set()

    def force() -> tuple[np.ndarray, float] | None:
        return (np.zeros(7), fed[-3]["stamp"]) if len(fed) > 2 else None

    thread = PythonThread(Clocked(), feed, force, lambda reason: None)
    assert done.wait(20.0)
    thread.stop()
    # Read k has the force of the turn before, which answers pose k - 3.
    assert [pose.get("age") for pose in fed[:6]] == [None] * 3 + [0.75] * 3


def test_a_loop_that_nobody_stops_ends_with_the_process(folder: Path) -> None:
    script = (  # what is registered first is called last
        "import atexit, ctypes, sys\n"
        "force = (ctypes.c_double * 3).in_dll(ctypes.CDLL(sys.argv[2]), 'faulty_force')\n"
        "atexit.register(lambda: print(any(force)))\n"
        "import bgc\n"
        "from bgc.runtime.realtime.loop_options import RealtimeOptions\n"
        "model = bgc.compile(sys.argv[1])\n"
        "here = RealtimeOptions(supervise=False)\n"
        "loop = model.realtime(devices={'hand': sys.argv[2]}, options=here).start()\n"
        "while not any(force): loop.step()\n"
    )
    command = [sys.executable, "-c", script, str(folder / "held.bg"), str(folder / "faulty.so")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "False\n", "")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_command_that_is_killed_while_it_exchanges_its_model(
    folder: Path, tmp_path: Path, number: signal.Signals
) -> None:
    """The force, seen by a device behind datagrams, has fallen half way from 1 N when it comes."""
    terminal, keys = os.openpty()
    record = tmp_path / "motion.csv"
    far = FarDevice()
    command = [*BGC, "haptic", str(folder / "held.bg"), "--exchange", "heavier"]
    given = ["--ramp", "1 s", "--watchdog", "0 s", "--burst", "0", "--record", str(record)]
    device = ["--device", f"hand=udp(port={far.port}, wait=60)"]
    options = {"stdin": keys, "stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    with started([*command, *given, *device], **options) as process, far:
        far.until(process, lambda force: force == 1.0)
        os.write(terminal, b"2")
        at = far.until(process, lambda force: force < 0.5)
        process.send_signal(number)
        status = process.wait(60)
        end = time.monotonic() + 20.0
        while far.forces[-1] != 0.0 and time.monotonic() < end:
            time.sleep(0.001)
    os.close(terminal)
    os.close(keys)
    after = np.array(far.forces[at:])
    # It goes on to zero, which is the last that the device gets; where the command is gone, from
    # the process of the driver.
    assert after[-1] == 0.0 and np.all(np.diff(after) <= 0.0)
    assert status == (128 + number if number == signal.SIGTERM else -number)
    # The part before the exchange is whole and is played again; the other model has not begun.
    assert [path.name for path in tmp_path.iterdir()] == [record.name]
    assert record.read_bytes().endswith(b"\n")
    rows = np.genfromtxt(record, delimiter=",", names=True)
    assert rows["fy"].max() == 1.0 and np.isfinite(rows["age"]).all()
    played = bgc.compile(folder / "held.bg").simulate(0.1, devices={"hand": str(record)})
    assert played["x"][-1] == 0.02


def test_a_command_that_was_stopped_returns_with_zero_force(folder: Path) -> None:
    """While it is stopped, the process of the driver writes zero; afterwards nothing else comes."""
    far = FarDevice()
    device = ["--device", f"hand=udp(port={far.port}, wait=60)", "--ramp", "10 ms"]
    given = ["--watchdog", "0.6 s", "--stale", "0 s", "--burst", "0", "--quiet"]
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    command = [*BGC, "haptic", str(folder / "held.bg"), *device, *given]
    with started(command, **options) as process, far:
        far.until(process, lambda force: force == 1.0)
        process.send_signal(signal.SIGSTOP)
        time.sleep(0.1)  # what is under way arrives
        at = len(far.forces)
        far.until(process, lambda force: force == 0.0)
        time.sleep(0.2)
        process.send_signal(signal.SIGCONT)
        assert process.wait(60) == 1
        assert process.stderr and b"BG765" in process.stderr.read()
        time.sleep(0.02)
    assert far.forces[at:] and not any(far.forces[at:])


def test_the_commands_in_real_time(folder: Path) -> None:
    scene, device = str(folder / "held.bg"), f"hand={folder}/faulty.so(fault=unplugged,from=0.05)"
    command = ["haptic", scene, "--time", "2 s", "--watchdog", "0 s", "--device", device]
    done = CliRunner().invoke(application, command)
    assert done.exit_code == 1 and "BG706" in done.output and "the cable is out" in done.output
    assert "deadlines missed" in done.output
    command = ["haptic", scene, "--time", "0.1 s", "--device", f"hand={folder}/faulty.so"]
    done = CliRunner().invoke(application, [*command, "--exchange", "heavier"])
    assert done.exit_code == 2 and "needs a terminal" in done.output
    out = folder / "rows.csv"
    command = ["run", scene, "--realtime", "--time", "0.1 s", "--every", "20 ms", "--out", str(out)]
    done = CliRunner().invoke(application, command)
    assert done.exit_code == 0, done.output
    rows = np.genfromtxt(out, delimiter=",", names=True)
    np.testing.assert_allclose(rows["time"], np.arange(6) * 0.02, atol=1e-12)
    tight = ["run", scene, "--realtime", "--time", "0.1 s", "--rtol", "1e-9", "--out", str(out)]
    done = CliRunner().invoke(application, [*tight, "--solver", "rodas5p", "--every", "20 ms"])
    assert done.exit_code == 0 and "deadlines missed" in done.output, done.output
    assert len(np.genfromtxt(out, delimiter=",", names=True)) == 6
    for command in (["run", "--realtime"], ["haptic", "--time", "0.1 s"]):
        command = [command[0], scene, *command[1:], "--solver", "rk4", "--rtol", "1e-3"]
        done = CliRunner().invoke(application, command)
        assert done.exit_code == 1 and "BG044" in done.output  # a method without error control


def test_keys_exchange_the_scenes_of_the_command(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three models one after the other in a loop on the clock of the system."""
    terminal, keys = os.openpty()
    tty.setcbreak(keys)
    shown: list[str] = []
    menus: list[Menu] = []

    class Typist(Menu):
        def poll(self) -> None:
            menus[:] = [self]
            if self.loop.report.exchanges == len(shown):
                shown.append(self.line())
                os.write(terminal, b"23n9"[len(shown) - 1 : len(shown)])
                super().poll()
            if len(shown) == 4:
                self.loop.stop()

    monkeypatch.setattr(haptic_module, "Menu", Typist)
    monkeypatch.setattr(haptic_module, "terminal_keys", lambda: nullcontext(keys))
    record = str(tmp_path / "motion.csv")
    command = ["haptic", str(folder / "held.bg"), "--exchange", "heavier", "--exchange", "limit=11"]
    given = ["--ramp", "5 ms", "--watchdog", "0 s", "--record", record, "--time", "30 s"]
    # The device moves in the time of the model, which begins again.
    device = ["--device", f"hand={folder}/faulty.so", "--max-speed", "0", "--max-turn-rate", "0"]
    done = CliRunner().invoke(application, [*command, *given, *device])
    os.close(terminal)
    os.close(keys)
    assert done.exit_code == 0, done.output
    assert "4 models" in done.output
    assert [line.partition("[")[2][:1] for line in shown] == ["1", "2", "3", "1"]
    (menu,) = menus
    menu.loop = SimpleNamespace(course=SimpleNamespace(model=None))  # another one, by a page
    assert menu.line() == "1 s, 2 heavier, 3 limit=11; n next"
    names = [f"motion{suffix}.csv" for suffix in ("", "_2", "_3", "_4")]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_a_scene_without_a_device_has_nothing_to_record(tmp_path: Path) -> None:
    scene = tmp_path / "alone.bg"
    scene.write_text(
        "model M { state x = 1; der(x) = -x; } scene s of M { observe x; step 1 ms; run 1 s; }"
    )
    command = ["haptic", str(scene), "--time", "20 ms", "--watchdog", "0 s", "--record"]
    done = CliRunner().invoke(application, [*command, str(tmp_path / "motion.csv")])
    assert done.exit_code == 0 and "BG768" in done.output and "no device" in done.output
    assert list(tmp_path.iterdir()) == [scene]
    done = CliRunner().invoke(application, [*command, str(tmp_path / "motion.txt")])
    assert done.exit_code == 1 and "BG070" in done.output
