"""The structures of `runtime/c/bgc_device.h`, for tests that call a driver directly."""

from __future__ import annotations

import ctypes
from typing import Any

from bgc.runtime.realtime.servo_binding import CapabilitiesStruct


class Pose(ctypes.Structure):
    _fields_ = (
        ("position", ctypes.c_double * 3),
        ("orientation", ctypes.c_double * 4),
        ("velocity", ctypes.c_double * 3),
        ("angular_velocity", ctypes.c_double * 3),
        ("gripper", ctypes.c_double),
        ("buttons", ctypes.c_double * 8),
        ("stamp", ctypes.c_double),
        ("held_force", ctypes.c_double * 3),
        ("age", ctypes.c_double),
    )


class Driver(ctypes.Structure):
    _fields_ = (
        ("abi", ctypes.c_uint32),
        ("name", ctypes.c_char_p),
        (
            "open",
            ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t),
        ),
        ("read", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p)),
        (
            "write",
            ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p),
        ),
        ("close", ctypes.CFUNCTYPE(None, ctypes.c_void_p)),
        ("capabilities", ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)),
        ("last_error", ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.c_void_p)),
    )


class Device:
    """An open driver of the runtime, used directly."""

    def __init__(self, runtime: Any, name: str, **options: Any) -> None:
        self.driver = Driver.in_dll(runtime, f"bgc_{name}_driver")
        message = ctypes.create_string_buffer(400)
        lines = "".join(f"{key}={value}\n" for key, value in options.items())
        self.handle = self.driver.open(lines.encode(), message, 400)
        self.message = message.value.decode()
        self.pose, self.answer = Pose(), 0

    def read(self, time: float = 0.0) -> Pose:
        self.pose = Pose(orientation=(1.0, 0.0, 0.0, 0.0))
        self.answer = self.driver.read(self.handle, time, ctypes.addressof(self.pose))
        return self.pose

    def write(self, *effort: float, time: float = 0.0) -> int:
        values = (ctypes.c_double * 7)(*effort)
        return int(self.driver.write(self.handle, time, ctypes.addressof(values)))

    @property
    def can(self) -> CapabilitiesStruct:
        found = CapabilitiesStruct()
        self.driver.capabilities(self.handle, ctypes.addressof(found))
        return found

    def close(self) -> None:
        self.driver.close(self.handle)
