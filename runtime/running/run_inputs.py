"""Inputs of each run of an ensemble: tables over the time and the number of the run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.catalogue.inputs import mixed_inputs, too_many_inputs, uneven_inputs
from bgc.diagnostics.diagnostic import BgError
from bgc.options import RUN_NUMBER
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.inputs import (
    Inputs,
    InputValue,
    array_of,
    check_times,
    joined,
    literal,
    nested,
    pair_of,
    times_of_pair,
    values_of_pair,
)
from bgc.runtime.running.quantity import read_number

_MOST_NUMBERS = 10_000  # numbers of one component: the times of all runs
_UNIT = 1  # the part of a text such as "2 kN" behind its number


def drives_of_runs(inputs: Sequence[Inputs], rows: Array) -> tuple[tuple[str, str], ...]:
    """Write each input as the expression of a `drive` statement that holds in all runs.

    Constants become a table over the number of the run; pairs a table over it and over all times
    of all runs, which leaves straight lines as they are; functions one over it and the `rows`, s,
    joined by cubic splines.

    Raises BgError: BG560 where the runs have other inputs, BG561 for an input with functions and
    pairs, BG562 for too many numbers, and those of `drives_of`.
    """
    names = tuple(inputs[0])
    for number, each in enumerate(inputs, 1):
        if set(each) != set(names):
            found = ", ".join(f"`{name}`" for name in each) or "none"
            raise BgError([uneven_inputs(f"run 1 has other inputs than run {number}: {found}")])
    return tuple((str(name), _drive(name, [each[name] for each in inputs], rows)) for name in names)


def _drive(name: str, values: Sequence[InputValue], rows: Array) -> str:
    pairs = [pair_of(value) for value in values]
    functions = any(map(callable, values))
    if functions and any(pair is not None for pair in pairs):
        raise BgError([mixed_inputs(name)])
    if functions:
        check_times(name, rows, rows[-1])
        knots, method = rows, "spline"
    elif any(pair is not None for pair in pairs):
        times = [times_of_pair(name, pair) for pair in pairs if pair is not None]
        for each in times:
            check_times(name, each, rows[-1])
        # Beyond the run no value is needed; the longest table covers it.
        knots, method = np.unique(np.concatenate(times)), "linear"
    else:
        knots, method = np.zeros(1), "linear"
    if len(knots) * len(values) > _MOST_NUMBERS:
        raise BgError([too_many_inputs(name, len(knots), len(values))])
    units: dict[str, None] = {}
    tables = []
    for value, pair in zip(values, pairs, strict=True):
        if pair is not None:
            own = times_of_pair(name, pair)
            table = _numbers(name, values_of_pair(name, own, pair), units)
            tables.append(_at(knots, own, table))
        elif callable(value):
            tables.append(_numbers(name, [value(float(time)) for time in knots], units))
        else:
            constant = _numbers(name, [value], units)
            tables.append(np.repeat(constant, len(knots), axis=0))
    shapes = dict.fromkeys(table.shape[1:] for table in tables)
    if len(shapes) > 1:
        one, other = list(shapes)[:2]
        raise BgError([uneven_inputs(f"`{name}` has values of the shapes {one} and {other}")])
    return _expression(knots, np.stack(tables), method, tuple(units))


def _expression(knots: Array, tables: Array, method: str, units: Sequence[str]) -> str:
    """Write the tables, (runs, times, ..), as interpolations in a list like one of the values."""
    runs = joined(str(k + 1) for k in range(len(tables)))
    times = joined(map(repr, knots.tolist()))
    tag = "".join(f" + 0 {unit}" for unit in units)  # the compiler compares the units
    columns = np.empty(tables.shape[2:], dtype=object)
    for place in product(*map(range, columns.shape)):
        table = np.array([[each[place] for each in run] for run in tables])
        if len(knots) == 1:
            column = joined(map(repr, table[:, 0].tolist()))
            text = f"interpolate([{runs}], [{column}], {RUN_NUMBER}, method = nearest)"
        else:
            lines = ",\n".join(f"[{joined(map(repr, row))}]" for row in table.T.tolist())
            text = (
                f"interpolate([{times}], [{runs}], [{lines}], time, {RUN_NUMBER}, "
                f"method = {method})"
            )
        columns[place] = text + tag
    return nested(columns, str)


def _at(knots: Array, times: Array, values: Array) -> Array:
    """Values at knots, by straight lines between those at times; the last one holds behind."""
    flat = values.reshape(len(times), -1)
    found = [np.interp(knots, times, column) for column in flat.T]
    return np.stack(found, axis=1).reshape(len(knots), *values.shape[1:])


def _numbers(name: str, values: Sequence[Any], units: dict[str, None]) -> Array:
    """Values as SI numbers, (values, ..); the units of those that are texts are noted."""
    arrays = [array_of(name, value) for value in values]
    shapes = dict.fromkeys(array.shape for array in arrays)
    if len(shapes) > 1:
        one, other = list(shapes)[:2]
        raise BgError([uneven_inputs(f"`{name}` has values of the shapes {one} and {other}")])
    return np.array([_si(name, array, units) for array in arrays], dtype=float)


def _si(name: str, array: NDArray[Any], units: dict[str, None]) -> NDArray[Any]:
    found = np.empty(array.shape, dtype=float)
    for place in product(*map(range, array.shape)):
        text = literal(name, array[place], None)
        if isinstance(array[place], str):
            _, _, unit = text.partition(" ")
            if unit:
                units[unit.strip()] = None
        number = read_number(text)
        assert number is not None
        found[place] = number
    return found
