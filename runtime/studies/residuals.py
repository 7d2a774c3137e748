"""Residuals of a recorded motion and their derivatives, from one batch of runs for each point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.lanes import LaneLibrary
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.many import Plan, lane_library, plan_many, simulate_many
from bgc.runtime.running.run import Method
from bgc.runtime.studies.motion import Recorded

_STEP = 1e-4  # of a parameter's scale: central differences then have an error of some 1e-8
_STEP_ALONE = 1e-3  # where each run chooses its own steps, whose errors do not cancel


@dataclass(slots=True)
class Residuals:
    """Computed less recorded values over the noise of their columns, and their derivatives.

    A point and its central differences run in one batch: its instances take the same steps, so
    that the errors of the integration almost cancel in the differences (internal numerical
    differentiation, H. G. Bock, 1981).

    `scale` is the size of each parameter, `noise` the standard deviation of each fitted column.
    """

    model: LoadedModel
    method: Method
    recorded: Recorded
    names: tuple[str, ...]
    low: Array
    high: Array
    scale: Array
    noise: Array
    runs: int = 0
    failures: list[Diagnostic] = field(default_factory=list)
    _library: LaneLibrary | None = None
    _point: Array | None = None
    _values: Array | None = None  # (rows, columns) at the point
    _slopes: Array | None = None  # (parameters, rows, columns)

    def values(self, point: Array) -> Array | None:
        """Computed values of the fitted columns, (rows, columns); None where the run fails."""
        self._compute(point)
        return self._values

    def residuals(self, point: Array) -> Array | None:
        """Residuals of all recorded values, (m,); None where the run fails."""
        values = self.values(point)
        if values is None:
            return None
        return np.asarray(((values - self.recorded.values) / self.noise)[self.recorded.known])

    def jacobian(self, point: Array) -> Array:
        """Derivatives of the residuals by the parameters, (m, parameters)."""
        self._compute(point)
        assert self._slopes is not None
        weighted = self._slopes / self.noise
        return np.column_stack([each[self.recorded.known] for each in weighted])

    def warned(self, point: Array) -> tuple[Diagnostic, ...]:
        """The warnings about the run at a point, which is repeated alone."""
        return simulate_many(self._plan(point[np.newaxis])).run_warnings.get(0, ())

    def many(self, points: Array) -> list[Array | None]:
        """Computed values at several points, (n, parameters), in one batch."""
        plan = self._plan(points)
        if self._library is None and not plan.alone:
            self._library = lane_library(self.model)
        ensemble = simulate_many(plan, library=self._library, examined=False)
        self.runs += len(points)
        self.failures += ensemble.failures.values()
        places = [ensemble.names.index(name) for name in self.recorded.names]
        rows = ensemble.values[:, :, places]
        good = ensemble.done & np.isfinite(rows[:, 1:]).all(axis=(1, 2))
        return [rows[k] if good[k] else None for k in range(len(points))]

    def _plan(self, points: Array) -> Plan:
        preset = self.model.parameters.given({})
        fixed = {name: value for name, value in preset.items() if name not in self.names}
        shared = np.broadcast_to(list(fixed.values()), (len(points), len(fixed)))
        cases = Cases((*self.names, *fixed), np.column_stack((points, shared)))
        return plan_many(self.model, self.method, cases, self.recorded.time)

    def _compute(self, point: Array) -> None:
        """Run a point and its neighbours, within the bounds."""
        if self._point is not None and np.array_equal(point, self._point):
            return
        count = 2 * len(point) + 1
        alone = self._plan(np.tile(point, (count, 1))).alone and not self.method.fixed
        step = (_STEP_ALONE if alone else _STEP) * self.scale
        above = np.minimum(point + step, self.high)
        below = np.maximum(point - step, self.low)
        points = [point]
        for k in range(len(point)):
            for end in (above, below):
                other = point.copy()
                other[k] = end[k]
                points.append(other)
        base, *others = self.many(np.array(points))
        self._point, self._values, self._slopes = point.copy(), base, None
        if base is not None:
            self._slopes = np.array(
                [
                    _slope(base, others[2 * k], others[2 * k + 1], point[k], above[k], below[k])
                    for k in range(len(point))
                ]
            )


def _slope(
    base: Array, up: Array | None, down: Array | None, at: float, above: float, below: float
) -> Array:
    """A central difference, or a one-sided one beside a run that failed or at a bound."""
    ends = [(above, up), (at, base), (below, down)]
    known = [(place, values) for place, values in ends if values is not None]
    (last, high), (first, low) = known[0], known[-1]
    if not last > first:
        return np.zeros_like(base)
    return np.asarray((high - low) / (last - first))


def penalty(residuals: Sequence[float] | Array) -> Array:
    """Residuals that stand for a failed run: larger than those of the start, so it is refused."""
    size = float(np.linalg.norm(np.asarray(residuals)))
    return np.full(len(residuals), 10 * max(size, 1.0))
