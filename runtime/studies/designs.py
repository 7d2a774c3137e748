"""Runs of designs: observables at points of the space of the varied parameters, in batches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.runs import gathered
from bgc.runtime.running.many import Plan
from bgc.runtime.running.parameter_grid import Range
from bgc.runtime.studies.followed_runs import FollowedRuns
from bgc.runtime.studies.points import PointRuns, slopes, stencil

_BLOCK = 8  # parameters by which a run is differentiated at the cost of about two more runs
_SHARE = 0.6  # of a run, the cost of one in a batch


class RunsSpent(Exception):
    """The next batch would exceed the number of runs."""


@dataclass(frozen=True, slots=True)
class Slopes:
    """Observables at a point, (cases, observables), and their derivatives by its coordinates."""

    values: Array
    slopes: Array  # (coordinates, cases, observables)


@dataclass(slots=True)
class Designs:
    """Observables of designs, each a point of the unit cube that the ranges span.

    `over` are values of other parameters: each design runs with all of them, its cases. A design
    has no values where one of its runs fails or leaves a number that is not finite.
    """

    runs: PointRuns
    ranges: tuple[Range, ...]
    over: Mapping[str, Array]
    most_runs: int
    followed: FollowedRuns
    _known: dict[bytes, Array | None] = field(default_factory=dict)
    _sloped: dict[bytes, Slopes | None] = field(default_factory=dict)

    @property
    def cases(self) -> int:
        """The number of runs of a design."""
        return len(next(iter(self.over.values()))) if self.over else 1

    def parameters(self, u: Array) -> Array:
        """The values of the parameters at a point, or at each of several, SI."""
        inside = np.clip(u, 0.0, 1.0)
        return np.stack([each.at(inside[..., k]) for k, each in enumerate(self.ranges)], axis=-1)

    def place(self, values: Array) -> Array:
        """The point of parameters, SI; the nearest one for values outside their ranges."""
        found = []
        for each, value in zip(self.ranges, values.tolist(), strict=True):
            inside = min(max(value, each.low), each.high)
            if each.log:
                found.append(np.log(inside / each.low) / np.log(each.high / each.low))
            else:
                found.append((inside - each.low) / (each.high - each.low))
        return np.asarray(np.clip(np.array(found), 0.0, 1.0))

    def at(self, u: Array) -> Array | None:
        """Observables at a point, (cases, observables); None where a run fails.

        One case is run together with its differences, which share its vector register.
        """
        u = np.clip(u, 0.0, 1.0)
        key = u.tobytes()
        if key not in self._known:
            if self.cases == 1:
                self.slopes(u)
            else:
                self.many(u[None, :])
        return self._known[key]

    def warned(self, u: Array) -> Iterator[Diagnostic]:
        """Warn of the runs of a design, which are repeated, by code with the first of its cases."""
        found = self.runs.repeat(self._plan(np.clip(u, 0.0, 1.0)[np.newaxis])).run_warnings
        over = {name: np.asarray(values) for name, values in self.over.items()}
        return gathered(found, over) if over else iter(found.get(0, ()))

    def many(self, points: Array) -> list[Array | None]:
        """Observables at points, (n, coordinates), in one batch."""
        points = np.clip(points, 0.0, 1.0)
        keys = [point.tobytes() for point in points]
        new = [k for k, key in enumerate(keys) if key not in self._known]
        if new:
            for k, values in zip(new, self._run(points[new]), strict=True):
                self._known[keys[k]] = values
        return [self._known[key] for key in keys]

    def slopes(self, u: Array) -> Slopes | None:
        """Observables and derivatives at a point; None where its own run fails.

        They are exact where this takes fewer operations and the run has them, else central
        differences, as for several cases, which fill batches on all processors. Differences are
        one-sided beside a design that failed, and at the end of a range.
        """
        u = np.clip(u, 0.0, 1.0)
        key = u.tobytes()
        if key in self._sloped:
            return self._sloped[key]
        plan = self._plan(np.zeros((2 * len(u) + 1, len(self.ranges))))
        exact = None
        if self.cases == 1 and _exact_costs_less(len(u), bool(plan.alone)):
            exact = self._exact(u)
        if exact is not None:
            self._known.setdefault(key, exact.values)
            self._sloped[key] = exact
            return exact
        step = self.runs.difference(plan)
        points = stencil(u, np.minimum(u + step, 1.0), np.maximum(u - step, 0.0))
        values = self._run(points)
        known = self._known.setdefault(key, values[0])
        if values[0] is None or known is None:
            self._sloped[key] = None
        else:
            self._sloped[key] = Slopes(known, slopes(points, values))
        return self._sloped[key]

    def _exact(self, u: Array) -> Slopes | None:
        """Observables and exact derivatives of the only case at a point; None if it has none."""
        if self.runs.count + 2 > self.most_runs:
            raise RunsSpent
        point = self.parameters(u)
        others = {name: float(values[0]) for name, values in self.over.items()}
        found = self.followed.observed(point, others)
        if found is None:
            return None
        by = [each.slope(x) for each, x in zip(self.ranges, point.tolist(), strict=True)]
        return Slopes(found[0][None], found[1][:, None] * np.array(by)[:, None, None])

    def known_slopes(self, u: Array) -> Slopes | None:
        """The derivatives at a point if they were computed."""
        return self._sloped.get(np.clip(u, 0.0, 1.0).tobytes())

    def _plan(self, points: Array) -> Plan:
        """Plan all runs: the points of one case lie side by side, so that they share a batch."""
        varied = np.tile(self.parameters(points), (self.cases, 1))
        others = [np.repeat(values, len(points)) for values in self.over.values()]
        names = (*(each.name for each in self.ranges), *self.over)
        return self.runs.plan(names, np.column_stack((varied, *others)))

    def _run(self, points: Array) -> list[Array | None]:
        plan = self._plan(points)
        if self.runs.count + len(plan.cases) > self.most_runs:
            raise RunsSpent
        found = self.runs.run(plan)
        values = found.values.reshape(self.cases, len(points), -1)
        good = found.done.reshape(self.cases, -1) & np.isfinite(values).all(axis=2)
        return [values[:, k] if good[:, k].all() else None for k in range(len(points))]


def _exact_costs_less(parameters: int, alone: bool) -> bool:
    """Compare the operations of exact derivatives and of central differences, in runs."""
    differences = (2 * parameters + 1) * (1.0 if alone else _SHARE)
    return 2 + 2 * -(-parameters // _BLOCK) < differences
