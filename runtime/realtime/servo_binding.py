"""The servo loop of `runtime/c/servo`, as `servo.h` declares it, through ctypes."""

from __future__ import annotations

import ctypes
import os
import weakref
from ctypes import (
    CFUNCTYPE,
    POINTER,
    Structure,
    byref,
    c_char,
    c_char_p,
    c_double,
    c_int,
    c_int64,
    c_size_t,
    c_uint32,
    c_void_p,
    cast,
)
from enum import IntEnum
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import numpy as np

from bgc.building.cache import open_cache
from bgc.building.servo import build_servo
from bgc.diagnostics.catalogue.machine import cannot_load
from bgc.diagnostics.catalogue.run import no_memory
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.structures import Status

RECORD_HEAD, POSE_SIZE, EFFORT_SIZE = 3, 27, 7
"""Doubles at the start of a record, of a pose and of an effort (`servo.h`)."""
POLICIES = ("hold", "skip", "slow")
"""Overrun policies, in the order of `bgc_servo_policy`."""

_ABI = 5  # BGC_SERVO_ABI
_MESSAGE = 512  # bytes
_PATIENCE = 2.0  # s until a loop that does not end is left behind
_Fields: TypeAlias = list[tuple[str, Any]]
_MODEL_FUNCTIONS = (
    ("run", "bgc_run"),
    ("advance", "bgc_advance"),
    ("open_device", "bgc_open_device"),
    ("close_devices", "bgc_close_devices"),
    ("stop", "bgc_stop"),
    ("time", "bgc_time"),
)

NowFunction = CFUNCTYPE(c_int64, c_void_p)
SleepFunction = CFUNCTYPE(None, c_void_p, c_int64)


class End(IntEnum):
    """`bgc_servo_end`: why a loop ended."""

    RUNNING = 0
    DONE = 1
    STOPPED = 2
    MODEL = 3
    LOST = 4
    BAD_POSE = 5
    STUCK = 6
    LATE = 7
    STALLED = 8
    NO_THREAD = 9
    JUMP = 10


class RemoteState(IntEnum):
    """The state of a driver in a process of its own: `servo/shared.h`."""

    WITHOUT_POSE = -1
    STARTING = 0
    OPEN = 1
    REFUSED = 2
    FAULTY = 3
    DEAD = 4
    CLOSED = 5


class _ModelTable(Structure):
    _fields_: ClassVar[_Fields] = [
        ("m", c_void_p),
        ("d", c_void_p),
        *((name, c_void_p) for name, _ in _MODEL_FUNCTIONS),
    ]


class ClockStruct(Structure):
    """`bgc_servo_clock`: a clock in place of the system's, for tests."""

    _fields_: ClassVar[_Fields] = [("now", NowFunction), ("sleep", SleepFunction), ("of", c_void_p)]


class OptionsStruct(Structure):
    """`bgc_servo_options`."""

    _fields_: ClassVar[_Fields] = [
        ("period", c_double),
        ("deadline", c_double),
        ("duration", c_double),
        ("policy", c_int),
        ("realtime", c_int),
        ("spin", c_double),
        ("max_force", c_double),
        ("max_torque", c_double),
        ("max_gripper_force", c_double),
        ("max_force_rate", c_double),
        ("max_power", c_double),
        ("ramp", c_double),
        ("dead_man", c_int),
        ("stale", c_double),
        ("burst", c_double),
        ("watchdog", c_double),
        ("max_speed", c_double),
        ("max_turn_rate", c_double),
        ("workspace_margin", c_double),
        ("records", c_int),
    ]


class TimesStruct(Structure):
    """`bgc_servo_times`."""

    _fields_: ClassVar[_Fields] = [
        (name, c_double) for name in ("mean", "p50", "p99", "p999", "worst")
    ]


