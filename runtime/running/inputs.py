"""Inputs that a program gives: constants, values at times, functions of time, as `drive`s."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product
from numbers import Real
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.catalogue.arguments import not_a_value
from bgc.diagnostics.catalogue.inputs import (
    input_form,
    input_lengths,
    input_not_finite,
    input_times,
    input_too_short,
)
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import in_si, read_number

InputValue: TypeAlias = (
    ParameterValue
    | tuple[Sequence[Any] | NDArray[Any], Sequence[Any] | NDArray[Any]]
    | Callable[[float], ParameterValue]
)
"""A constant, a pair of times and values (the first axis is the time), or a function of t in s."""

Inputs: TypeAlias = Mapping[str, InputValue]
"""Values of inputs by their paths: a constant, a pair of times (s) and values, or a function of
the time in s; `{"road": ([0, 1], [0, "5 cm"])}`."""

_MOST_KNOTS = (
    10_000  # values of one component: the components of the longest vector of the language
)
_A_LINE = 8  # numbers
_ROUNDING = 1e-9  # of the duration


def drives_of(inputs: Inputs, rows: Array) -> tuple[tuple[str, str], ...]:
    """Write each input as the expression of a `drive` statement.

    Pairs are interpolated by straight lines. Functions are called at the times of the `rows`, s,
    and interpolated by `pchip`. Names, shapes and units are left to the compiler.

    Raises BgError: BG260 for another form, BG261, BG262 and BG264 for the times, BG062 and BG263
    for the values.
    """
    return tuple((str(name), _drive(name, value, rows)) for name, value in inputs.items())


def _drive(name: str, value: InputValue, rows: Array) -> str:
    if callable(value):
        check_times(name, rows, rows[-1])
        return _table(name, rows, [value(float(time)) for time in rows], "pchip")
    if (pair := pair_of(value)) is not None:
        knots = times_of_pair(name, pair)
        check_times(name, knots, rows[-1])
        return _table(name, knots, _listed(name, pair[1]), "linear")
    return nested(array_of(name, value), lambda item: literal(name, item, None))


def pair_of(value: Any) -> tuple[Any, Any] | None:
    """The tuple of times and values that a value is; None for a vector of two numbers."""
    if not (isinstance(value, tuple) and len(value) == 2 and _as_objects(value[0]).ndim == 1):
        return None
    return value


def times_of_pair(name: str, pair: tuple[Any, Any]) -> Array:
    """The times of a pair, s, not yet checked."""
    seconds = [in_si(time, f"times of {name}", "s") for time in _listed(name, pair[0])]
    return np.array(seconds, dtype=float)


def values_of_pair(name: str, times: Array, pair: tuple[Any, Any]) -> list[Any]:
    """The values of a pair; BG264 for another number of them than of times."""
    values = _listed(name, pair[1])
    if len(values) != len(times):
        raise BgError([input_lengths(name, f"{len(times)} times and {len(values)} values")])
    return values


def check_times(name: str, times: Array, end: float) -> None:
    """Raise BG261 for times that do not rise or are too many, BG262 for a run beyond them."""
    if not 2 <= len(times) <= _MOST_KNOTS:
        raise BgError([input_times(name, f"are {len(times)}")])
    if not np.isfinite(times).all():
        raise BgError([input_times(name, "are not all finite")])
    if len(falls := np.flatnonzero(np.diff(times) <= 0)):
        k = int(falls[0])
        raise BgError(
            [input_times(name, f"do not rise: {times[k + 1]:g} s follows {times[k]:g} s")]
        )
    if times[0] > 0 or times[-1] < end * (1 - _ROUNDING):
        raise BgError([input_too_short(name, times[0], times[-1], end)])


def _table(name: str, times: Array, values: Sequence[Any], method: str) -> str:
    """One `interpolate` for each component of the values, in a list like one of them."""
    arrays = [array_of(name, value) for value in values]
    if len(arrays) != len(times):
        raise BgError([input_lengths(name, f"{len(times)} times and {len(arrays)} values")])
    shapes = dict.fromkeys(array.shape for array in arrays)
    if len(shapes) > 1:
        one, other = list(shapes)[:2]
        raise BgError([input_lengths(name, f"values of the shapes {one} and {other}")])
    knots = joined(map(repr, times.tolist()))
    columns = np.empty(arrays[0].shape, dtype=object)
    for place in product(*map(range, columns.shape)):
        pairs = zip(arrays, times.tolist(), strict=True)
        column = joined(literal(name, array[place], time) for array, time in pairs)
        columns[place] = f"interpolate([{knots}], [{column}], time, method = {method})"
    return nested(columns, str)


def nested(array: NDArray[Any], write: Callable[[Any], str]) -> str:
    """Write an array as a list of lists of the language, a scalar as itself."""
    if array.ndim == 0:
        return write(array.item())
    rows = map(write, array) if array.ndim == 1 else (nested(row, write) for row in array)
    return f"[{', '.join(rows)}]"


def literal(name: str, item: Any, time: float | None) -> str:
    """Write an SI number, or a text with a number and a unit, in the language."""
    if isinstance(item, str):
        if read_number(item) is None:
            raise BgError([not_a_value(item, name)])
        return item.strip()
    if isinstance(item, bool) or not isinstance(item, Real):
        raise BgError([input_form(name, type(item).__name__)])
    number = _double(item)
    if not math.isfinite(number):
        raise BgError([input_not_finite(name, number, time)])
    return repr(number)


def _double(item: Any) -> float:
    try:
        return float(item)
    except OverflowError:  # a long integer
        return math.inf if item > 0 else -math.inf


def joined(items: Iterable[str]) -> str:
    """Join numbers by commas, some to a line: lines of the language have a limit."""
    listed = list(items)
    rows = (listed[k : k + _A_LINE] for k in range(0, len(listed), _A_LINE))
    return ",\n".join(", ".join(row) for row in rows)


def _listed(name: str, values: Any) -> list[Any]:
    if isinstance(values, (str, Mapping)) or not isinstance(values, Iterable):
        raise BgError([input_form(name, f"pair with {type(values).__name__}")])
    return list(np.asarray(values) if hasattr(values, "__array__") else values)


def array_of(name: str, value: Any) -> NDArray[Any]:
    """The array of a value, whose items keep their types; BG260 for another form."""
    array = _as_objects(value)
    if array.dtype == object and array.ndim == 0 and not isinstance(value, (str, Real)):
        raise BgError([input_form(name, type(value).__name__)])
    return array


def _as_objects(value: Any) -> NDArray[Any]:
    """The array of a value, whose items keep their types; lists of unequal lengths stay items."""
    if isinstance(value, (np.ndarray, np.generic)):
        return np.asarray(value).astype(object)
    try:
        return np.array(value, dtype=object)
    except ValueError:
        found = np.empty((), dtype=object)
        found[()] = value
        return found
