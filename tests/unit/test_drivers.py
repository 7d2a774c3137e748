"""The drivers of the runtime: udp, spring_hand, pointer, and forcedimension against a stand-in."""

from __future__ import annotations

import ctypes
import math
import socket
import struct
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from device_interface import Device, Pose
from scipy.linalg import expm

FINE, SATURATED, NO_NEWS, LOST = 0, 1, 2, -1


@pytest.fixture(scope="module")
def runtime(c_model: Any) -> Any:
    """A shared object with all drivers."""
    return c_model("handle").library


# --- spring_hand ---------------------------------------------------------------------------------


def test_the_simulated_hand_moves_as_the_linear_system_that_it_is(runtime: Any) -> None:
    m, b, k, amplitude, frequency = 0.4, 2.0, 300.0, 0.03, 1.5
    hand = Device(
        runtime, "spring_hand", mass=m, damping=b, stiffness=k, amplitude=amplitude,
        frequency=frequency, axis=2,
    )  # fmt: skip
    assert hand.can.driven == 7 and hand.can.mass == m
    w = 2 * math.pi * frequency
    # x' = A x with the wish and its rate as further states, and a held force
    a = np.zeros((5, 5))
    a[0, 1] = a[2, 3] = 1.0
    a[1] = [-k / m, -b / m, k / m, 0.0, 1.0 / m]
    a[3, 2] = -w * w
    step, x = expm(a * 1e-3), np.array([0.0, 0.0, 0.0, amplitude * w, 0.0])
    for n in range(300):
        pose = hand.read(n * 1e-3)
        assert pose.position[1] == pytest.approx(x[0], abs=1e-9)
        assert pose.velocity[1] == pytest.approx(x[1], abs=1e-7)
        x[4] = 2.0 if n % 2 else -1.5
        assert hand.write(0.0, x[4], 0.0) == FINE
        x = step @ x
    assert list(pose.position)[::2] == [0.0, 0.0]
    hand.close()


@pytest.mark.parametrize(
    "options", [{"mass": 0}, {"stiffness": -1}, {"axis": 4}, {"damping": "nan"}]
)
def test_a_hand_that_cannot_be(runtime: Any, options: dict[str, Any]) -> None:
    hand = Device(runtime, "spring_hand", **options)
    assert not hand.handle and hand.message.startswith("spring_hand: ")


# --- udp -----------------------------------------------------------------------------------------


def datagram(sequence: int, x: float, stamp: float = 0.0, head: bytes = b"BGCP") -> bytes:
    """A pose as the manual describes it."""
    pose = [x, 2.0, 3.0, 1.0, 0, 0, 0, *[0.5] * 3, *[0.0] * 3, 0.01, 1, *[0] * 7]
    return struct.pack("<4sIQd22d", head, 1, sequence, stamp, *pose)


