"""Several instances in the lanes of one vector register: the C interface."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import POINTER, byref, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Library
from bgc.runtime.running.structures import Status

_Doubles = POINTER(c_double)


class LaneLibrary(Library):
    """A loaded shared object that was compiled with lanes.

    `width` is the number of instances in a batch: the doubles of a vector register.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        arrays = (_Doubles, c_size_t, POINTER(_Doubles), POINTER(c_uint))
        instances = (type(self.pointer), POINTER(c_void_p), c_int)
        self._declare("bgc_lane_width", c_int, ())
        self._declare("bgc_run_lanes", c_int, (*instances, *arrays))
        self.width = int(self.functions.bgc_lane_width())

    def run(
        self, batch: Sequence[Instance], times: Array, rows: Sequence[Array]
    ) -> tuple[Status, list[bool]]:
        """Run instances in lockstep to all times; return which of them have all their rows.

        The instances have been reset and have the same options; `rows` has an array for each. An
        instance without all its rows must be reset and run alone. The interpreter lock is
        released: another thread may call `stop` of the first instance.
        """
        assert 0 < len(batch) == len(rows) <= self.width
        assert all(each.flags.c_contiguous and len(each) == len(times) for each in rows)
        finished = c_uint(0)
        status = self.functions.bgc_run_lanes(
            self.pointer,
            (c_void_p * len(batch))(*(instance.address for instance in batch)),
            len(batch),
            times.ctypes.data_as(_Doubles),
            len(times),
            (_Doubles * len(rows))(*(each.ctypes.data_as(_Doubles) for each in rows)),
            byref(finished),
        )
        return Status(status), [bool(finished.value >> k & 1) for k in range(len(batch))]
