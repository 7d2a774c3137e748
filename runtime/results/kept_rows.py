"""A selection of the rows of a long run, whose rows go to a file."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array, Mask

MOST_VALUES = 1 << 21
"""Numbers that a result holds in memory, times included; runs with more keep a selection."""

SELECTED_VALUES = 1 << 19
"""Numbers of a selection."""

_GROUPS = 2000  # more than a plot has pixels across

_Places = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Some rows with their numbers in the run and their times, s."""

    numbers: _Places
    times: Array
    rows: Array

    def __getitem__(self, places: _Places | Mask | slice) -> _Part:
        return _Part(self.numbers[places], self.times[places], self.rows[places])


class KeptRows:
    """Rows at equal intervals, and those at which a column is least or largest in its interval.

    So a plot and the table of extremes of the selection are those of all rows. The first rows that
    are not finite are among them, and the last row. Where a model has so many columns that a row
    for each extreme would take more than half of the memory, rows at equal intervals alone are
    kept.
    """

    def __init__(self, count: int, width: int) -> None:
        """Select among at most `count` rows of `width` columns."""
        rows = max(2, SELECTED_VALUES // (width + 1))
        groups = min(_GROUPS, rows // 2 // max(1, 2 * width))
        self._stride = -(-count // max(1, rows - 2 * width * groups))
        self._length = -(-count // groups) if groups else 0
        self._seen = 0
        self.width = width
        nothing = _Part(np.empty(0, dtype=np.intp), np.empty(0), np.empty((0, width)))
        self._kept: list[_Part] = [nothing]
        self._open = self._last = nothing

    def add(self, times: Array, rows: Array) -> None:
        """Select among the next rows, which the caller may overwrite afterwards."""
        first, self._seen = self._seen, self._seen + len(times)
        numbers = np.arange(first, self._seen)
        part = _Part(numbers, times, rows)
        self._kept.append(part[numbers % self._stride == 0])
        self._last = part[np.array([len(times) - 1])]
        start = 0
        while self._length and start < len(times):
            end = min(len(times), start + self._length - (first + start) % self._length)
            joined = _joined([self._open, part[slice(start, end)]])
            self._open = joined[_extremes(joined.rows)]
            if (first + end) % self._length == 0:
                self._kept.append(self._open)
                self._open = self._open[slice(0)]
            start = end

    def selection(self) -> tuple[Array, Array]:
        """The times of the rows that are kept, s, (n,), and the rows, (n, width)."""
        found = _joined([*self._kept, self._open, self._last])
        _, places = np.unique(found.numbers, return_index=True)
        return found.times[places], found.rows[places]


def _joined(parts: list[_Part]) -> _Part:
    return _Part(
        np.concatenate([part.numbers for part in parts]),
        np.concatenate([part.times for part in parts]),
        np.concatenate([part.rows for part in parts]),
    )


def _extremes(rows: Array) -> _Places:
    """The rows at which a column is least or largest, or not finite for the first time.

    Of a column with values that are not finite the last finite one is kept, too.
    """
    finite = np.isfinite(rows)
    if finite.all():
        return np.unique(np.concatenate((rows.argmax(axis=0), rows.argmin(axis=0))))
    found = (
        np.where(finite, rows, -np.inf).argmax(axis=0),
        np.where(finite, rows, np.inf).argmin(axis=0),
        finite.argmin(axis=0),
        len(rows) - 1 - finite[::-1].argmax(axis=0),
    )
    return np.unique(np.concatenate(found))