_COUNTERS = (
    *("samples", "missed", "overruns", "dropped", "skipped", "saturated", "limited", "no_news"),
    *("lost_records", "exchanges", "late_poses", "refused"),
)
_VALUES = (
    *("time", "elapsed", "behind", "gain", "worst_power", "zero_after", "lag", "fastest"),
    *("given", "created", "taken", "owed"),
)


class ReportStruct(Structure):
    """`bgc_servo_report`."""

    _fields_: ClassVar[_Fields] = [
        *((name, c_int) for name in ("end", "status", "device", "fifo", "locked")),
        *((name, c_int64) for name in _COUNTERS),
        *((name, c_double) for name in _VALUES),
        ("released", c_int),
        ("in_driver", c_int),
        ("unsettled", c_int),
        ("late_device", c_int),
        *((name, TimesStruct) for name in ("lateness", "jitter", "work")),
        ("message", c_char * 256),
    ]


class CapabilitiesStruct(Structure):
    """`bgc_capabilities`."""

    _fields_: ClassVar[_Fields] = [
        ("sensed", c_uint32),
        ("driven", c_uint32),
        *((name, c_double) for name in ("max_force", "max_torque", "max_gripper_force")),
        ("workspace_low", c_double * 3),
        ("workspace_high", c_double * 3),
        *((name, c_double) for name in ("resolution", "mass", "slowest", "fastest")),
        ("buttons", c_int),
        ("model", c_char * 64),
        ("damping", c_double),
        ("lag", c_int),
        ("echoes", c_int),
    ]


_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "bgc_servo_version": (c_uint32, ()),
    "bgc_servo_defaults": (OptionsStruct, ()),
    "bgc_servo_new": (
        c_void_p,
        (POINTER(_ModelTable), POINTER(OptionsStruct), c_int, POINTER(ClockStruct)),
    ),
    "bgc_servo_open": (c_int, (c_void_p, c_int, c_void_p, c_char_p, c_char_p, c_size_t)),
    "bgc_servo_seed": (None, (c_void_p, c_void_p)),
    "bgc_servo_take_back": (None, (c_void_p, c_void_p, c_int)),
    "bgc_servo_capabilities": (POINTER(CapabilitiesStruct), (c_void_p, c_int)),
    "bgc_servo_handle": (c_void_p, (c_void_p, c_int)),
    "bgc_servo_loop": (None, (c_void_p,)),
    "bgc_servo_start": (c_int, (c_void_p,)),
    "bgc_servo_stop": (None, (c_void_p, c_int)),
    "bgc_servo_prepare": (
        c_void_p,
        (c_void_p, POINTER(_ModelTable), POINTER(OptionsStruct), c_int, c_void_p, c_void_p),
    ),
    "bgc_servo_post": (c_int, (c_void_p, c_void_p)),
    "bgc_servo_drop": (None, (c_void_p, c_void_p)),
    "bgc_servo_join": (c_int, (c_void_p, c_double)),
    "bgc_servo_watch": (None, (c_void_p,)),
    "bgc_servo_get_report": (None, (c_void_p, POINTER(ReportStruct))),
    "bgc_servo_histogram": (c_int, (c_void_p, c_int, c_void_p, c_void_p)),
    "bgc_servo_record_size": (c_int, (c_void_p,)),
    "bgc_servo_take": (c_size_t, (c_void_p, c_void_p, c_size_t)),
    "bgc_servo_retired": (c_int, (c_void_p,)),
    "bgc_servo_next": (None, (c_void_p,)),
    "bgc_servo_free": (None, (c_void_p,)),
    "bgc_remote_share": (c_int, (c_int, c_double, c_double, c_double, c_int)),
    "bgc_remote_end": (None, (c_int,)),
    "bgc_remote_state": (c_int, (c_int, c_char_p, c_size_t)),
}


