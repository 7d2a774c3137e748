"""Devices: samples, held inputs, commands, faults; and the trace driver."""

from __future__ import annotations

import ctypes
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from device_interface import Driver, Pose

from bgc.language.scene_tables import DRIVER_OPTIONS, TRACE_COLUMNS

KNOWN = (
    "time, x, y, z, qw, qx, qy, qz, gripper, button1 .. button8, "
    "vx, vy, vz, wx, wy, wz, hx, hy, hz, age, fx, fy, fz, tx, ty, tz, gripper_force"
)
NO_COLUMN = "the header has a column that no option such as x=NAME names, and that is none of"
TRACE_OPTIONS = f"file, scale, loop, clock, or a column: {KNOWN}"
HAND = "time,x,y,z\n0,0,0,0\n1,1,0,-2\n3,1,0,0\n"


class Trace:
    """The trace driver, used directly."""

    def __init__(self, library: Any, options: str) -> None:
        self.driver = Driver.in_dll(library, "bgc_trace_driver")
        message = ctypes.create_string_buffer(400)
        self.handle = self.driver.open(options.encode(), message, 400)
        self.message = message.value.decode()

    def at(self, time: float) -> Pose:
        pose = Pose()
        assert self.driver.read(self.handle, time, ctypes.byref(pose)) == 0
        return pose

    def __del__(self) -> None:
        if self.handle:
            self.driver.close(self.handle)


@pytest.fixture
def library(c_library: Any) -> Any:
    return c_library("handle")


@pytest.fixture
def handle(c_model: Any, library: Any) -> Any:
    """A model with the test device open, and the device reset."""
    faulty = ctypes.c_double.in_dll(library, "test_faulty_from")
    faulty.value = math.inf
    ctypes.c_int.in_dll(library, "test_writes").value = 0
    ctypes.c_int.in_dll(library, "test_open").value = 0
    instance = c_model("handle")
    driver = ctypes.byref(Driver.in_dll(library, "test_driver"))
    assert instance.open_device(driver=driver) == ("OK", "")
    return instance


def written(library: Any) -> list[float]:
    return list((ctypes.c_double * 4).in_dll(library, "test_written"))


# --- samples ---------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [{"name": "rodas5p", "rtol": 1e-9}, {"name": "ros34prw"}])
def test_inputs_are_held_between_samples(handle: Any, options: dict[str, Any]) -> None:
    handle.start(**options)
    rows = handle.finish(np.linspace(0.0, 1.0, 101))
    exact = np.zeros(101)
    for k in range(100):  # x' = 10 (t_k - x) over each sample
        exact[k + 1] = 0.01 * k + (exact[k] - 0.01 * k) * math.exp(-0.1)
    np.testing.assert_allclose(rows[:, 0], exact, atol=1e-7 if "rtol" in options else 1e-5)
    assert handle.counts.samples == 101


def test_commands_are_written_at_each_sample(handle: Any, library: Any) -> None:
    handle.start("ros34prw")
    handle.finish([0.5])
    assert ctypes.c_int.in_dll(library, "test_writes").value == 51
    force = written(library)
    assert force[0] == 10.0 * (handle.state[0] - 0.5)
    assert force[3] == 1.0  # the orientation's real part, which rests at 1


def test_adaptive_steps_end_at_samples_and_grow_beyond_none(handle: Any) -> None:
    handle.start("rodas5p", rtol=1e-3)
    handle.finish([1.0])
    assert handle.counts.steps <= 125
    assert handle.time == 1.0


@pytest.mark.parametrize("name", ["rodas5p", "ros34prw"])
def test_chunks_with_devices_give_the_same_bits(handle: Any, name: str) -> None:
    times = np.linspace(0.0, 0.3, 77)
    handle.start(name)
    whole = handle.finish(times)
    handle.start(name)
    rows = np.concatenate([handle.finish(part) for part in np.array_split(times, 9)])
    np.testing.assert_array_equal(rows, whole)


