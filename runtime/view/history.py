"""The rows of a session, for clients that arrive later."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from bgc.runtime.results.arrays import Array

Rows = NDArray[np.float32]
TIMES: Final = 2  # columns before those of the model: a time in s is the sum of both


def as_rows(times: Array, values: Array) -> Rows:
    """Make rows of times, s, (n,), and values, (n, width), as float32.

    A time is split into a rounded number and the remainder, which are exact to 1e-14 of it.
    """
    rows = np.empty((len(times), TIMES + values.shape[1]), np.float32)
    rows[:, 0] = times
    rows[:, 1] = times - rows[:, 0].astype(np.float64)
    with np.errstate(over="ignore"):  # a value beyond the range of a float32 is drawn as infinite
        rows[:, TIMES:] = values
    return rows


class History:
    """Rows since the last reset, in a bounded amount of memory.

    When the memory is full, every second row is dropped: the whole session stays, more coarsely.
    """

    def __init__(self, width: int, limit: int = 48_000_000) -> None:
        """Hold rows of `width` columns in at most `limit` bytes."""
        self._most = max(256, limit // (4 * width))
        self._rows = np.empty((256, width), np.float32)
        self._count = 0

    @property
    def rows(self) -> Rows:
        """The rows so far, a view."""
        return self._rows[: self._count]

    def clear(self) -> None:
        """Drop all rows."""
        self._count = 0

    def append(self, rows: Rows) -> None:
        """Add rows at the end."""
        for start in range(0, len(rows), 256):
            self._append(rows[start : start + 256])

    def _append(self, rows: Rows) -> None:
        if self._count + len(rows) > len(self._rows):
            self._make_room()
        self._rows[self._count : self._count + len(rows)] = rows
        self._count += len(rows)

    def _make_room(self) -> None:
        if 2 * len(self._rows) <= self._most:
            larger = np.empty((2 * len(self._rows), self._rows.shape[1]), np.float32)
            larger[: self._count] = self.rows
            self._rows = larger
            return
        kept = self.rows[::2].copy()
        self._count = len(kept)
        self._rows[: self._count] = kept
