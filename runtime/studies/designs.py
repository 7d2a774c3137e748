"""Runs of designs: observables at points of the space of the varied parameters, in batches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import Observable
from bgc.runtime.results.runs import gathered
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.lanes import LaneLibrary
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.many import Plan, lane_library, observe_many, plan_many
from bgc.runtime.running.run import Method
from bgc.runtime.running.sweep import Range

_STEP = 1e-4  # of a range: runs of one batch take the same steps, so that their errors cancel
_STEP_ALONE = 1e-3  # where each run chooses its own steps


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

    model: LoadedModel
    method: Method
    times: Array
    ranges: tuple[Range, ...]
    over: Mapping[str, Array]
    observables: tuple[Observable, ...]
    most_runs: int
    runs: int = 0
    failures: list[Diagnostic] = field(default_factory=list)
    _library: LaneLibrary | None = None
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
        plan = self._plan_cases(np.clip(u, 0.0, 1.0)[np.newaxis])
        found = observe_many(plan, library=self._library).run_warnings
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

        A point and its central differences run in one batch; they are one-sided beside a design
        that failed, and at the end of a range.
        """
        u = np.clip(u, 0.0, 1.0)
        key = u.tobytes()
        if key in self._sloped:
            return self._sloped[key]
        count = len(u)
        step = _STEP_ALONE if self._alone(2 * count + 1) and not self.method.fixed else _STEP
        above, below = np.minimum(u + step, 1.0), np.maximum(u - step, 0.0)
        points = np.tile(u, (2 * count + 1, 1))
        rows = np.arange(count)
        points[1 + rows, rows], points[1 + count + rows, rows] = above, below
        base, *others = self._run(points)
        known = self._known.setdefault(key, base)
        if base is None or known is None:
            self._sloped[key] = None
            return None
        slopes = [
            _slope(
                (above[k], others[k]), (float(u[k]), base), (below[k], others[count + k])
            )
            for k in range(count)
        ]  # fmt: skip
        self._sloped[key] = Slopes(known, np.array(slopes))
        return self._sloped[key]

    def known_slopes(self, u: Array) -> Slopes | None:
        """The derivatives at a point if they were computed."""
        return self._sloped.get(np.clip(u, 0.0, 1.0).tobytes())

    def _alone(self, points: int) -> bool:
        return bool(self._plan_cases(np.zeros((points, len(self.ranges)))).alone)

    def _plan_cases(self, points: Array) -> Plan:
        """Plan all runs: the points of one case lie side by side, so that they share a batch."""
        names = tuple(each.name for each in self.ranges)
        varied = np.tile(self.parameters(points), (self.cases, 1))
        others = [np.repeat(values, len(points)) for values in self.over.values()]
        taken = {*names, *self.over}
        preset = {k: v for k, v in self.model.parameters.given({}).items() if k not in taken}
        fixed = np.broadcast_to([*preset.values()], (len(varied), len(preset)))
        cases = Cases((*names, *self.over, *preset), np.column_stack((varied, *others, fixed)))
        return plan_many(self.model, self.method, cases, self.times, observables=self.observables)

    def _run(self, points: Array) -> list[Array | None]:
        plan = self._plan_cases(points)
        if self.runs + len(plan.cases) > self.most_runs:
            raise RunsSpent
        if self._library is None and not plan.alone:
            self._library = lane_library(self.model)
        study = observe_many(plan, library=self._library, examined=False)
        self.runs += len(plan.cases)
        for number, why in study.failures.items():
            self.failures.append(replace(why, note=_at(why.note, plan.cases[number])))
        values = study.values.reshape(self.cases, len(points), -1)
        good = study.done.reshape(self.cases, -1) & np.isfinite(values).all(axis=2)
        return [values[:, k] if good[:, k].all() else None for k in range(len(points))]


def _at(note: str, values: Mapping[str, float]) -> str:
    listed = ", ".join(f"`{name}` = {value:.6g}" for name, value in values.items())
    return "\n".join(filter(None, (note, f"with {listed}")))


def _slope(*ends: tuple[float, Array | None]) -> Array:
    """A difference quotient between the outermost places that have values; ends from above."""
    known = [(place, values) for place, values in ends if values is not None]
    (last, high), (first, low) = known[0], known[-1]
    if not last > first:
        return np.zeros_like(high)
    return np.asarray((high - low) / (last - first))