def test_closing_leaves_no_force(handle: Any, library: Any) -> None:
    handle.start("ros34prw")
    handle.finish([0.5])
    assert written(library)[0] != 0.0
    handle.library.bgc_close_devices(handle.model, handle.data)
    assert written(library) == [0.0] * 4
    assert ctypes.c_int.in_dll(library, "test_open").value == 0


def test_a_device_opened_again_closes_the_one_before(handle: Any, library: Any) -> None:
    handle.start("ros34prw")
    handle.finish([0.5])
    assert written(library)[0] != 0.0
    message = ctypes.create_string_buffer(b"from before")
    driver = ctypes.byref(Driver.in_dll(library, "test_driver"))
    assert handle.call("bgc_open_device", 0, driver, None, message, ctypes.c_size_t(12)) == "OK"
    assert message.value == b""
    assert written(library) == [0.0] * 4
    assert ctypes.c_int.in_dll(library, "test_open").value == 1
    assert handle.call("bgc_open_device", 0, driver, None, None, ctypes.c_size_t(0)) == "OK"


def test_fault_ends_the_run_without_force(handle: Any, library: Any) -> None:
    handle.start("ros34prw")
    ctypes.c_double.in_dll(library, "test_faulty_from").value = 0.255
    status, rows = handle.run(np.linspace(0.0, 1.0, 101))
    assert status == "DEVICE"
    assert len(rows) == 26
    assert handle.time == pytest.approx(0.26)
    assert written(library) == [0.0] * 4
    assert handle.library.bgc_failed_device(handle.data) == 0
    handle.library.bgc_device_reason.restype = ctypes.c_char_p
    assert handle.library.bgc_device_reason(handle.data) == b"the cable is out"


def test_a_pose_that_is_not_finite_ends_the_run_without_force(handle: Any, library: Any) -> None:
    handle.start("ros34prw")
    endless = ctypes.c_double.in_dll(library, "test_endless_from")
    endless.value = 0.255
    status, rows = handle.run(np.linspace(0.0, 1.0, 101))
    endless.value = math.inf
    assert status == "DEVICE" and len(rows) == 26
    assert np.isfinite(rows).all()
    assert written(library) == [0.0] * 4
    handle.library.bgc_device_reason.restype = ctypes.c_char_p
    reason = handle.library.bgc_device_reason(handle.data)
    assert reason == b"a value that it reads is not finite"


def test_a_run_in_parts_gives_the_bits_of_one_run(c_model: Any, tmp_path: Path) -> None:
    """`bgc_advance` integrates to a sample and leaves it to `bgc_run`."""
    (tmp_path / "hand.csv").write_text(HAND)
    times = np.arange(1, 101) * 0.01
    rows, counts = [], []
    for parts in (False, True):
        instance = c_model("handle")
        assert instance.open_device(f"file={tmp_path / 'hand.csv'}\n") == ("OK", "")
        instance.start("ros34prw")
        instance.library.bgc_sample_period.restype = ctypes.c_double
        assert instance.library.bgc_sample_period(instance.data) == 0.01
        found = []
        for time in times if parts else []:
            assert instance.call("bgc_advance", ctypes.c_double(time)) == "OK"
            assert instance.time == pytest.approx(time)
            before = instance.counts.samples
            found.append(instance.finish([time])[0])
            assert instance.counts.samples == before + 1
        rows.append(np.array(found) if parts else instance.finish(times))
        counts.append(instance.counts.steps)
    assert rows[0].tobytes() == rows[1].tobytes()
    assert counts[0] == counts[1]


def test_a_driver_of_another_version_is_refused(c_model: Any, library: Any) -> None:
    instance = c_model("handle")
    driver = ctypes.byref(Driver.in_dll(instance.library, "old_driver"))
    status, message = instance.open_device("", driver=driver)
    assert status == "BAD_ARGUMENT" and "version 3 of the interface" in message


def test_caller_drives_inputs_of_devices_that_are_not_open(c_model: Any) -> None:
    instance = c_model("handle")
    instance.start("rodas5p")
    np.testing.assert_array_equal(instance.input, [0.0, 0.0, 0.0, 1.0])
    instance.input[1] = 2.0
    rows = instance.finish([0.1, 0.2])
    np.testing.assert_allclose(rows[:, 1], 2.0 * (1.0 - np.exp([-1.0, -2.0])), rtol=1e-5)
    assert instance.time == 0.2  # steps of a model with inputs end at samples


