"""One point of the map: a run, the reference it is held against, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType

import numpy as np

from bgc.runtime.binding import Array, Status
from bgc.runtime.model import Model
from bgc.runtime.result import unbalanced
from bgc.runtime.run import Method
from bgc.runtime.trade.errors import combined, largest_errors, quantities_of
from bgc.runtime.trade.measure import Run, timed_run

WRONG = 0.1  # of the range: an error from which on a number has nothing to say any more
_OF_TOLERANCE = 100.0  # times the tolerance of a step: what a whole run may add up to
DEFAULT_RTOL = 1e-6  # of the C runtime

_UNSTABLE = "the reference changes with its step: the solution is unstable"
_METHODS = ("radau5", "rodas5p", "rodas4p2")
_RTOLS = (1e-8, 1e-10)
_AGREED = 0.1  # of the error that is asked for: by how much two references may differ
_SHORT_STEPS = 1000  # of a run
_TELLS = 3.0  # times its accuracy: errors below that are not told from the reference's own


class Verdict(Enum):
    """What a point came to."""

    HOLDS = "holds"
    DEGRADED = "degraded"  # the error is beyond what was asked for
    WARNED = "warned"  # nothing is right any more, and the run says so
    WRONG = "wrong"  # nothing is right any more, without a word
    FAILS = "fails"  # ended with a status
    SLOW = "too slow"  # stopped by the limit on its time
    UNJUDGED = "unjudged"  # completed, but two references do not agree


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Up to where a number holds: `within` relative to the range of what is observed.

    Where `by_scene`, it is what the scene requires instead, if it requires something.
    """

    within: float
    by_scene: bool = False
    requirements: tuple[tuple[str, float], ...] = ()

    @property
    def required(self) -> bool:
        """Whether the scene's `require` decides."""
        return self.by_scene and bool(self.requirements)