@pytest.fixture
def link(runtime: Any) -> Iterator[tuple[Device, socket.socket, tuple[str, int]]]:
    """An open driver, the device's socket, and the address of the driver."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    device.bind(("127.0.0.1", 0))
    device.settimeout(5.0)
    stop = threading.Event()

    def first_pose() -> None:
        while not stop.wait(0.02):
            device.sendto(datagram(1, 0.25, 7.0), ("127.0.0.1", port))

    sender = threading.Thread(target=first_pose)
    sender.start()
    driver = Device(runtime, "udp", port=port, wait=20)
    stop.set()
    sender.join()
    assert driver.handle, driver.message
    yield driver, device, ("127.0.0.1", port)
    driver.close()
    device.close()


def test_datagrams_are_lost_reordered_doubled_and_foreign(
    link: tuple[Device, socket.socket, tuple[str, int]],
) -> None:
    driver, device, address = link
    driver.read()
    assert driver.read().position[0] == 0.25 and driver.answer == NO_NEWS
    assert driver.pose.stamp == 7.0 and driver.pose.buttons[0] == 1.0
    assert list(driver.pose.velocity) == [0.5] * 3
    # 5 before 3: the later one is old; 4 is lost; 5 comes twice
    for sequence in (2, 5, 3, 5):
        device.sendto(datagram(sequence, 0.1 * sequence, sequence), address)
    assert driver.read().position[0] == 0.5 and driver.answer == FINE
    for wrong in (b"", b"BGCP", datagram(9, 1.0)[:-1], datagram(9, 1.0, head=b"XGCP")):
        device.sendto(wrong, address)
    device.sendto(datagram(9, 1.0) + b"x", address)
    assert driver.read().position[0] == 0.5 and driver.answer == NO_NEWS
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.2", 0))
        other.sendto(datagram(20, 9.0), address)
    assert driver.read().position[0] == 0.5  # from another address


def test_a_flood_is_read_in_parts_and_the_force_answers_the_last_pose(
    link: tuple[Device, socket.socket, tuple[str, int]],
) -> None:
    driver, device, address = link
    driver.read()
    for sequence in range(2, 102):
        device.sendto(datagram(sequence, float(sequence)), address)
    assert driver.read().position[0] == 65.0  # 64 datagrams
    assert driver.read().position[0] == 101.0
    assert driver.write(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, time=0.5) == FINE
    head, version, sent, answered, *numbers = struct.unpack("<4sIQQ8d", device.recv(200))
    assert (head, version, sent, answered) == (b"BGCF", 1, 1, 101)
    assert numbers == [0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    device.close()  # nobody listens: as a datagram that is lost on the way
    assert [driver.write(1.0) for _ in range(3)] == [FINE] * 3
    driver.read()
    assert driver.answer == NO_NEWS


def test_a_second_client_of_a_port_is_refused_and_the_first_goes_on(
    runtime: Any, link: tuple[Device, socket.socket, tuple[str, int]]
) -> None:
    driver, device, address = link
    driver.read()
    second = Device(runtime, "udp", port=address[1], wait=0.02)
    assert not second.handle and "cannot be opened" in second.message
    device.sendto(datagram(2, 0.5), address)
    assert driver.read().position[0] == 0.5 and driver.answer == FINE


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "`port` must be"),
        ({"port": 70000}, "`port` must be"),
        ({"port": 5999, "host": "everywhere"}, "must be an address"),
        ({"port": 5998, "wait": 0.02}, "no pose from 127.0.0.1 arrived at port 5998"),
    ],
)
def test_a_link_that_cannot_be_opened(runtime: Any, options: dict[str, Any], words: str) -> None:
    driver = Device(runtime, "udp", **options)
    assert not driver.handle and words in driver.message


def test_the_work_of_a_far_force_survives_lost_datagrams(
    link: tuple[Device, socket.socket, tuple[str, int]],
) -> None:
    """Poses of version 2: held_force times the displacement of two reads is the work between."""
    driver, device, address = link
    draw = np.random.default_rng(2)
    place, work, booked, before, first = np.array([0.25, 2.0, 3.0]), 0.0, 0.0, None, 0.0
    assert driver.can.echoes == 0 and driver.can.lag == 0
    for sequence in range(2, 60):
        step = draw.normal(size=3) * 1e-3 * (sequence % 7 != 0)
        place, work = place + step, work + draw.normal(size=3) @ step
        if draw.random() < 0.4:
            continue  # lost
        pose = [*place, 1.0, 0, 0, 0, *[0.0] * 15]
        text = struct.pack("<4sIQd22dd", b"BGCP", 2, sequence, 1.0, *pose, work)
        device.sendto(text[:-8], address)  # too short for its version
        device.sendto(text, address)
        found = driver.read()
        now = np.array(found.position)
        if before is not None:
            booked += np.array(found.held_force) @ (now - before)
            assert booked == pytest.approx(work - first, abs=1e-15)
        else:
            first = work
        before = now
    assert driver.can.echoes == 1


# --- pointer -------------------------------------------------------------------------------------


def test_a_pointer_without_velocities_gets_those_of_its_positions(runtime: Any) -> None:
    pointer = Device(runtime, "pointer", smooth=0.01)
    feed = runtime.bgc_feed_pointer
    feed.argtypes, feed.restype = (ctypes.c_void_p, ctypes.c_void_p), None
    for k in range(200):
        place, unknown = (0.3e-3 * k, 0, 0), (math.nan, 0, 0)
        pose = Pose(position=place, orientation=(1, 0, 0, 0), velocity=unknown)
        feed(pointer.handle, ctypes.addressof(pose))
        found = pointer.read(k * 1e-3)
        assert pointer.answer == FINE and found.position[0] == 0.3e-3 * k
    assert found.velocity[0] == pytest.approx(0.3, rel=1e-6)
    pointer.read(0.2)
    assert pointer.answer == NO_NEWS
    # A program that knows them hands over the held force and the age, which goes on.
    feed(pointer.handle, ctypes.addressof(Pose(held_force=(1.0, 2.0, 3.0), age=0.01)))
    assert (list(pointer.read(0.3).held_force), pointer.pose.age) == ([1.0, 2.0, 3.0], 0.01)
    assert pointer.read(0.35).age == pytest.approx(0.06)
    unknown = (math.nan, 0.0, 0.0)
    feed(pointer.handle, ctypes.addressof(Pose(held_force=unknown)))
    assert (list(pointer.read(0.4).held_force), pointer.pose.age) == ([0.0] * 3, 0.0)
    assert pointer.can.driven == 0 and pointer.write(1.0) == FINE
    pointer.close()


def test_pointer_and_gamepad_differ_in_their_names_alone(runtime: Any) -> None:
    for name in ("pointer", "gamepad"):
        driver = Device(runtime, name, reach=0.08)
        assert list(driver.can.workspace_high) == [0.08] * 3 and driver.can.driven == 0
        driver.close()
        refused = Device(runtime, name, reach=-1)
        assert not refused.handle and "reach must be a positive length" in refused.message


# --- forcedimension ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sdk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sdk")
    source = Path(__file__).parent / "devices/drd.c"
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", str(source), "-lm"]
    subprocess.run(["cc", *flags, "-o", str(folder / "libdrd.so.3")], check=True)
    old = ["-DWITHOUT_AUTO_INIT", "-o", str(folder / "old.so")]
    subprocess.run(["cc", *flags, *old], check=True)
    return folder


@pytest.fixture
def drd(sdk: Path) -> Any:
    library = ctypes.CDLL(str(sdk / "libdrd.so.3"))
    for name, value in (("type", 35), ("left", 0), ("answer", 0), ("calibration", 0)):
        ctypes.c_int.in_dll(library, f"drd_{name}").value = value
    ctypes.c_int.in_dll(library, "drd_present").value = 1
    (ctypes.c_char * 4000).in_dll(library, "drd_calls").value = b""
    return library


def calls(drd: Any) -> list[str]:
    return (ctypes.c_char * 4000).in_dll(drd, "drd_calls").value.decode().split()


def test_an_omega_is_opened_read_driven_and_closed(
    runtime: Any, sdk: Path, drd: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FDSDK", str(sdk))
    omega = Device(runtime, "forcedimension")
    assert omega.handle, omega.message
    assert calls(drd) == ["drdOpen", "drdAutoInit", "drdStop(true)", "dhdEnableForce(1)"]
    can = omega.can
    assert (can.sensed, can.driven) == (127, 7 + 64)  # the wrist has no motors
    assert (can.max_force, can.max_gripper_force, can.model) == (12.0, 8.0, b"omega.7")
    position = (ctypes.c_double * 3).in_dll(drd, "drd_position")
    turn = ctypes.c_double.in_dll(drd, "drd_turn")
    for k in range(100):
        position[1], turn.value = 0.2e-3 * k, 3.0 + 2e-3 * k
        pose = omega.read(k * 1e-3)
        assert omega.answer == FINE and pose.position[1] == position[1]
        expected = [math.cos(turn.value / 2), 0, 0, math.sin(turn.value / 2)]
        same = np.dot(list(pose.orientation), expected)
        assert abs(same) == pytest.approx(1.0, abs=1e-12)
    assert pose.velocity[1] == pytest.approx(0.2, rel=1e-6)
    assert pose.angular_velocity[2] == pytest.approx(2.0, rel=1e-5)
    assert pose.gripper == 0.012 and list(pose.buttons)[:4] == [0, 0, 1, 0]
    assert omega.write(1, 2, 3, 0, 0, 0, 4) == FINE
    force = (ctypes.c_double * 7).in_dll(drd, "drd_force")
    assert list(force) == [1, 2, 3, 0, 0, 0, 4]
    ctypes.c_int.in_dll(drd, "drd_answer").value = 2
    assert omega.write(30.0) == SATURATED
    ctypes.c_int.in_dll(drd, "drd_answer").value = 1  # the time guard
    omega.read(0.1)
    assert omega.answer == FINE and omega.write(1.0) == FINE
    ctypes.c_int.in_dll(drd, "drd_answer").value = -1
    omega.read(0.101)
    assert omega.answer == LOST and omega.write(1.0) == LOST
    assert b"no device found (error 5)" in omega.driver.last_error(omega.handle)
    omega.close()
    assert list(force) == [0.0] * 7 and calls(drd)[-2:] == ["dhdStop", "dhdClose"]


def test_other_devices_of_the_family(runtime: Any, sdk: Path, drd: Any) -> None:
    library = str(sdk / "libdrd.so.3")
    for device, driven, model in ((33, 7, b"omega.3"), (104, 127, b"sigma.7"), (999, 127, b"999")):
        ctypes.c_int.in_dll(drd, "drd_type").value = device
        opened = Device(runtime, "forcedimension", library=library, id=2)
        assert opened.can.driven == driven and model in opened.can.model
        opened.close()
    ctypes.c_int.in_dll(drd, "drd_left").value = 1
    left = Device(runtime, "forcedimension", library=library)
    left.write(0, 0, 0, 0, 0, 0, 3.0)
    assert (ctypes.c_double * 7).in_dll(drd, "drd_force")[6] == -3.0
    left.close()


def test_why_a_device_of_the_maker_does_not_open(
    runtime: Any, sdk: Path, drd: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = str(sdk / "libdrd.so.3")
    ctypes.c_int.in_dll(drd, "drd_present").value = 0
    assert "no device found" in Device(runtime, "forcedimension", library=library).message
    ctypes.c_int.in_dll(drd, "drd_present").value = 1
    ctypes.c_int.in_dll(drd, "drd_calibration").value = -1
    failed = Device(runtime, "forcedimension", library=library)
    assert not failed.handle and "the calibration failed" in failed.message
    assert calls(drd)[-2:] == ["dhdStop", "dhdClose"]
    old = Device(runtime, "forcedimension", library=sdk / "old.so")
    assert not old.handle and "lacks drdAutoInit" in old.message
    absent = Device(runtime, "forcedimension", library=tmp_path / "absent.so")
    assert not absent.handle and "absent.so" in absent.message
    monkeypatch.delenv("FDSDK", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    missing = Device(runtime, "forcedimension")
    assert not missing.handle and "libdrd.so is not in $FDSDK" in missing.message
