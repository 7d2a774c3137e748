"""Arguments of an estimation and an optimisation: bounds, noise, objective, limits, cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue import listed
from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.ensembles import varied_twice
from bgc.diagnostics.catalogue.studies import bad_observable, cannot_fit, not_bounds
from bgc.diagnostics.diagnostic import BgError
from bgc.language.column_names import name_in_si
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import Criterion, Observable, in_column_unit
from bgc.runtime.running.loaded_model import LoadedModel, Variable
from bgc.runtime.running.parameter_grid import Listed, Range, points, sobol
from bgc.runtime.running.parameters import Parameters
from bgc.runtime.running.quantity import Quantity, read_quantity
from bgc.runtime.running.requirements import criteria_of
from bgc.runtime.studies.sweep import Vary, observables_of, read_axes


def read_bounds(vary: Vary, parameters: Parameters) -> list[Range]:
    """Read the bounds of parameters; a list of two numbers is a range too.

    Bounds outside the range of a parameter are moved to its ends.

    Raises BgError: BG565 for a number of values, BG743, BG744, and those of a wrong name or unit.
    """
    found: list[Range] = []
    texts = [f"{n}={v}" for n, v in vary.items()] if isinstance(vary, Mapping) else list(vary)
    for axis, text in zip(read_axes(vary, parameters), texts, strict=True):
        several = isinstance(axis, Listed) and len(axis.values()) != 2
        if several or (isinstance(axis, Range) and (":" in text or text.endswith(" log"))):
            raise BgError([not_bounds(text)])
        if any(axis.name == each.name for each in found):
            raise BgError([varied_twice(axis.name)])
        ends = [axis.low, axis.high] if isinstance(axis, Range) else axis.values().tolist()
        info = parameters[axis.name]
        low, high = max(min(ends), info.low), min(max(ends), info.high)
        found.append(Range(axis.name, float(low), float(high)))
    return found


def spread(bounds: Sequence[Range]) -> tuple[Range, ...]:
    """Make positive ranges logarithmic whose ends are further apart than a factor of 10."""
    return tuple(
        Range(each.name, each.low, each.high, log=each.low > 0 and each.high > 10 * each.low)
        for each in bounds
    )


def with_sobol(start: Array, bounds: Sequence[Range], count: int, seed: int = 0) -> Array:
    """A point and `count - 1` points of a Sobol sequence within the bounds, (count, parameters)."""
    if count < 2:
        return start[None, :]
    more = np.column_stack(list(sobol(bounds, count - 1, seed).values()))
    return np.concatenate((start[None, :], more))


def read_noise(
    noise: Mapping[str, Quantity], fitted: Sequence[str], outputs: Sequence[Variable]
) -> dict[str, float]:
    """Read the standard deviations of columns, in their units."""
    units = {variable.name: variable.unit for variable in outputs}
    names = {**{name_in_si(name): name for name in fitted}, **{name: name for name in fitted}}
    found = {}
    for name, value in noise.items():
        if name not in names:
            reason = f"`{name}`, whose noise is given, is not fitted"
            raise BgError([cannot_fit(reason, f"give the noise of {listed([*fitted])}")])
        column = names[name]
        unit = "" if units[column] == "1" else units[column]
        found[column] = in_column_unit(str(value), f"the noise of {name}", unit, read_quantity)
    return found


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
    text = minimise if minimise is not None else maximise
    assert text is not None
    objectives = observables_of(model, [text])
    if len(objectives) > 1:
        reason = f"it has {len(objectives)} components, and an objective is one number"
        way_out = f"write one of them, `{objectives[0].name}`, or observe their magnitude"
        raise BgError([bad_observable(text, reason, way_out)])
    axes = read_axes(over, model.parameters)
    return Problem(
        read_bounds(vary, model.parameters),
        objectives[0],
        criteria_of(model, require),
        points(axes, None) if axes else {},
    )
