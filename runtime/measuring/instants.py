"""Instants at which runs are compared: the rows of a scene, and what lies between them.

A solution may do between two rows what none of them shows: a jump of van der Pol's oscillator lasts
a millionth of its period. An accurate run takes short steps there, so its steps say where to look.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field
from bgc.runtime.measuring.timed_run import Run, timed_run
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.rows import RowTimes
from bgc.runtime.running.run import with_capped_step
from bgc.runtime.running.structures import Status
from bgc.runtime.running.subtolerance import Probe, is_repeatable

_MOST_INSTANTS = 20_000  # besides the rows
_MOST_VALUES = 4_000_000  # of all columns at them
_JUMP = 1e-6  # of the range of a column: a larger change within no time is a jump
_JUMP_SHIFT = 1e-3  # of the duration, and half a row: by which a jump may come at another time
_LOOK_EVERY = 64  # steps

_NONE = np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class Instants:
    """Times at which runs are compared, s, ascending, and the jumps of the observed values.

    A value that jumps is compared with both its sides near a jump, `before` and `after` (k, m) at
    the times `jumps`, up to `near` seconds away: no two methods jump at the same instant. NaN in a
    column that does not jump. `rows` are the places of the rows of the scene among the instants.
    """

    times: Array
    rows: NDArray[np.intp]
    jumps: Array = field(default_factory=lambda: _NONE)
    before: Array = field(default_factory=lambda: _NONE)
    after: Array = field(default_factory=lambda: _NONE)
    near: float = 0.0

    @property
    def at_rows(self) -> Instants:
        """The rows alone."""
        return only_rows(self.times[self.rows])

    def capped(self, model: LoadedModel, method: Solver) -> Solver:
        """The method with the longest step that it has in a run to the rows alone."""
        duration = float(self.times[-1])
        count = len(self.rows)
        rows = RowTimes(duration, duration / max(count - 1, 1), count)
        return with_capped_step(method, rows, model.facts.timed)

    def run(self, model: LoadedModel, method: Solver, **limits: Any) -> Run:
        """Run a model to all instants, with the steps of a run to the rows; see `timed_run`."""
        return timed_run(model, self.capped(model, method), self.times, **limits)

    def probe(self, model: LoadedModel, method: Solver, run: Run) -> Probe | None:
        """A probe of the states of a run that fell below their tolerance.

        None where there are none, or where the run cannot be repeated.
        """
        if not run.subtolerance or not is_repeatable(model):
            return None
        return Probe(model, self.capped(model, method), self.times)

    def errors(self, values: Array, reference: Array) -> tuple[float, ...]:
        """The largest absolute difference of each column of two runs, (n, m), in its unit."""
        away = np.abs(values - reference)
        if len(self.jumps):
            middles = (self.jumps[1:] + self.jumps[:-1]) / 2
            nearest = np.searchsorted(middles, self.times)
            close = np.flatnonzero(np.abs(self.times - self.jumps[nearest]) <= self.near)
            for side in (self.before, self.after):
                beside = np.abs(values[close] - side[nearest[close]])
                away[close] = np.fmin(away[close], beside)
        return tuple(np.max(away, axis=0).tolist())


def only_rows(times: Array) -> Instants:
    """Instants that are all rows, s."""
    return Instants(times, np.arange(len(times)))


def instants_of(
    model: LoadedModel,
    rows: Array,
    methods: Sequence[Solver],
    limit: float,
    watch: Callable[[float], None] = lambda reached: None,
) -> Instants:
    """Take the rows of a scene, s, and two instants in each step of an accurate run.

    The run is that of the first of the methods that completes it; all together take at most `limit`
    seconds, behind which the rows are alone. At most 20,000 instants are added, evenly thinned.
    """
    end = time.monotonic() + limit
    for method in methods:
        with np.errstate(all="ignore"):
            found = _of_steps(model, rows, method, end, watch)
        if found is not None:
            return found
    return only_rows(rows)


def _of_steps(
    model: LoadedModel, rows: Array, method: Solver, end: float, watch: Callable[[float], None]
) -> Instants | None:
    """Step through a run; None where it fails."""
    width = len(model.measured)
    duration = float(rows[-1])
    most = max(0, min(_MOST_INSTANTS, _MOST_VALUES // max(width, 1) - len(rows)))
    instants: list[float] = []
    jumps: list[tuple[float, Array, Array]] = []
    low, high = np.full(width, np.inf), np.full(width, -np.inf)
    capped = with_capped_step(method, rows, model.facts.timed)
    try:
        with model.started(capped, accounts=False) as instance:
            before: Array | None = None
            start, slack, steps = 0.0, 1e-12 * duration, 0
            while start < duration:
                # A step, and the values behind its start and before its end.
                after = np.empty((1, width))
                status, _ = instance.run(np.array([start + slack]), after)
                stop = instance.time
                slack = max(2e-9 * (stop - start), 1e-14 * stop)
                sides = np.empty((1, width))
                if status is Status.OK:
                    status, _ = instance.run(np.array([stop - slack]), sides)
                if status is not Status.OK:
                    return None
                low, high = np.fmin(low, after[0]), np.fmax(high, after[0])
                if before is not None and len(jumps) < most:
                    large = np.abs(after[0] - before) > _JUMP * (high - low)
                    if large.any():
                        one, other = (np.where(large, s, np.nan) for s in (before, after[0]))
                        jumps.append((start, one, other))
                # Inside the step: at its ends, sampled values may be those before or after.
                instants += ((3 * start + stop) / 4, (start + 3 * stop) / 4)
                before, start, steps = sides[0], stop, steps + 1
                if steps % _LOOK_EVERY == 0:
                    watch(start)
                    if time.monotonic() > end:
                        break
    except BgError:
        return None
    added = np.array([t for t in instants if t < duration])
    added = added[:: max(1, -(-len(added) // most))] if most else _NONE
    times = np.union1d(rows, added)
    return Instants(
        times,
        np.searchsorted(times, rows),
        np.array([t for t, *_ in jumps]),
        np.array([side for _, side, _ in jumps]),
        np.array([side for *_, side in jumps]),
        min(_JUMP_SHIFT * duration, duration / (2 * max(len(rows) - 1, 1))),
    )
