"""States that fell below their tolerance and grew again, or stayed there: does it decide the run?

Error control does not see a state below its absolute tolerance. A state that grows again by an
instability of its own grows from what is left of it: its sign, or the time of its growth, depends
on rounding. A state that others drive does not. One that never rises above may be wrong altogether,
and so may be what it moves. To see whether it matters, the run is repeated twice, with each such
state shifted by its tolerance, up or down, when it was least, or first moved: the tolerance decides
where that moves what is observed by a tenth of its range. Of a state that stays below, a run with a
smaller tolerance has to differ too: other states may have kept the steps short enough.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager

import numpy as np

from bgc.language.solver import Solver
from bgc.record_class import dataclass, field, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import NOTHING, ParameterValue
from bgc.runtime.running.run import run_watched
from bgc.runtime.running.structures import Status

_DECIDES = 0.1  # of the range: a larger change shows that the tolerance decides
_MATTERS = 0.03  # the same of states that stay below it, which may be wrong by as much
_CURED = 0.01  # of the range: a smaller change shows that it does not
_REDUCTIONS = tuple(10.0**-k for k in (3, 6, 9, 12, 18, 30, 60, 120, 240))
_RTOL = 1e-6  # of the C runtime
_ROUNDING = 1e5 * np.finfo(float).eps  # of the scale that states have reached, as in C
_RESOLUTION = 100.0  # times the tolerance of a step: the error that a run may accumulate
_ACCOUNTS = 4  # columns at most behind the outputs
_MORE_STEPS = 50  # times those of the run, for a run with a smaller tolerance
_AT_LEAST = 10_000  # steps


@dataclass(frozen=True, slots=True)
class Subtolerance:
    """A state that fell below its tolerance at `fell`, s, and was `value` again at `grown`, s.

    One that has never risen above it moved first at both times.
    """

    index: int
    tolerance: float
    low: float
    fell: float
    grown: float
    value: float

    @property
    def stays_below(self) -> bool:
        """Test whether the state has never risen above its tolerance."""
        return self.fell == self.grown


@dataclass(frozen=True, slots=True)
class Undecided:
    """A state that rounding decides, with its value at the `end` of the run.

    `atol` is a tolerance with which it does not, and `right` the value at the end then, if known.
    """

    name: str
    subtolerance: Subtolerance
    end: float
    atol: float | None = None
    right: float | None = None


def is_repeatable(model: LoadedModel) -> bool:
    """Return whether a run can be repeated: without devices, and inputs that the caller writes."""
    info = model.library.model
    return not (info.n_device or info.n_input)


def observed_scales(model: LoadedModel) -> Array:
    """The change of each observed quantity where every state changes by its scale, at the start.

    A tolerance of the states times this is that of the quantity. Zero where there is no start.
    """
    instance = model.parameters.instance({})
    found = np.zeros(len(model.measured))
    if instance.reset(checked=False) is not Status.OK:
        return found
    _, start = instance.outputs()
    for k, size in enumerate(instance.scale.tolist()):
        present = instance.state[k]
        instance.state[k] = present + size
        _, moved = instance.outputs()
        instance.state[k] = present
        change = np.abs(moved - start)
        found += np.where(np.isfinite(change), change, 0.0)
    return found


def subtolerance_states(instance: Instance) -> tuple[Subtolerance, ...]:
    """List the states of a run that fell below their tolerance and grew again, or stayed there."""
    found = ((k, instance.subtolerance(k)) for k in range(instance.library.model.n_state))
    states = (
        Subtolerance(k, state.tolerance, state.low, state.fell, state.grown, state.value)
        for k, state in found
        if state is not None
    )
    return tuple(sorted(states, key=lambda state: state.grown))


def undecided(
    model: LoadedModel,
    method: Solver,
    instance: Instance,
    times: Array,
    rows: Array,
    parameters: Mapping[str, ParameterValue] = NOTHING,
    *,
    cure: bool = True,
) -> Undecided | None:
    """Find the state that rounding decides in a run that `instance` has finished.

    `rows` are those of the run, (n, m), at `times`, s. With `cure`, smaller tolerances are tried
    until what is observed no longer depends on them. Runs with devices, or with inputs that the
    caller writes, cannot be repeated and are not examined.
    """
    subtolerance = (
        subtolerance_states(instance) if is_repeatable(model) and not method.fixed else ()
    )
    probe = Probe(model, method, times, parameters)
    reached = instance.counts["scale_reached"]
    least = _MATTERS if any(state.stays_below for state in subtolerance) else _DECIDES
    if not subtolerance or probe.change(rows, subtolerance, reached) <= least:
        return None
    alone = (state for state in subtolerance if probe.change(rows, (state,), reached) > least)
    state = next(alone, subtolerance[0])
    value = float(instance.state_at(float(times[-1]))[state.index])
    found = Undecided(model.states[state.index].name, state, value)
    if not (cure or state.stays_below):
        return found
    steps = int(_MORE_STEPS * instance.counts["steps"]) + _AT_LEAST
    found, right = _with_cure(found, replace(probe, method=replace(method, max_steps=steps)))
    if state.stays_below and (right is None or probe.part(rows, right, (state,), reached) <= least):
        return None
    return found


def _with_cure(found: Undecided, probe: Probe) -> tuple[Undecided, Array | None]:
    """Add the tolerance with which a state is no longer decided by rounding, with the rows then.

    Of smaller and smaller ones it is the first that agrees with the one before, or else the second
    with which a shift of the state moves nothing: its error may be that of `rtol`.
    """
    before: Array | None = None
    for part in _REDUCTIONS:
        atol = float(f"{part * found.subtolerance.tolerance:.0e}")
        smaller = replace(probe, method=replace(probe.method, atol=atol))
        solved = smaller.settled(found.subtolerance)
        if solved is None:
            continue
        rows, value = solved
        ranges = np.ptp(rows, axis=0)
        if before is not None:
            away = np.max(np.abs(rows - before), axis=0, initial=0.0)
            if found.atol is None:
                found = replace(found, atol=atol, right=value)
            if (away <= _CURED * ranges).all():
                return replace(found, atol=atol, right=value), rows
        before = rows
    return found, None


@dataclass(frozen=True, slots=True, eq=False)
class Probe:
    """Repeats a run of a model, with states shifted."""

    model: LoadedModel
    method: Solver
    times: Array
    parameters: Mapping[str, ParameterValue] = field(default_factory=dict)

    def change(self, rows: Array, states: Sequence[Subtolerance], reached: float = 1.0) -> float:
        """Measure how far shifts by their tolerance move the rows, relative to each range.

        A shift with which the run fails shows nothing.
        """
        shifted = [x for x in self.shifted(states) if np.isfinite(x).all()]
        return max((self.part(rows, x, states, reached) for x in shifted), default=0.0)

    def part(
        self, rows: Array, others: Array, states: Sequence[Subtolerance], reached: float
    ) -> float:
        """Measure how far other rows are away, relative to the range of each column.

        A column whose range is below what the tolerance resolves, at states that `reached` a part
        of their scales, is noise; where states stay below it, one whose range is rounding.
        """
        observed = rows[:, : len(self.model.measured)]
        ranges, scales = np.ptp(observed, axis=0), reached * observed_scales(self.model)
        if any(state.stays_below for state in states):
            moving = ranges > _ROUNDING * scales
        else:
            ranges = np.maximum(ranges, _RESOLUTION * (self.method.rtol or _RTOL) * scales)
            moving = ranges > 0
        parts = np.abs(others - observed)[:, moving] / ranges[moving]
        return float(np.max(parts, initial=0.0))

    def shifted(self, states: Sequence[Subtolerance]) -> Iterator[Array]:
        """Compute the rows with the states shifted up, then down, by their tolerance."""
        for sign in (1.0, -1.0):
            with self._started() as instance:
                yield self._rows(instance, states, sign)[:, : len(self.model.measured)]

    def settled(self, state: Subtolerance) -> tuple[Array, float] | None:
        """Compute the rows and a state at the end, unless the tolerance decides here too."""
        with self._started() as instance:
            rows = self._rows(instance, (), 0.0)
            if not np.isfinite(rows).all():
                return None
            again = [
                subtolerance
                for subtolerance in subtolerance_states(instance)
                if subtolerance.index == state.index or subtolerance.stays_below
            ]
            value = float(instance.state_at(float(self.times[-1]))[state.index])
        if again and self.change(rows, again) > _CURED:
            return None
        return rows[:, : len(self.model.measured)], value

    def _started(self) -> AbstractContextManager[Instance]:
        return self.model.started(
            self.method, accounts=bool(self.model.accounts), parameters=self.parameters
        )

    def _rows(self, instance: Instance, states: Sequence[Subtolerance], sign: float) -> Array:
        """The rows of a run in which each state is shifted when it was least; NaN after a fault."""
        times = self.times
        rows = np.full((len(times), self.model.row_width), np.nan)
        first = 0
        for state in sorted(states, key=lambda state: state.fell):
            before = max(first, int(np.searchsorted(times, state.fell)))
            if not _run(instance, times[first:before], rows[first:before]):
                return rows
            if instance.time < state.fell and not _advance(instance, state.fell):
                return rows
            first = before
            last = int(np.searchsorted(times, instance.time, side="right"))
            if not _run(instance, times[first:last], rows[first:last]):
                return rows
            first = last
            instance.state[state.index] += sign * state.tolerance
            if instance.restart() is not Status.OK:
                return rows
        _run(instance, times[first:], rows[first:])
        return rows


def _advance(instance: Instance, time: float) -> bool:
    """Run to a time, s, or the end of a step beyond; return whether that succeeded."""
    info = instance.library.model
    return _run(instance, np.array([time]), np.empty((1, info.n_output + _ACCOUNTS)))


def _run(instance: Instance, times: Array, rows: Array) -> bool:
    """Run to all times and fill their rows; return whether that succeeded."""
    if not len(times):
        return True
    status, _, interrupted = run_watched(instance, times, rows, progress=False)
    return status is Status.OK and not interrupted
