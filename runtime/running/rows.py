"""Times of the rows of a run."""

from __future__ import annotations

import math
import os
from fractions import Fraction

import numpy as np

from bgc.diagnostics.catalogue.arguments import bad_option, too_many_rows
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array

DEFAULT_ROWS = 1000
_FEWEST_INSTANTS = 4_000  # of a run, at which extremes are looked for
_LARGEST_DENOMINATOR = 10**6  # of an interval between rows


@dataclass(frozen=True, slots=True)
class RowTimes:
    """The times of the rows of a run: multiples of an interval, the last one at the end; s."""

    duration: float
    interval: float
    count: int

    def __len__(self) -> int:
        return self.count

    def between(self, first: int, last: int) -> Array:
        """The times of the rows from `first` to before `last`.

        Multiples of 0.1 are the numbers nearest to 0.2, 0.3 and so on, as fixed steps and the
        constants of a model are: in the row at 0.3 s, `time > 0.3 s` is false.
        """
        parts, whole = _fraction(self.interval)
        times = np.arange(first, last, dtype=np.float64) * parts / whole
        if last == self.count:
            times[-1] = self.duration
        return times


def _fraction(interval: float) -> tuple[float, float]:
    """The least fraction that rounds to an interval; (interval, 1) if its denominator is large."""
    least = Fraction(interval).limit_denominator(_LARGEST_DENOMINATOR)
    if float(least) == interval:
        return float(least.numerator), float(least.denominator)
    return interval, 1.0


def row_times(duration: float, every: float | None, step: float | None, columns: int) -> Array:
    """Compute the times of all rows from 0 to `duration`, both included, in s.

    Raises BgError: those of `lazy_times`, and BG068 if rows of so many `columns` exceed half of the
    memory.
    """
    times = lazy_times(duration, every, step, columns, _memory() / 2)
    return times.between(0, len(times))


def lazy_times(
    duration: float, every: float | None, step: float | None, columns: int, room: float
) -> RowTimes:
    """Find the times of all rows from 0 to `duration`, both included.

    Rows are at multiples of `every`; without it at multiples of `step`, the step of a fixed-step
    method; without both at 1,000 equal intervals. The last row is exactly at the end, even if the
    interval before it is shorter.

    Raises BgError: BG066 for times that are not positive, BG068 if rows of so many `columns`
    exceed `room`, bytes.
    """
    for name, value in (("duration (--time)", duration), ("every", every), ("step", step)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise BgError([bad_option(name, value, "a positive time in seconds")])
    if step is not None and step > duration:
        raise BgError([bad_option("step", step, f"a time within the {duration:g} s of the run")])
    interval = every or step or duration / DEFAULT_ROWS
    ratio = duration / interval
    if _bytes(ratio + 2, columns) > room:
        raise BgError([too_many_rows(round(min(ratio, 1e18)), columns + 1)])
    whole = round(ratio)
    if whole < 1 or abs(ratio - whole) > 1e-9 * ratio:
        whole = math.floor(ratio) + 1
    return RowTimes(duration, interval, whole + 1)


def with_instants(times: Array) -> tuple[Array, int]:
    """Divide the intervals between rows, s, so that extremes are found at 4,000 instants or more.

    Every row is one of the times returned, and every so many of them is a row.
    """
    between = -(-_FEWEST_INSTANTS // len(times))
    places = np.arange(between * (len(times) - 1) + 1) / between
    return np.interp(places, np.arange(len(times)), times), between


def fits(rows: int, columns: int) -> bool:
    """Return whether rows of so many columns fit in half of the memory."""
    return _bytes(rows, columns) <= _memory() / 2


def _bytes(rows: float, columns: int) -> float:
    """Bytes of rows of so many columns, times included."""
    return rows * (columns + 1) * 8


def _memory() -> float:
    """Return the bytes of the machine's memory; 8 GiB if unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return 8.0 * 2**30