@dataclass(frozen=True, slots=True)
class ServoLibrary:
    """The shared object of the loop."""

    functions: ctypes.CDLL

    def defaults(self) -> OptionsStruct:
        """The loop's default options."""
        options = self.functions.bgc_servo_defaults()
        assert isinstance(options, OptionsStruct)
        return options

    @property
    def remote(self) -> int:
        """The address of the driver of a device whose own driver runs in another process."""
        return ctypes.addressof(c_char.in_dll(self.functions, "bgc_servo_remote"))

    def share(self, file: int, options: OptionsStruct, ahead: float) -> None:
        """Make a file ready that such a process, which reads poses `ahead`, shares with a loop."""
        silence = max(options.watchdog, 3.0 * options.period) if options.watchdog else 0.0
        given = options.period, silence, ahead, options.realtime
        if error := self.functions.bgc_remote_share(file, *given):
            raise OSError(error, os.strerror(error))

    def remote_state(self, file: int) -> tuple[RemoteState, str]:
        """The state of such a process, and the reason of a fault."""
        message = ctypes.create_string_buffer(_MESSAGE)
        state = self.functions.bgc_remote_state(file, message, _MESSAGE)
        return RemoteState(state), message.value.decode("utf-8", "backslashreplace")


def load_servo() -> ServoLibrary:
    """Compile the loop on first use, and load it.

    Raises BgError BG059 where it cannot be loaded.
    """
    path: Path = build_servo(open_cache())
    try:
        functions = ctypes.CDLL(str(path))
        for name, (result, arguments) in _FUNCTIONS.items():
            function = getattr(functions, name)
            function.restype, function.argtypes = result, arguments
    except (OSError, AttributeError) as problem:
        raise BgError([cannot_load(str(path), str(problem))]) from problem
    assert functions.bgc_servo_version() == _ABI
    return ServoLibrary(functions)


def _table_of(instance: Instance) -> _ModelTable:
    """The functions of an instance's model for the loop."""
    model = instance.library
    table = _ModelTable(cast(model.pointer, c_void_p), instance.address)
    for name, function in _MODEL_FUNCTIONS:
        setattr(table, name, cast(getattr(model.functions, function), c_void_p))
    return table


