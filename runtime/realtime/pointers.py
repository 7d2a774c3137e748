"""Devices of a loop that take their poses from a program: the drivers `pointer` and `gamepad`."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

from bgc.diagnostics.catalogue.realtime import no_pointer
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.realtime.servo_binding import Servo
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.device_drivers import FoundDriver
from bgc.runtime.running.poses import FED


class Pointers:
    """The pointers among the devices of a loop, in the order of its model.

    `instance` is that of the first model, whose drivers the loop has.
    """

    def __init__(self, servo: Servo, found: Sequence[FoundDriver], instance: Instance) -> None:
        self._servo = servo
        self._names = tuple(device.name for device in found)
        self._fed = [k for k, device in enumerate(found) if device.driver in FED]
        self._instance = instance

    def index(self, device: str | None) -> int:
        """The place of a pointer; of the only one without a name. Raises BgError BG777."""
        wanted = [k for k in self._fed if device in (None, self._names[k])]
        if len(wanted) != 1:
            raise BgError([no_pointer(device, [self._names[k] for k in self._fed])])
        return wanted[0]

    def feed(self, index: int, words: Array) -> None:
        """Hand a pose to a device, as `pose_words` arranges it."""
        give = self._instance.library.functions.bgc_feed_pointer
        handle = ctypes.c_void_p(self._servo.handle(index))
        give(handle, words.ctypes.data_as(ctypes.POINTER(ctypes.c_double)))
