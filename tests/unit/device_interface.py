"""The structures of `runtime/c/bgc_device.h`, for tests that call a driver directly."""

from __future__ import annotations

import ctypes


class Pose(ctypes.Structure):
    _fields_ = (
        ("position", ctypes.c_double * 3),
        ("orientation", ctypes.c_double * 4),
        ("velocity", ctypes.c_double * 3),
        ("angular_velocity", ctypes.c_double * 3),
        ("gripper", ctypes.c_double),
        ("buttons", ctypes.c_double * 8),
        ("stamp", ctypes.c_double),
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
