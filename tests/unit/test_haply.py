"""The driver `haply` against a stand-in of the Inverse Service, and its faults in a loop."""

from __future__ import annotations

import ctypes
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from device_interface import Device
from inverse_service import InverseService

from bgc.building.build import runtime_directory
from bgc.runtime.realtime.device_discovery import find_all

FINE, NO_NEWS, LOST = 0, 2, -1


@pytest.fixture(scope="module")
def runtime(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The driver alone, which needs nothing of the runtime."""
    made = tmp_path_factory.mktemp("haply") / "haply.so"
    folder = runtime_directory()
    flags = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", f"-I{folder}"]
    source = str(folder / "drivers/haply.c")
    defined = ["-D_POSIX_C_SOURCE=200809L", "-o", str(made), source, "-lm"]
    subprocess.run(["cc", *flags, *defined], check=True)
    return ctypes.CDLL(str(made))


def opened(runtime: Any, service: InverseService, **options: Any) -> Device:
    """A driver of the service, which has read the answer to its first message."""
    device = Device(runtime, "haply", port=service.port, **options)
    device.answer = NO_NEWS
    if device.handle:
        read_until(device, FINE)
    return device


@pytest.fixture
def serve(runtime: Any) -> Iterator[Callable[..., tuple[InverseService, Device]]]:
    services: list[InverseService] = []

    def begin(*devices: str, fault: str = "", **options: Any) -> tuple[InverseService, Device]:
        service = InverseService(devices or ("04C3",), fault)
        services.append(service)
        return service, opened(runtime, service, **options)

    yield begin
    for service in services:
        service.stop()


def read_until(device: Device, answer: int) -> bool:
    """Read until there is such an answer, at most 5 s."""
    end = time.monotonic() + 5.0
    while device.answer != answer and time.monotonic() < end:
        device.read()
    return device.answer == answer


def answered(device: Device, force: float) -> None:
    """Write a force, and read the state that answers it."""
    device.answer = NO_NEWS
    assert device.write(force) == FINE and read_until(device, FINE)


@pytest.mark.parametrize("fault", ["", "in_parts", "ping", "flood"])
def test_a_force_is_sent_and_the_state_that_answers_it_is_read(serve: Any, fault: str) -> None:
    service, device = serve("0001", "04C3", fault=fault, id="04C3")
    assert device.handle, device.message
    assert device.can.driven == device.can.sensed == 7
    service.position = [0.0125, -1.5e-7, 3e-2]
    device.read()
    assert device.answer == NO_NEWS  # one answer for each message
    assert device.write(1.5, -2.0000004, 3e-7) == FINE
    assert read_until(device, FINE)
    assert list(device.pose.position) == pytest.approx([0.0125, -1.5e-7, 0.03], rel=1e-14)
    assert list(device.pose.velocity) == [0.25, -1e-3, 0.0]
    assert service.force == [1.5, -2.0, 0.0]
    first, last = service.messages[0], service.messages[-1]
    assert "session" in first and "session" not in last  # the handshake comes once
    (command,) = last["inverse3"]
    assert command["device_id"] == "04C3"
    assert command["commands"]["set_cursor_force"]["execute"] is True
    device.close()
    assert service.closed.wait(5.0) and service.force == [0.0] * 3  # which the service holds
    assert fault != "ping" or service.pongs[0] == b"alive"


def test_the_age_is_the_time_since_the_state_that_the_held_force_answers(serve: Any) -> None:
    """A state comes with the force of the message before; the clock of the test encloses both."""
    _, device = serve()
    before = time.monotonic()
    for pause in (0.02, 0.0):
        answered(device, 1.0)
        after = time.monotonic()
        time.sleep(pause)
        asked = time.monotonic()
        answered(device, 2.0)
        age = device.pose.age
        assert max(asked - after, 1e-9) <= age <= time.monotonic() - before
        before = asked
    device.read()
    assert device.answer == NO_NEWS and device.pose.age > age  # a state that becomes old
    device.close()
    _, device = serve(fault="flood")
    for _ in range(250):
        answered(device, 1.0)  # 200 states are not those of one force, nor later of others
    assert device.pose.age == 0.0
    device.close()


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("unplugged", "no such device any more"),
        ("closed", "closed the connection"),
        ("torn", "not one of its own"),
        ("not_json", "no position"),
    ],
)
def test_a_service_that_fails(serve: Any, fault: str, words: str) -> None:
    service, device = serve(fault=fault)
    device.write(1.0)
    assert read_until(device, LOST)
    assert words in device.driver.last_error(device.handle).decode()
    device.close()
    assert service.closed.wait(5.0)


def test_a_service_that_stands_still_gives_no_news(serve: Any) -> None:
    service, device = serve(fault="silent")
    device.write(1.0)
    assert [(device.read(), device.answer)[1] for _ in range(3)] == [NO_NEWS] * 3
    device.close()
    assert service.closed.wait(5.0) and service.force == [0.0] * 3


@pytest.mark.parametrize(
    ("devices", "options", "words"),
    [
        ((), {"fault": "no_websocket"}, "not an Inverse Service"),
        (("04C3",), {"id": "0009"}, "no device with the id 0009"),
        (("",), {}, "gave its device no id"),
    ],
)
def test_why_the_device_does_not_open(
    serve: Any, devices: tuple[str, ...], options: dict[str, Any], words: str
) -> None:
    _, device = serve(*devices, **options)
    assert not device.handle and words in device.message


def test_no_service_and_no_device(runtime: Any) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    absent = Device(runtime, "haply", port=port)
    assert not absent.handle and "start the Haply Hub" in absent.message
    assert "`port` must be" in Device(runtime, "haply", port=0).message
    with socket.create_server(("127.0.0.1", 0)) as mute:  # accepts, and says nothing
        silent = Device(runtime, "haply", port=mute.getsockname()[1], wait=0.02)
        assert not silent.handle and "not an Inverse Service" in silent.message
    empty = InverseService(devices=())
    none = Device(runtime, "haply", port=empty.port)
    assert not none.handle and "no Inverse3" in none.message
    empty.stop()
    (finding,) = [found for found in find_all() if found.name == "haply"]
    assert finding.usable or "10001" in finding.text


def test_texts_that_are_no_json_give_no_value(runtime: Any) -> None:
    """Cut anywhere, a message has the whole state or none; nothing is read behind its end."""
    service = InverseService()
    device = opened(runtime, service)
    text = b'{"inverse3":[{"device_id":"04C3","state":{"cursor_velocity":{"x":1,"y":2,"z":3},'
    text += b'"cursor_position":{"x":-4.5e-1,"y":5E0,"z":6.25}}}]}'
    for length in (*range(0, len(text) - 1, 11), len(text) - 1, len(text)):
        service._send(text[:length])
        device.answer = NO_NEWS
        while device.answer == NO_NEWS:
            device.read()
        whole = length >= len(text) - 1  # the last bracket is never read
        assert device.answer == (FINE if whole else LOST), text[:length]
        if whole:
            assert list(device.pose.position) == [-0.45, 5.0, 6.25]
        else:  # the frame that failed is still there
            device.close()
            service.stop()
            service = InverseService()
            device = opened(runtime, service)
    device.close()
    service.stop()