@pytest.mark.parametrize("name", ["rodas5p", "ros34prw"])
def test_algebraic_states_follow_an_input_that_jumps(c_model: Any, name: str) -> None:
    instance = c_model("follower")
    instance.start(name)
    assert instance.finish([0.0, 1.0])[1].tolist() == [0.0, 0.0]
    instance.input[0] = 1.0
    rows = instance.finish([1.0, 1.1, 2.0])
    np.testing.assert_allclose(rows[1:, 0], 1.0 - np.exp([-0.1, -1.0]), atol=1e-5)
    np.testing.assert_allclose(rows[1:, 1], 1.0)
    assert instance.counts.rejected == 0


def test_device_and_driver_that_do_not_exist(c_model: Any) -> None:
    instance = c_model("handle")
    message = ctypes.create_string_buffer(100)
    assert instance.call("bgc_open_device", 1, None, None, message, 100) == "BAD_ARGUMENT"
    assert b"no device 1" in message.value
    instance.library.bgc_find_driver.restype = ctypes.c_void_p
    assert instance.library.bgc_find_driver(b"joystick") is None
    assert instance.library.bgc_find_driver(b"trace") is not None


def test_scene_options_are_used_when_none_are_given(c_model: Any) -> None:
    status, message = c_model("handle").open_device()
    assert status == "DEVICE"
    assert message.startswith("hand.csv: the file cannot be read")


# --- the trace driver ------------------------------------------------------------------------


