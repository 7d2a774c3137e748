"""Residuals of a recorded motion and their derivatives, from one batch of runs for each point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.runtime.results.arrays import Array
from bgc.runtime.studies.motion import Recorded
from bgc.runtime.studies.points import PointRuns, slopes, stencil


@dataclass(slots=True)
class Residuals:
    """Computed less recorded values over the noise of their columns, and their derivatives.

    `scale` is the size of each parameter, `noise` the standard deviation of each fitted column.
    """

    runs: PointRuns
    recorded: Recorded
    names: tuple[str, ...]
    low: Array
    high: Array
    scale: Array
    noise: Array
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
        again = self.runs.repeat(self.runs.plan(self.names, point[np.newaxis]))
        return again.run_warnings.get(0, ())

    def many(self, points: Array) -> list[Array | None]:
        """Computed values at several points, (n, parameters), in one batch."""
        found = self.runs.run(self.runs.plan(self.names, points))
        places = [found.names.index(name) for name in self.recorded.names]
        rows = found.values[:, :, places]
        good = found.done & np.isfinite(rows[:, 1:]).all(axis=(1, 2))
        return [rows[k] if good[k] else None for k in range(len(points))]

    def _compute(self, point: Array) -> None:
        """Run a point and its neighbours, within the bounds."""
        if self._point is not None and np.array_equal(point, self._point):
            return
        plan = self.runs.plan(self.names, np.tile(point, (2 * len(point) + 1, 1)))
        step = self.runs.difference(plan) * self.scale
        points = stencil(
            point, np.minimum(point + step, self.high), np.maximum(point - step, self.low)
        )
        values = self.many(points)
        self._point, self._values, self._slopes = point.copy(), values[0], None
        if values[0] is not None:
            self._slopes = slopes(points, values)


def penalty(residuals: Sequence[float] | Array) -> Array:
    """Residuals that stand for a failed run: larger than those of the start, so it is refused."""
    size = float(np.linalg.norm(np.asarray(residuals)))
    return np.full(len(residuals), 10 * max(size, 1.0))