@dataclass(frozen=True, slots=True)
class Judgement:
    """A verdict, with the error relative to what is observed, None where there is none.

    `residual` is that of the energy accounts over what was exchanged, where the scene observes
    them.
    """

    verdict: Verdict
    error: float | None = None
    residual: float | None = None
    message: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Rows that two methods agree on to `accuracy`; None where none is to be had."""

    rows: Array | None
    accuracy: float
    message: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class _Resolution:
    """Errors that hold in any case: in the unit of each quantity, and as a part of its size."""

    absolute: Array
    part: float


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Judges runs of a model, as its parameters stand, over the same times.

    `limit` bounds each run, s.
    """

    model: Model
    times: Array
    tolerance: Tolerance
    limit: float

    def reference(self) -> Reference:
        """Run methods at tight tolerances until two agree to a tenth of what is asked for."""
        best = Reference(None, math.inf, "no two methods complete the run at a tight tolerance")
        resolution = self._resolution(0.0)
        for rtol in _RTOLS:
            found: list[Run] = []
            for name in _METHODS:
                run = self._run(Method(name, fixed=False, rtol=rtol))
                if run.status != "done":
                    continue
                for other in found:
                    accuracy = self._error(run.rows, other.rows, resolution)
                    if accuracy < best.accuracy:
                        best = Reference(other.rows, accuracy)
                if best.accuracy <= _AGREED * self.tolerance.within:
                    return best
                found.append(run)
        return best

    def judge(self, run: Run, rtol: float, reference: Callable[[], Reference]) -> Judgement:
        """Hold a run against the reference. `rtol` is what the method was given, 0 for a step."""
        if run.status == "stopped":
            return Judgement(Verdict.SLOW, message=run.message)
        if run.status != "done":
            return Judgement(Verdict.FAILS, message=run.message)
        residual, warned = self._balance(run)
        known = reference()
        if known.rows is None:
            return Judgement(Verdict.UNJUDGED, residual=residual, message=known.message)
        rows = run.rows[:, : len(self.model.measured)]
        error = self._error(rows, known.rows, self._resolution(rtol))
        # A reference that is worse than what is asked for can only tell what is far off.
        if known.accuracy > self.tolerance.within and error <= _TELLS * known.accuracy:
            message = f"two references differ by {known.accuracy:.1e}"
            return Judgement(Verdict.UNJUDGED, error, residual, message)
        if self._holds(rows, known.rows, error):
            return Judgement(Verdict.HOLDS, error, residual)
        if error <= max(WRONG, _OF_TOLERANCE * rtol):
            return Judgement(Verdict.DEGRADED, error, residual)
        if not self._is_confirmed(known):
            return Judgement(Verdict.UNJUDGED, error, residual, _UNSTABLE)
        return Judgement(Verdict.WARNED if warned else Verdict.WRONG, error, residual)

    def _run(self, method: Method) -> Run:
        return timed_run(self.model, method, self.times, accounts=False, limit=self.limit)

    def _balance(self, run: Run) -> tuple[float | None, bool]:
        """The residual over what was exchanged, None without accounts; whether a run warns."""
        accounts = run.rows[:, len(self.model.measured) :]
        if not accounts.shape[1]:
            return None, False
        exchanged = run.counts["exchanged"]
        worst = float(np.abs(accounts[:, -1]).max())
        return worst / exchanged if exchanged > 0 else 0.0, unbalanced(worst, exchanged)

    def _is_confirmed(self, reference: Reference) -> bool:
        """Whether a third run, tighter and with short steps, agrees with the reference too.

        Where a solution is unstable, long steps hold two methods alike to what it leaves at once.
        """
        longest = float(self.times[-1]) / _SHORT_STEPS
        for name in _METHODS[1:]:
            run = self._run(Method(name, fixed=False, rtol=_RTOLS[-1], max_step=longest))
            if run.status == "done" and reference.rows is not None:
                error = self._error(run.rows, reference.rows, self._resolution(0.0))
                return error <= max(self.tolerance.within, _TELLS * reference.accuracy)
        return False

    def _holds(self, rows: Array, reference: Array, error: float) -> bool:
        if not self.tolerance.required:
            return error <= self.tolerance.within
        requirements = dict(self.tolerance.requirements)
        exact = _Resolution(np.zeros(rows.shape[1]), 0.0)
        return self._error(rows, reference, exact, requirements) <= 1

    def _error(
        self,
        rows: Array,
        reference: Array,
        resolution: _Resolution,
        requirements: Mapping[str, float] = MappingProxyType({}),
    ) -> float:
        """The worst error over its scale; infinite where numbers overflow on the way.

        No scale is so small that the resolution of its quantity would not hold: one that hardly
        moves between the rows, or is conserved.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            quantities = quantities_of(self.model.measured, reference, requirements)
            size = np.max(np.abs(reference), axis=0)
            open_to = (resolution.absolute + resolution.part * size) / self.tolerance.within
            scaled = [
                replace(q, scale=max(q.scale, least))
                for q, least in zip(quantities, open_to.tolist(), strict=True)
            ]
            error = combined(largest_errors(rows, reference), scaled)
        return error if math.isfinite(error) else math.inf

    def _resolution(self, rtol: float) -> _Resolution:
        """What a tolerance leaves open of each observed quantity over a run.

        By the scales of the states at the start; no less than what it leaves by default, which no
        reference goes far below. A value that moves by less, as what is left of a
        transient that is over between two rows, is zero as far as the method is told.
        """
        rtol = max(rtol, DEFAULT_RTOL)
        instance = self.model.parameters.instance({})
        found = np.zeros(len(self.model.measured))
        if instance.reset() is not Status.OK:
            return _Resolution(found, _OF_TOLERANCE * rtol)
        _, start = instance.outputs()
        for k, size in enumerate(instance.scale.tolist()):
            present = instance.state[k]
            instance.state[k] = present + size
            _, moved = instance.outputs()
            instance.state[k] = present
            change = np.abs(moved - start)
            found += np.where(np.isfinite(change), change, 0.0)
        return _Resolution(_OF_TOLERANCE * rtol * found, _OF_TOLERANCE * rtol)