def test_trace_interpolates_and_holds_its_ends(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    path.write_text(HAND)
    trace = Trace(library, f"file={path}\n")
    for time, position, velocity in (
        (-1.0, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        (0.0, [0.0, 0.0, 0.0], [1.0, 0.0, -2.0]),
        (0.25, [0.25, 0.0, -0.5], [1.0, 0.0, -2.0]),
        (2.0, [1.0, 0.0, -1.0], [0.0, 0.0, 1.0]),
        (0.5, [0.5, 0.0, -1.0], [1.0, 0.0, -2.0]),
        (3.0, [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        (99.0, [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    ):
        pose = trace.at(time)
        np.testing.assert_allclose(list(pose.position), position, atol=1e-15)
        np.testing.assert_allclose(list(pose.velocity), velocity, atol=1e-15)
        assert list(pose.orientation) == [1.0, 0.0, 0.0, 0.0]


def test_trace_scale_and_loop(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    path.write_text(HAND)
    trace = Trace(library, f"file={path}\nscale=10\nloop=1\n")
    for time in (0.25, 3.25, 30.25):
        pose = trace.at(time)
        np.testing.assert_allclose(list(pose.position), [2.5, 0.0, -5.0])
        np.testing.assert_allclose(list(pose.velocity), [10.0, 0.0, -20.0])


def test_trace_with_orientation_gripper_and_buttons(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    half = 0.005  # half the angle between rows: 0.01 rad in 0.1 s about z
    path.write_text(
        "\ufeff# recorded\r\n\r\ntime, qw, qx, qy, qz, x, y, z, gripper, button2\r\n"
        + "0, 1, 0, 0, 0, 0, 0, 0, 0.01, 1\r\n"
        + f"0.1, {-math.cos(half)}, 0, 0, {-math.sin(half)}, 0, 0, 0, 0.03, 0"
    )
    pose = Trace(library, f"file={path}").at(0.05)
    np.testing.assert_allclose(
        list(pose.orientation), [math.cos(half / 2), 0.0, 0.0, math.sin(half / 2)], atol=1e-12
    )
    np.testing.assert_allclose(list(pose.angular_velocity), [0.0, 0.0, 0.1], rtol=1e-4)
    assert pose.gripper == pytest.approx(0.02)
    assert list(pose.buttons) == [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ": the file has no header `time,x,y,z`"),
        ("# only a comment\n\n", ": the file has no header `time,x,y,z`"),
        ("time,x,y,z\n", ": the file has no rows"),
        ("time,x,y\n0,0,0\n", ":1: the header lacks the column z"),
        ("\ntime,x,y,zz\n", f":2: {NO_COLUMN} {KNOWN}"),
        ("time,x,y,z,x\n", ":1: this column is there twice: x"),
        ("time,x,y,z,qx\n", ":1: the header lacks the column qw"),
        ("time,x,y,z\n0,0,0,0\n1,a,0,0\n", ":3: there is no number in the column x"),
        ("time,x,y,z\n0,0,0,\n", ":2: there is no number in the column z"),
        ("time,x,y,z\n0,nan,0,0\n", ":2: there is no number in the column x"),
        ("time,x,y,z\n0,1e999,0,0\n", ":2: there is no number in the column x"),
        ("time,x,y,z\n0,0,0\n", ":2: this row lacks the column z"),
        ("time,x,y,z\n0,0,0,0,0\n", ":2: this row has more columns than the header"),
        ("time,x,y,z\n0,0,0,0\n\n0,1,1,1\n", ":4: times must increase from row to row"),
        ("time,x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n", ":2: this quaternion has no direction"),
    ],
)
def test_trace_reports_the_line_at_fault(
    library: Any, tmp_path: Path, text: str, message: str
) -> None:
    path = tmp_path / "hand.csv"
    path.write_text(text)
    trace = Trace(library, f"file={path}")
    assert not trace.handle
    assert trace.message == f"{path}{message}"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("", "trace: the option `file` is missing"),
        ("file", "trace: this option has no value: file"),
        ("file=a\nspeed=2", f"trace: there is no option called speed: {TRACE_OPTIONS}"),
        ("file=a\nscale=big", "trace: scale must be a number, not big"),
        ("file=a\ntime=t", f"trace: there is no option called time: {TRACE_OPTIONS}"),
        ("file=a\nfx=2", f"trace: there is no option called fx: {TRACE_OPTIONS}"),
        ("file=a\nloop=2", "trace: loop must be 0 or 1, not 2"),
    ],
)
def test_trace_reports_wrong_options(library: Any, options: str, message: str) -> None:
    trace = Trace(library, options)
    assert not trace.handle
    assert trace.message == message


def test_trace_reads_columns_of_other_names(library: Any, tmp_path: Path) -> None:
    """A table of a laboratory: what is not named is not read, an axis that is not there is 0."""
    path = tmp_path / "lab.csv"
    path.write_text("t [s],comment,hand x, height,x\n0,begins,1,5,9\n2,,3,7,9\n")
    trace = Trace(library, f"file={path}\nclock=t [s]\nx=hand x\nz=height\nscale=0.5")
    assert list(trace.at(1.0).position) == [1.0, 0.0, 3.0]
    for options, words in (
        ("clock=t [s]\nx=hand y", ":1: the header lacks the column hand y"),
        ("x=hand x", ":1: the header lacks the column time"),
        ("clock=t [s]\nx=comment", ":2: there is no number in the column comment"),
    ):
        assert Trace(library, f"file={path}\n{options}").message == f"{path}{words}"
    assert [*DRIVER_OPTIONS["trace"]] == ["file", "scale", "loop", "clock", *TRACE_COLUMNS]
    first, last = TRACE_COLUMNS[:8], TRACE_COLUMNS[16:]
    assert KNOWN.startswith(", ".join(("time", *first, "button1 .. button8", *last)))


def test_trace_of_many_rows(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    times = np.linspace(0.0, 10.0, 5001)
    table = np.column_stack([times, np.sin(times), np.cos(times), 0.0 * times])
    np.savetxt(path, table, delimiter=",", header="time,x,y,z", comments="")
    trace = Trace(library, f"file={path}")
    for time in np.random.default_rng(1).uniform(0.0, 10.0, 300):
        assert trace.at(time).position[0] == pytest.approx(math.sin(time), abs=1e-6)
        assert trace.at(time).velocity[1] == pytest.approx(-math.sin(time), abs=2e-3)


_SHORT_OF_MEMORY = """
import ctypes, resource, sys
library = ctypes.CDLL(sys.argv[1])
_, name, open_ = (ctypes.c_void_p * 3).in_dll(library, "bgc_trace_driver")
open_ = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t)(open_)
message = ctypes.create_string_buffer(400)
pages = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (pages + int(sys.argv[3]), -1))
handle = open_(f"file={sys.argv[2]}".encode(), message, 400)
print("opened" if handle else message.value.decode())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the memory of a process")
@pytest.mark.parametrize("megabytes", [20, 40, 70])
def test_trace_that_does_not_fit_in_memory_is_refused(
    library: Any, tmp_path: Path, megabytes: int
) -> None:
    path = tmp_path / "hand.csv"
    padding = " " * 1_000_000
    with path.open("w") as file:
        file.write("time,x,y,z\n")
        file.writelines(f"{time},0,0,0{padding}\n" for time in range(80))
    arguments = (_SHORT_OF_MEMORY, library._name, path, str(megabytes * 1_000_000))
    done = subprocess.run(
        [sys.executable, "-c", *arguments], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"{path}: there is not enough memory\n"


def test_trace_of_more_than_the_limit_is_refused(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    path.touch()
    os.truncate(path, 256_000_001)
    assert Trace(library, f"file={path}").message == (
        f"{path}: the file is too large: at most 256 MB"
    )


_WITH_COMMA = """
import ctypes, locale, sys
locale.setlocale(locale.LC_NUMERIC, sys.argv[3])
library = ctypes.CDLL(sys.argv[1])
_, name, open_ = (ctypes.c_void_p * 3).in_dll(library, "bgc_trace_driver")
open_ = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t)(open_)
message = ctypes.create_string_buffer(400)
print(bool(open_(f"file={sys.argv[2]}\\nscale=1.5".encode(), message, 400)), message.value.decode())
"""


def test_numbers_have_a_point_in_every_locale(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    path.write_text("time,x,y,z\n0,0.5,-1.25e-3,+.5\n0.5,1,0,0\n")
    listed = subprocess.run(["locale", "-a"], capture_output=True, text=True, check=False).stdout
    comma = [name for name in listed.split() if name.startswith(("de_", "fr_"))]
    for name in ("C", *comma[:1]):
        done = subprocess.run(
            [sys.executable, "-c", _WITH_COMMA, library._name, path, name],
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout == "True \n"
    pose = Trace(library, f"file={path}\nscale=1.5").at(0.0)
    assert list(pose.position) == [0.75, -1.875e-3, 0.75]


@pytest.mark.parametrize("text", ["0x1p3", "1_0", "1.5.2", "1" * 500, "inf", ".", "e5", "--1"])
def test_what_is_not_a_decimal_number_is_refused(library: Any, tmp_path: Path, text: str) -> None:
    path = tmp_path / "hand.csv"
    path.write_text(f"time,x,y,z\n0,{text},0,0\n")
    trace = Trace(library, f"file={path}")
    assert trace.message == f"{path}:2: there is no number in the column x"


def test_a_trace_gives_its_own_velocities_and_the_bits_of_its_rows(
    library: Any, tmp_path: Path
) -> None:
    """And ignores the forces of a recording."""
    path = tmp_path / "record.csv"
    head = "time,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,fx,gripper_force\n"
    q = (0.6 + 1e-16, 0.0, 0.8, 1e-9)
    rows = [(0.1 * k, 0.3, 0, 0, *q, k / 3, 1, 2, 3, 4, k, 9, 9) for k in range(4)]
    path.write_text(head + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    trace = Trace(library, f"file={path}\n")
    for k in range(4):
        pose = trace.at(0.1 * k)
        assert tuple(pose.orientation) == q
        assert tuple(pose.velocity) == (k / 3, 1.0, 2.0)
        assert tuple(pose.angular_velocity) == (3.0, 4.0, float(k))
    assert trace.at(0.15).velocity[0] == pytest.approx(0.5)
    path.write_text("time,x,y,z,vx\n0,0,0,0,1\n")
    assert "lacks the column vy" in Trace(library, f"file={path}\n").message
