"""Records of a servo loop: their columns, and tables that `trace` plays again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from io import FileIO
from pathlib import Path
from threading import Lock

import numpy as np

from bgc.runtime.realtime.servo_binding import EFFORT_SIZE, POSE_SIZE, RECORD_HEAD
from bgc.runtime.results.arrays import Array

_POSE = (
    *("x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz", "gripper"),
    *(f"button{k}" for k in range(1, 9)),
)
_EFFORT = ("fx", "fy", "fz", "tx", "ty", "tz", "gripper_force")
_HELD = ("hx", "hy", "hz", "age")
POSE_STAMP = len(_POSE)
"""Place of the time stamp in a pose."""
_DEVICE_SIZE = POSE_SIZE + 2 * EFFORT_SIZE


def rows_of(records: Array, devices: int) -> Array:
    """The model's rows in records, (n, width)."""
    return records[:, RECORD_HEAD + devices * _DEVICE_SIZE :]


def poses_of(records: Array, device: int) -> Array:
    """Poses of a device, (n, 22): position, orientation, velocities, gripper, buttons."""
    first = RECORD_HEAD + device * _DEVICE_SIZE
    return records[:, first : first + len(_POSE)]


def whole_poses_of(records: Array, device: int) -> Array:
    """Poses of a device with their time stamps, (n, 27), as `bgc_pose` has them."""
    first = RECORD_HEAD + device * _DEVICE_SIZE
    return records[:, first : first + POSE_SIZE]


def forces_of(records: Array, device: int) -> Array:
    """Force, torque and gripper force that were written to a device, (n, 7)."""
    first = RECORD_HEAD + device * _DEVICE_SIZE + POSE_SIZE + EFFORT_SIZE
    return records[:, first : first + EFFORT_SIZE]


def held_of(records: Array, device: int) -> Array:
    """Force that the hand held between a sample and the one before, and its age, (n, 4)."""
    end = RECORD_HEAD + device * _DEVICE_SIZE + POSE_SIZE
    return records[:, end - len(_HELD) : end]


class Kept:
    """The last records of a loop, at least `keep` of them once they are there; for any thread."""

    def __init__(self, keep: int, width: int) -> None:
        self._keep, self._width = keep, width
        self._parts, self._lock = list[Array](), Lock()
        self.latest: Array | None = None

    def add(self, records: Array) -> None:
        """Append records; those of long ago are forgotten."""
        with self._lock:
            self._parts.append(records)
            self.latest = records[-1:]
            if sum(map(len, self._parts)) > 2 * self._keep:
                self._join()

    def forget(self, width: int) -> None:
        """Forget all: those that follow are those of another model."""
        with self._lock:
            self._parts, self.latest, self._width = [], None, width

    def all(self) -> Array:
        """The records that are kept, (n, width); of a loop that has ended too."""
        with self._lock:
            if len(self._parts) > 1:
                self._join()
            return self._parts[0] if self._parts else np.empty((0, self._width))

    def _join(self) -> None:
        self._parts = [np.concatenate(self._parts)[-self._keep :]]


class Recorder:
    """Writes the motion of each device to a table; a fault of the disk ends it, and not the loop.

    The table of one device is `path`, those of several `path` with the device's name behind the
    stem. Numbers have all their digits, so that `trace` gives back the same bits. A table that ends
    early ends with a whole row.
    """

    def __init__(self, path: Path, devices: Sequence[str]) -> None:
        several = len(devices) > 1
        self.paths = [
            path.with_stem(f"{path.stem}_{name}") if several else path for name in devices
        ]
        self.problem = None if devices else (str(path), "the scene has no device")
        self._files: list[FileIO] = []
        self._whole: list[int] = []  # bytes of whole rows in each
        self._guarded(str(path), self._open)

    def write(self, records: Array) -> None:
        """Append records, unless a fault has ended the recording."""
        if self.problem is None:
            self._guarded(str(self.paths[0]), lambda: self._write(records))

    def close(self) -> None:
        """Close the tables."""
        files, self._files = self._files, []
        for file in files:
            self._guarded(file.name, file.close)

    def _open(self) -> None:
        for path in self.paths:
            self._files.append(path.open("wb", buffering=0))
            self._whole.append(0)
            self._append(-1, ",".join(("time", *_POSE, *_HELD, *_EFFORT)) + "\n")

    def _write(self, records: Array) -> None:
        for device in range(len(self._files)):
            parts = [of(records, device).tolist() for of in (poses_of, held_of, forces_of)]
            lines = []
            for time, *row in zip(records[:, 0].tolist(), *parts, strict=True):
                numbers = (time, *(number for part in row for number in part))
                lines.append(",".join(map(repr, numbers)) + "\n")
            self._append(device, "".join(lines))

    def _append(self, device: int, lines: str) -> None:
        """Append whole lines to a table; where that fails, none of them is kept in part."""
        file, rest = self._files[device], memoryview(lines.encode())
        try:
            while rest:
                rest = rest[file.write(rest) :]
        except OSError:
            written = lines.encode()[: len(lines) - len(rest)]
            with suppress(OSError):  # a device file has no length
                file.truncate(self._whole[device] + written.rfind(b"\n") + 1)
            raise
        self._whole[device] += len(lines)

    def _guarded(self, path: str, work: Callable[[], object]) -> None:
        try:
            work()
        except OSError as problem:
            self.problem = self.problem or (path, problem.strerror or str(problem))
