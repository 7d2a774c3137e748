"""Arguments of an optimisation: bounds, objective, limits and cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.studies import bad_observable
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import (
    Criterion,
    Observable,
    read_criterion,
    read_observables,
)
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.many import observed_columns
from bgc.runtime.running.quantity import read_quantity
from bgc.runtime.running.sweep import Range, points
from bgc.runtime.studies.bounds import read_bounds
from bgc.runtime.studies.sweep import Vary, read_axes


@dataclass(frozen=True, slots=True)
class Problem:
    """An objective with its bounds and limits, and the values of the cases of each design, SI."""

    bounds: Sequence[Range]
    objective: Observable
    criteria: tuple[Criterion, ...]
    over: Mapping[str, Array]


def read_problem(
    model: LoadedModel,
    vary: Vary,
    minimise: str | None,
    maximise: str | None,
    require: Sequence[str] | None,
    over: Vary,
) -> Problem:
    """Read an optimisation; limits are by default those of the scene.

    Raises BgError: BG066 unless there is one objective, BG787 for another text or a vector, and the
    errors of bounds and axes.
    """
    if (minimise is None) == (maximise is None):
        both = "both" if minimise is not None else "neither"
        wanted = "one observable: `minimise` or `maximise`"
        raise BgError([bad_option("objective", both, wanted, 'minimise "max(load.z)"')])
    columns = observed_columns(model)
    text = minimise if minimise is not None else maximise
    assert text is not None
    objectives = read_observables([text], columns, read_quantity)
    if len(objectives) > 1:
        reason = f"it has {len(objectives)} components, and an objective is one number"
        way_out = f"write one of them, `{objectives[0].name}`, or observe their magnitude"
        raise BgError([bad_observable(text, reason, way_out)])
    limits = model.facts.criteria if require is None else require
    criteria = tuple(
        each for text in limits for each in read_criterion(text, columns, read_quantity)
    )
    axes = read_axes(over, model.parameters)
    return Problem(
        read_bounds(vary, model.parameters),
        objectives[0],
        criteria,
        points(axes, None) if axes else {},
    )
