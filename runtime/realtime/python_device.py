"""Devices that are Python objects: read and driven by a thread of their own, off the servo loop."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from threading import Event, Thread
from typing import Any, Protocol, runtime_checkable

import numpy as np

from bgc.runtime.results.arrays import Array

_RATE = 200.0  # Hz at most
_CLOSING = 0.2  # s for the present call, and zero force


@runtime_checkable
class PythonDevice(Protocol):
    """An object whose `read` returns a pose as a mapping of the arguments of `Realtime.pointer`.

    `write(force, torque, gripper_force)`, if there is one, takes what the loop wrote last.
    """

    def read(self) -> Mapping[str, Any]:
        """The present pose."""


class PythonThread:
    """The thread of one object: reads it, and hands it the force, until it is stopped or fails.

    `force` returns what the loop wrote last, (7,), and the time stamp of the pose that it answers,
    None before the first sample. By these stamps the age of each pose is measured, unless the
    object gives one. `failed` is called with the reason of a fault.
    """

    def __init__(
        self,
        device: PythonDevice,
        feed: Callable[..., None],
        force: Callable[[], tuple[Array, float] | None],
        failed: Callable[[str], None],
    ) -> None:
        self._device, self._feed, self._force, self._failed = device, feed, force, failed
        self._ended = Event()
        self._thread = Thread(target=self._run, daemon=True)
        self._called = math.inf  # when the present call began, s
        self._answered = 0.0  # stamp of the pose that the force of the object answers; 0: none
        self._give()
        self._thread.start()

    def stop(self) -> None:
        """End the thread after its present call, and write zero force."""
        self._ended.set()
        self._thread.join(timeout=_CLOSING)

    def watch(self, longest: float) -> None:
        """Report a call that has not returned for `longest` seconds, once; 0: never.

        Nothing can end a thread: the object keeps the force that it was given.
        """
        if longest > 0.0 and now() - self._called > longest:
            self._called = math.inf
            self._failed(f"a call has not returned for {longest:g} s; it keeps its force")

    def _run(self) -> None:
        write = getattr(self._device, "write", None)
        try:
            while not self._ended.wait(1.0 / _RATE):
                self._called = now()
                self._give()
                if write is not None and (written := self._force()) is not None:
                    force, self._answered = written
                    write(force[:3], force[3:6], float(force[6]))
                self._called = math.inf
            if write is not None:
                write(np.zeros(3), np.zeros(3), 0.0)
        except Exception as problem:  # the object is the user's: any error ends the loop
            self._failed(f"{type(problem).__name__}: {problem}")

    def _give(self) -> None:
        pose = dict(self._device.read())
        measured = pose.setdefault("stamp", now())
        if self._answered > 0.0:
            pose.setdefault("age", measured - self._answered)
        self._feed(**pose)


def now() -> float:
    """The time stamp of a pose that is measured now, s."""
    return time.monotonic()
