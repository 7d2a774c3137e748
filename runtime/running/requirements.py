"""The `require` statements of a scene, judged for a run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import Criterion, read_criterion
from bgc.runtime.results.requirements import Requirement
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.quantity import read_quantity
from bgc.values.shown_units import Shown

_SIZE: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"max": lambda x: x, "min": lambda x: -x, "peak": np.abs}
)  # largest at the extreme
_UNKNOWN = np.array([np.nan])


def observed_columns(model: LoadedModel) -> dict[str, tuple[str, Shown]]:
    """The observed columns with their units and the units in which they are shown."""
    return {variable.name: (variable.unit, variable.shown) for variable in model.outputs}


def criteria_of(model: LoadedModel, texts: Sequence[str] | None) -> tuple[Criterion, ...]:
    """Read criteria on the columns of a scene; None stands for its own limits."""
    columns = observed_columns(model)
    limits = model.facts.criteria if texts is None else texts
    return tuple(each for text in limits for each in read_criterion(text, columns, read_quantity))


def requirements_of(
    model: LoadedModel, times: Array, rows: Array, errors: Mapping[str, Array], between: int = 1
) -> Iterator[Requirement]:
    """Judge the limits and the accuracies that the scene of a run requires.

    `rows` are those that C writes, (n, width), at `times`, s, (n,); every `between`-th is one of
    the result, for which `errors` are by output, NaN or absent where they are not known.
    """
    chosen = model.selection()
    places = {variable.name: k for k, variable in enumerate(model.outputs)}
    for each in criteria_of(model, None):
        limited = each.observable
        column = chosen.column(rows, places[limited.column])
        at = int(np.argmax(_SIZE[limited.function](column)))  # the first NaN, if there is one
        row = -(-at // between)
        error = float(np.max(errors.get(limited.column, _UNKNOWN)[row : row + 2], initial=0.0))
        yield Requirement(
            each.name, limited.of(times, column), error, each.limit, each.below, limited.shown,
            float(times[at]),
        )  # fmt: skip
    known = {variable.name: variable for variable in model.measured}
    for name, tolerance in model.facts.requirements:
        shown = known[name].shown
        text = f"{name.removesuffix(' (required)')} within {shown.text(tolerance)}"
        largest = float(np.max(errors.get(name, _UNKNOWN)))
        yield Requirement(text, largest, 0.0, tolerance, True, shown)
