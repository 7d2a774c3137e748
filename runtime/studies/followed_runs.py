"""Runs with the exact derivatives of columns or observables by parameters, for studies.

They are those of `simulate(.., sensitivities=..)`. The model is compiled with its tangents once,
and a run leaves arrays instead of a result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.failures import require
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.run import run_watched, with_capped_step
from bgc.runtime.running.sensitivities import Direction, begin, followed
from bgc.runtime.studies.points import PointRuns


@dataclass(slots=True)
class FollowedRuns:
    """Runs of a model that are differentiated by some parameters.

    `columns` are names of the outputs whose derivatives are wanted. Methods return None where the
    model, its start or an event has no derivative, and where the run fails; `refusal` says why the
    last one did. They raise KeyboardInterrupt after Ctrl-C.
    """

    runs: PointRuns
    names: tuple[str, ...]
    columns: tuple[str, ...]
    refusal: BgError | None = None
    _followed: tuple[LoadedModel, Sequence[Direction]] | None = None
    _refused: bool = False

    def at(
        self, point: Array, times: Array, others: Mapping[str, float]
    ) -> tuple[Array, Array] | None:
        """Columns, (times, columns), and their derivatives, (parameters, times, columns).

        `point` has the values of the parameters, `others` values of further ones, SI. The steps are
        those of a run to the times of `runs`.
        """
        followed = self._load()
        found = None if followed is None else self._run(*followed, point, times, others)
        if found is None:
            return None
        rows, slopes = found
        measured = [variable.name for variable in self.runs.model.measured]
        places = [measured.index(name) for name in self.columns]
        by = np.moveaxis(slopes[:, :, places], 1, 0)
        return (rows[:, places], by) if np.isfinite(by).all() else None

    def observed(
        self, point: Array, others: Mapping[str, float] | None = None
    ) -> tuple[Array, Array] | None:
        """The observables of `runs`, (observables,), and derivatives, (parameters, observables).

        A first run finds the rows that they depend on: extremes depend on one of some thousands.
        """
        others = others or {}
        names = (*self.names, *others)
        plan = self.runs.plan(names, np.array([[*point, *others.values()]]))
        plain = self._run(self.runs.model, (), point, plan.times, others)
        if plain is None or self._load() is None:
            return None
        reducer = plan.reducer()
        values = reducer(plan.times, plain[0])
        if not np.isfinite(values).all():
            return None
        by = reducer.gradients(plan.times, plain[0])
        used = np.union1d(np.flatnonzero(by.any(axis=0)), (0, len(plan.times) - 1))
        found = self.at(point, plan.times[used], others)
        if found is None:
            return None
        columns = [self.columns.index(each.column) for each in self.runs.observables]
        return values, np.einsum("or,pro->po", by[:, used], found[1][:, :, columns])

    def _run(
        self,
        model: LoadedModel,
        directions: Sequence[Direction],
        point: Array,
        times: Array,
        others: Mapping[str, float],
    ) -> tuple[Array, Array] | None:
        """Rows, (times, width), and derivatives of the measured columns, (times, ..)."""
        values = {**dict(zip(self.names, point.tolist(), strict=True)), **others}
        method = with_capped_step(self.runs.method, self.runs.times, model.facts.timed)
        rows = np.full((len(times), model.row_width), np.nan)
        slopes = np.full((len(times), len(directions), len(model.measured)), np.nan)
        self.runs.count += 1
        try:
            with model.started(method, bool(model.accounts), values) as instance:
                if directions:
                    begin(model, instance, method, values, directions).follow(slopes)
                status, _, interrupted = run_watched(instance, times, rows, progress=False)
                if interrupted:
                    raise KeyboardInterrupt
                require(instance, status, model.places)
        except BgError as problem:
            self.refusal = problem
            return None
        return rows, slopes

    def _load(self) -> tuple[LoadedModel, Sequence[Direction]] | None:
        """The model with its tangents; None if it, or one of the columns, has no derivatives."""
        if self._followed is None and not self._refused:
            model = self.runs.model
            measured = {variable.name for variable in model.measured}
            self._refused = model.origin is None or not measured.issuperset(self.columns)
            try:
                if not self._refused:
                    self._followed = followed(model, self.runs.method, self.names)
            except BgError as problem:
                self._refused, self.refusal = True, problem
        return self._followed
