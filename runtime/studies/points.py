"""Runs of a model at points of some parameters, in batches, and derivatives from differences.

A point and its central differences run in one batch: its instances take the same steps, so that
the errors of the integration almost cancel in the differences (internal numerical differentiation,
H. G. Bock, 1981).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import Observable
from bgc.runtime.results.runs import Runs
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.lane_interface import LaneLibrary
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.many import Plan, lane_library, plan_many, run_many

_STEP = 1e-4  # of a range or a scale: central differences then have an error of some 1e-8
_STEP_ALONE = 1e-3  # where each run chooses its own steps, whose errors do not cancel


@dataclass(slots=True)
class PointRuns:
    """Runs of a model at points, their number and the errors of those that failed."""

    model: LoadedModel
    method: Solver
    times: Array
    observables: tuple[Observable, ...] = ()
    count: int = 0
    failures: list[Diagnostic] = field(default_factory=list)
    _library: LaneLibrary | None = None

    @property
    def reason(self) -> str:
        """Why the first run that failed did, or a run without an error is of no use."""
        return self.failures[0].message if self.failures else "its values are not finite"

    def plan(self, names: Sequence[str], points: Array) -> Plan:
        """Plan runs with values of parameters, (n, names), beside those that the model has set."""
        preset = {k: v for k, v in self.model.parameters.given({}).items() if k not in names}
        fixed = np.broadcast_to([*preset.values()], (len(points), len(preset)))
        cases = Cases((*names, *preset), np.column_stack((points, fixed)))
        return plan_many(self.model, self.method, cases, self.times, observables=self.observables)

    def run(self, plan: Plan) -> Runs:
        """Run a plan; the library of the batches is loaded once."""
        if self._library is None and not plan.alone:
            self._library = lane_library(self.model)
        found = run_many(plan, library=self._library, examined=False)
        self.count += len(plan.cases)
        for number, why in found.failures.items():
            values = plan.cases[number].items()
            listed = ", ".join(f"`{name}` = {value:.6g}" for name, value in values)
            note = "\n".join(filter(None, (why.note, f"with {listed}")))
            self.failures.append(replace(why, note=note))
        return found

    def repeat(self, plan: Plan) -> Runs:
        """Run a plan once more for its warnings, without counting it."""
        return run_many(plan, library=self._library)

    def difference(self, plan: Plan) -> float:
        """The distance of central differences, as a share of the size of a parameter."""
        return _STEP_ALONE if plan.alone and not self.method.fixed else _STEP


def stencil(point: Array, above: Array, below: Array) -> Array:
    """A point, the points with one coordinate above it, and those with one below, (2 n + 1, n)."""
    count = len(point)
    points = np.tile(point, (2 * count + 1, 1))
    rows = np.arange(count)
    points[1 + rows, rows], points[1 + count + rows, rows] = above, below
    return points


def slopes(points: Array, values: Sequence[Array | None]) -> Array:
    """Derivatives by the coordinates from the values at a stencil, (n, ..).

    They are one-sided beside a point without values, and where a neighbour is the point itself.
    """
    count = points.shape[1]
    found = []
    for k in range(count):
        places = (1 + k, 0, 1 + count + k)  # from above
        known = [(points[i, k], value) for i in places if (value := values[i]) is not None]
        (last, high), (first, low) = known[0], known[-1]
        found.append((high - low) / (last - first) if last > first else np.zeros_like(high))
    return np.array(found)
