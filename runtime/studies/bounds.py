"""Bounds of the parameters and noise of the columns of an estimation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue import listed
from bgc.diagnostics.catalogue.ensembles import varied_twice
from bgc.diagnostics.catalogue.studies import cannot_fit, not_bounds
from bgc.diagnostics.diagnostic import BgError
from bgc.language.columns import name_in_si
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded import Variable
from bgc.runtime.running.parameters import Parameters
from bgc.runtime.running.quantity import Quantity, in_si
from bgc.runtime.running.sweep import Listed, Range, sobol
from bgc.runtime.studies.sweep import Vary, read_axes


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
        number = in_si(value, f"the noise of {name}", unit)
        assert number is not None
        if isinstance(value, str) and unit and " " in value.strip():
            number /= in_si(f"1 {unit}", name, unit) or 1.0
        found[column] = number
    return found
