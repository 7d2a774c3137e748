"""Runs with the exact derivatives of their columns by parameters, for fits and searches.

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

    `columns` are names of the outputs whose values and derivatives are wanted.
    """

    runs: PointRuns
    names: tuple[str, ...]
    columns: tuple[str, ...]
    _followed: tuple[LoadedModel, tuple[Direction, ...]] | None = None
    _refused: bool = False

    def at(
        self, point: Array, times: Array, others: Mapping[str, float]
    ) -> tuple[Array, Array] | None:
        """Columns, (times, columns), and their derivatives, (parameters, times, columns).

        `point` has the values of the parameters, `others` values of further ones, SI. None where
        the model, its start or an event has no derivative, and where the run fails.

        Raises KeyboardInterrupt: Ctrl-C.
        """
        followed = self._load()
        if followed is None:
            return None
        model, directions = followed
        values = {**dict(zip(self.names, point.tolist(), strict=True)), **others}
        method = with_capped_step(self.runs.method, times, model.facts.timed)
        rows = np.full((len(times), model.row_width), np.nan)
        slopes = np.full((len(times), len(directions), len(model.measured)), np.nan)
        self.runs.count += 1
        try:
            with model.started(method, bool(model.accounts), values) as instance:
                begin(model, instance, method, values, directions).follow(slopes)
                status, _, interrupted = run_watched(instance, times, rows, progress=False)
                if interrupted:
                    raise KeyboardInterrupt
                require(instance, status, model.places)
        except BgError:
            return None
        places = [[v.name for v in model.measured].index(name) for name in self.columns]
        found = np.moveaxis(slopes[:, :, places], 1, 0)
        return (rows[:, places], found) if np.isfinite(found).all() else None

    def _load(self) -> tuple[LoadedModel, Sequence[Direction]] | None:
        """The model with its tangents; None if it, or one of the columns, has no derivatives."""
        if self._followed is None and not self._refused:
            model = self.runs.model
            measured = {variable.name for variable in model.measured}
            try:
                if model.origin is None or not measured.issuperset(self.columns):
                    self._refused = True
                else:
                    self._followed = followed(model, self.runs.method, self.names)
            except BgError:
                self._refused = True
        return self._followed