class Servo:
    """A loop on instances of models, which it keeps. `width` is that of the rows of the first."""

    def __init__(
        self,
        library: ServoLibrary,
        instance: Instance,
        options: OptionsStruct,
        width: int,
        clock: ClockStruct | None = None,
    ) -> None:
        self._instances, self._clock = [instance], clock
        self._functions = library.functions
        table = _table_of(instance)
        clock_pointer = None if clock is None else byref(clock)
        self._servo = self._functions.bgc_servo_new(
            byref(table), byref(options), width, clock_pointer
        )
        if not self._servo:
            raise BgError([no_memory()])
        # At the end of the process too, for the loop must not outlive the model that it runs.
        self._finalizer = weakref.finalize(self, _end, self._functions, self._servo)

    def __del__(self) -> None:
        if getattr(self, "_servo", None) and self.join(0.0):
            self.free()

    def open(self, index: int, driver: int, options: bytes) -> tuple[Status, str]:
        """Open a device with the driver at an address; return the driver's message too."""
        message = ctypes.create_string_buffer(_MESSAGE)
        status = self._functions.bgc_servo_open(
            self._servo, index, driver, options, message, len(message)
        )
        return Status(status), message.value.decode("utf-8", "backslashreplace")

    def seed(self, poses: Array) -> None:
        """Give the poses with which the first model starts, (devices, POSE_SIZE)."""
        self._functions.bgc_servo_seed(self._servo, poses.ctypes.data)

    def take_back(self, index: int, course: int | None = None) -> None:
        """Let the ledger of a device act; for the first course, or one that was prepared."""
        self._functions.bgc_servo_take_back(self._servo, course, index)

    def capabilities(self, index: int) -> CapabilitiesStruct:
        """The capabilities of an open device."""
        found = self._functions.bgc_servo_capabilities(self._servo, index).contents
        assert isinstance(found, CapabilitiesStruct)
        return found

    def handle(self, index: int) -> int:
        """The handle of the real driver of an open device."""
        return int(self._functions.bgc_servo_handle(self._servo, index) or 0)

    def loop(self) -> None:
        """Run the loop in this thread, without a watchdog."""
        self._functions.bgc_servo_loop(self._servo)

    def start(self) -> bool:
        """Start the threads of loop and watchdog; return whether the system gave them."""
        return bool(self._functions.bgc_servo_start(self._servo))

    def stop(self, at_once: bool = False) -> None:
        """Ask the loop to end when the force has fallen to zero, or `at_once`."""
        self._functions.bgc_servo_stop(self._servo, int(at_once))

    def prepare(
        self, instance: Instance, options: OptionsStruct, width: int, ports: list[int], poses: Array
    ) -> int:
        """Make a course of an instance, which is started after this; return its address.

        `ports` are the devices of the loop that the model's devices are, `poses` the poses that
        these have at the start, (devices, POSE_SIZE).
        """
        table, places = _table_of(instance), (c_int * max(len(ports), 1))(*ports)
        course = self._functions.bgc_servo_prepare(
            self._servo, byref(table), byref(options), width, places, poses.ctypes.data
        )
        if not course:
            raise BgError([no_memory()])
        return int(course)

    def post(self, course: int, instance: Instance) -> bool:
        """Ask the loop to go on with a course; False where another waits or the loop has ended."""
        self._instances.append(instance)
        return bool(self._functions.bgc_servo_post(self._servo, course))

    def drop(self, course: int) -> None:
        """Free a course that was not posted."""
        self._functions.bgc_servo_drop(self._servo, course)

    def join(self, seconds: float) -> bool:
        """Wait for the threads; return whether they have ended."""
        return bool(self._functions.bgc_servo_join(self._servo, seconds))

    def watch(self) -> None:
        """Do what the watchdog does in one of its periods."""
        self._functions.bgc_servo_watch(self._servo)

    def report(self) -> ReportStruct:
        """The counters and quantiles up to now."""
        report = ReportStruct()
        self._functions.bgc_servo_get_report(self._servo, byref(report))
        return report

    def histogram(self, which: int) -> Array:
        """Upper ends of classes of a time, s, and the number in each, (n, 2), without empty ones.

        `which` is 0 for lateness, 1 for jitter, 2 for work.
        """
        size = int(self._functions.bgc_servo_histogram(self._servo, which, None, None))
        ends, counts = np.empty(size), np.empty(size, dtype=np.int64)
        places = ends.ctypes.data, counts.ctypes.data
        self._functions.bgc_servo_histogram(self._servo, which, *places)
        return np.column_stack([ends, counts.astype(float)])[counts > 0]

    @property
    def record_size(self) -> int:
        """Numbers in a record of the course that the reader is at."""
        return int(self._functions.bgc_servo_record_size(self._servo))

    @property
    def is_retired(self) -> bool:
        """True once the loop writes no more records of the course that is being read."""
        return bool(self._functions.bgc_servo_retired(self._servo))

    def next(self) -> None:
        """Go on to the records of the next course, where those of this one have been taken."""
        self._functions.bgc_servo_next(self._servo)

    def take(self, most: int = 4096) -> Array:
        """Take the records of the reader's course that are ready, (n, record_size); one thread."""
        records = np.empty((most, self.record_size))
        count = self._functions.bgc_servo_take(self._servo, records.ctypes.data, most)
        return records[: int(count)]

    def free(self) -> None:
        """Set forces to zero, close the devices and free the loop, whose threads have ended."""
        if self._servo:
            self._finalizer.detach()
            self._functions.bgc_servo_free(self._servo)
            self._servo = None


def _end(functions: ctypes.CDLL, servo: int) -> None:
    """End a loop that nobody has stopped, with zero force; a thread may still take its records."""
    functions.bgc_servo_stop(servo, 0)
    if not functions.bgc_servo_join(servo, _PATIENCE):
        functions.bgc_servo_stop(servo, 1)
        functions.bgc_servo_join(servo, _PATIENCE)
