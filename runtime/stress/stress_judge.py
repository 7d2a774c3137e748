"""The judgement of one point of the map: a run, its reference, and the verdict."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from bgc.language.solver import Solver
from bgc.record_class import dataclass, field, replace
from bgc.runtime.measuring.agreement import (
    AT_THE_REFERENCE,
    METHODS,
    RTOLS,
    Agreement,
    agreements,
)
from bgc.runtime.measuring.instants import Instants, instants_of, only_rows
from bgc.runtime.measuring.judging import Accuracy, combined, quantities_of
from bgc.runtime.measuring.timed_run import Run
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.result import unbalanced
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.subtolerance import observed_scales
from bgc.runtime.stress.unresolved_modes import ringing_at_start

WRONG = 0.1  # of the range: larger errors make a number useless
_OF_TOLERANCE = 100.0  # times the tolerance of a step: the error that a run may accumulate
_SMALLEST_RANGE = 0.01  # of the size of a quantity
DEFAULT_RTOL = 1e-6  # of the C runtime

_BOUNDED = 2.0  # times the range: a larger error leaves it, so that the method is not stable
UNSTABLE = "unstable: the method amplifies its own errors"
INACCURATE = "inaccurate: the method is stable, its step or tolerance too coarse"
_MOVED = "a start moved by 1e-8 of the states ends elsewhere: the solution is unstable"
_UNSTABLE = "the reference changes with its step: the solution is unstable"
_METHODS = METHODS[:3]
_RTOLS = RTOLS[:2]
_AGREED = 0.1  # of the acceptable error: the largest difference of two references
_SHORT_STEPS = 1000  # of a run
_STEPS_PER_PERIOD = 4.0  # of a method that resolves an oscillation
_OF_WALL_TIME = 10.0  # times its processor time that a run may wait for the machine


Settings = tuple[tuple[str, float], ...]
"""The driven values of a point, by the names of the drives."""


class Verdict(Enum):
    """The verdict on a point."""

    HOLDS = "holds"
    DEGRADED = "degraded"  # the error is larger than acceptable
    WARNED = "warned"  # the numbers are useless, and the run warns
    WRONG = "wrong"  # the numbers are useless, and the run does not warn
    FAILS = "fails"  # the run ended with an error
    SLOW = "too slow"  # stopped by the limit on its time
    UNJUDGED = "unjudged"  # completed, but two references do not agree


@dataclass(frozen=True, slots=True)
class Judgement:
    """A verdict, with the relative error; None if there is none.

    `residual` is the energy residual over the energy exchanged, if the scene observes accounts.
    """

    verdict: Verdict
    error: float | None = None
    residual: float | None = None
    message: str = ""


@dataclass(slots=True)
class References:
    """Solutions of one point by method and tolerance, as far as they were needed.

    `instants` are those at which they are compared.
    """

    instants: Instants | None = None
    runs: dict[tuple[str, float], Run] = field(default_factory=dict)
    moved: Run | None = None


def judge(
    model: LoadedModel,
    method: Solver,
    rows: Array,
    tolerance: Accuracy,
    limit: float,
    references: References,
) -> Judgement:
    """Run a model with its present parameters to the times of rows, s, and between; judge it.

    `limit` bounds each run, s of processor time. `references` are earlier solutions for the same
    parameters and times. A run that fails is not judged between its rows.
    """
    judge = Judge(model, only_rows(rows), tolerance, limit, references)
    run = judge.run(method, accounts=bool(model.accounts))
    if run.status == "done":
        if references.instants is None:
            others = [Solver(name, rtol=_RTOLS[0]) for name in _METHODS if name != method.name]
            references.instants = instants_of(model, rows, others, limit)
        judge = replace(judge, instants=references.instants)
        run = judge.run(method, accounts=bool(model.accounts))
    if run.status == "stopped":
        return Judgement(Verdict.SLOW, message=run.message)
    if run.status != "done":
        return Judgement(Verdict.FAILS, message=run.message)
    return judge.judge(run, method)


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Judges runs of a model with its present parameters at the same instants."""

    model: LoadedModel
    instants: Instants
    tolerance: Accuracy
    limit: float
    references: References

    def judge(self, run: Run, method: Solver) -> Judgement:
        """Compare a run by a method with others.

        It holds if another method at a hundredth of the default tolerance agrees with it, also from
        a start that is moved a little, and if no state of that run is decided by rounding. If not,
        two other methods must agree before the run is called degraded or wrong.
        """
        residual, warned = self._balance(run)
        rows = run.rows[:, : len(self.model.measured)]
        by = Solver(_METHODS[method.name == _METHODS[0]], rtol=_RTOLS[0])
        other = self._solved(by)
        if other.status == "done":
            error = self._error(rows, other.rows)
            if self._is_acceptable(rows, other.rows, error):
                return self._unless_doubtful(error, residual, other, by)
        warned = warned or self._depends_on_rounding(run, method) > WRONG
        return self._against_two(rows, method, residual, warned)

    def _against_two(
        self, rows: Array, method: Solver, residual: float | None, warned: bool
    ) -> Judgement:
        """Judge by rows on which two other methods agree."""
        known = self._agreed()
        if known is None:
            message = "no two methods complete the run at a tight tolerance"
            return Judgement(Verdict.UNJUDGED, residual=residual, message=message)
        error = self._error(rows, known.run.rows)
        # A reference worse than the acceptable error only shows larger errors than its own.
        if known.accuracy > self.tolerance.within and error <= AT_THE_REFERENCE * known.accuracy:
            rings = self._unless_ringing(error, residual, known.run)
            message = rings.message or f"two references differ by {known.accuracy:.1e}"
            return Judgement(Verdict.UNJUDGED, error, residual, message)
        if self._is_acceptable(rows, known.run.rows, error):
            return self._unless_doubtful(error, residual, known.run, known.by)
        rtol = 0.0 if method.fixed else method.rtol or DEFAULT_RTOL
        if error <= max(WRONG, min(1.0, _OF_TOLERANCE * rtol)):
            return Judgement(Verdict.DEGRADED, error, residual)
        if not self._is_confirmed(known):
            return Judgement(Verdict.UNJUDGED, error, residual, _UNSTABLE)
        message = UNSTABLE if error > _BOUNDED else INACCURATE
        return Judgement(Verdict.WARNED if warned else Verdict.WRONG, error, residual, message)

    def _unless_doubtful(
        self, error: float, residual: float | None, reference: Run, by: Solver
    ) -> Judgement:
        """Let a run hold, unless all methods may share its error.

        They do where rounding decides a state that fell below its tolerance, where the solution
        leaves that of a start next to it, and where no method resolved a lasting oscillation.
        """
        if self._depends_on_rounding(reference, by) > self.tolerance.within:
            name = self.model.states[reference.subtolerance[0].index].name
            message = f"rounding decides `{name}`, which fell below its tolerance"
            return Judgement(Verdict.UNJUDGED, error, residual, message)
        if self.references.moved is None:
            self.references.moved = self.run(by, moved=reference.counts["scale_reached"])
        moved = self.references.moved
        if moved.status == "done":
            # In the rows: between them, the other instant of a jump is no other solution.
            rows, at_rows = self.instants.rows, replace(self, instants=self.instants.at_rows)
            away = at_rows._error(moved.rows[rows], reference.rows[rows])
            if not at_rows._is_acceptable(moved.rows[rows], reference.rows[rows], away):
                return Judgement(Verdict.UNJUDGED, error, residual, _MOVED)
        return self._unless_ringing(error, residual, reference)

    def _depends_on_rounding(self, run: Run, method: Solver) -> float:
        """Measure how far shifts of states below their tolerance move a run, relative to ranges."""
        probe = self.instants.probe(self.model, method, run)
        if probe is None:
            return 0.0
        return probe.change(run.rows, run.subtolerance, run.counts["scale_reached"])

    def _unless_ringing(self, error: float, residual: float | None, reference: Run) -> Judgement:
        """Let a run hold, unless all methods missed a lasting and observable oscillation."""
        rows, steps = reference.rows, reference.counts["steps"]
        duration = self._duration
        interval = duration / (len(self.instants.rows) - 1)
        for mode in ringing_at_start(self.model, duration):
            if mode.seconds < interval or steps >= _STEPS_PER_PERIOD * mode.periods:
                continue
            missed = self._error(rows + mode.amplitude, rows)
            if missed > self.tolerance.within:
                message = (
                    f"it rings at {mode.frequency:.2g} Hz for {mode.seconds:.2g} s, which no "
                    f"method resolved: {missed:.1e}"
                )
                return Judgement(Verdict.UNJUDGED, error, residual, message)
        return Judgement(Verdict.HOLDS, error, residual)

    def _agreed(self) -> Agreement | None:
        """Find runs that agree to a tenth of the acceptable error, or at best; None without any."""
        best: Agreement | None = None
        found = agreements(self._solved, self._error, _METHODS, _RTOLS, at_once=len(_METHODS))
        for agreement in found:
            if agreement.accuracy < (best.accuracy if best is not None else math.inf):
                best = agreement
            if best is not None and best.accuracy <= _AGREED * self.tolerance.within:
                break
        return best

    def _solved(self, by: Solver) -> Run:
        """Return a run at a tight tolerance, kept for further points."""
        key = by.name, by.rtol
        if key not in self.references.runs:
            self.references.runs[key] = self.run(by)
        return self.references.runs[key]

    @property
    def _duration(self) -> float:
        return float(self.instants.times[-1])

    def run(self, method: Solver, *, accounts: bool = False, moved: float = 0.0) -> Run:
        """Run within the limit of processor time, which other processes do not consume."""
        most = _OF_WALL_TIME * self.limit
        return self.instants.run(
            self.model, method, accounts=accounts, limit=most, busy=self.limit, moved=moved
        )

    def _balance(self, run: Run) -> tuple[float | None, bool]:
        """Return the residual over the energy exchanged, or None, and whether the run warns."""
        too_long = run.counts["largest_correction"] > 0 or run.counts["over_budget"] > 0
        if run.rows.shape[1] == len(self.model.measured):
            return None, too_long
        return run.residual, too_long or unbalanced(run.residual, 1.0)

    def _is_confirmed(self, reference: Agreement) -> bool:
        """Return whether a third run, tighter and with short steps, agrees with the reference.

        Long steps keep two methods near an unstable solution, which the true solution leaves.
        """
        longest = self._duration / _SHORT_STEPS
        for name in _METHODS[1:]:
            run = self.run(Solver(name, rtol=_RTOLS[-1], max_step=longest))
            if run.status == "done":
                error = self._error(run.rows, reference.run.rows)
                return error <= max(self.tolerance.within, AT_THE_REFERENCE * reference.accuracy)
        return False

    def _is_acceptable(self, rows: Array, reference: Array, error: float) -> bool:
        if not self.tolerance.required:
            return error <= self.tolerance.within
        quantities = self.tolerance.quantities(self.model, reference)
        with np.errstate(over="ignore", invalid="ignore"):
            return combined(self.instants.errors(rows, reference), quantities) <= 1

    def _error(self, rows: Array, reference: Array) -> float:
        """Compute the worst error over its scale; infinite if numbers overflow.

        The scale is the range of a quantity, but at least a part of its size and its resolution at
        the default tolerance: smaller changes are the rest of a transient that decays between two
        rows.
        """
        resolution = self._resolution()
        with np.errstate(over="ignore", invalid="ignore"):
            quantities = quantities_of(self.model.measured, reference, {})
            least = resolution + _SMALLEST_RANGE * np.max(np.abs(reference), axis=0)
            scaled = [
                replace(q, scale=max(q.scale, low))
                for q, low in zip(quantities, least.tolist(), strict=True)
            ]
            error = combined(self.instants.errors(rows, reference), scaled)
        return error if math.isfinite(error) else math.inf

    def _resolution(self) -> Array:
        """Estimate the error of each observed quantity over a run at the default tolerance.

        The state scales are those that step control used: finer where no state comes near its own.
        """
        runs = self.references.runs.values()
        scale = max((run.counts["scale_reached"] for run in runs if run.counts), default=1.0)
        return _OF_TOLERANCE * DEFAULT_RTOL * scale * observed_scales(self.model)
