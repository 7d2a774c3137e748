"""Named columns: their lookup with or without unit, by vector or matrix, and their units as shown.

A scene that observes a quantity in a unit has it in the name of the column, `bore [bar]`. Vectors
and matrices have a column for each component: `tip[1]`, `tip[2]`, .. and `R[1,1]`, `R[1,2]`, ..
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue import listed
from bgc.diagnostics.catalogue.arguments import unknown_column
from bgc.diagnostics.catalogue.machine import package_missing
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_class
from bgc.language.column_names import column_of, component_of, name_in_si
from bgc.language.scene import Plot
from bgc.runtime.results.arrays import Array
from bgc.values.shown_units import Shown


class UnknownColumn(BgError, KeyError):
    """A result has no column of the requested name."""

    __str__ = BgError.__str__


def find_columns(name: object, columns: Collection[str]) -> tuple[list[str], tuple[int, ...]]:
    """Find the columns of a quantity in the order of its components, and its shape.

    The shape is () for a scalar or one component, (k,) for the k observed components of a vector,
    (rows, columns) for a matrix with all of its components. No columns where none has the name, and
    where the name leaves open which of several units is meant.
    """
    if not isinstance(name, str):
        return [], ()
    spellings = (name, column_of(name))
    for spelling in spellings:
        if spelling in columns:
            return [spelling], ()
    alike = [column for column in columns if name_in_si(column) in spellings]
    if alike:
        return (alike, ()) if len(alike) == 1 else ([], ())
    parts: dict[str, dict[tuple[int, ...], str]] = {}
    for column in columns:
        whole, index = component_of(column)
        if index and name in (whole, name_in_si(whole)):
            place = tuple(map(int, index.split(",")))
            parts.setdefault(whole, {})[place] = column
    if len(parts) != 1 and name not in parts:
        return [], ()
    found = parts.get(name) or next(iter(parts.values()))
    places = sorted(found)
    shape = tuple(map(max, zip(*places, strict=True))) if len(places[0]) > 1 else (len(places),)
    if math.prod(shape) != len(places):
        return [], ()
    return [found[place] for place in places], shape


def whole_names(columns: Iterable[str]) -> list[str]:
    """The vectors and matrices whose components are columns."""
    return list(dict.fromkeys(whole for column in columns if (whole := component_of(column)[0])))


class InUnits:
    """A base of results whose values are SI, and are shown in the units as written."""

    units: Mapping[str, str]
    shown: Mapping[str, Shown]

    def shown_in(self, name: str) -> Shown:
        """The unit in which a column is shown: as written, else that of its values."""
        return self.shown.get(name) or Shown(self.units.get(name, ""))

    def label(self, name: str) -> str:
        """A name with the unit in which it is shown, for axes and headings."""
        return self.shown_in(name).heading(name_in_si(name))


@public_class
class NamedColumns(InUnits, Mapping[str, Array]):
    """A base of the rows of one run and of many: a mapping from names to arrays.

    Arrays have the rows in their last axis, or before the axes of a vector or matrix.
    """

    time: Array

    __eq__ = object.__eq__  # arrays have no truth value
    __hash__ = object.__hash__

    @abstractmethod
    def _names(self) -> Collection[str]:
        """The columns in the order in which the scene observes them."""

    @abstractmethod
    def _values_of(self, column: str) -> Array:
        """The values of a column, (.., rows)."""

    def __getitem__(self, name: str) -> Array:
        columns, shape = self._found(name)
        return _joined([self._numbers(column) for column in columns], shape)

    def __contains__(self, name: object) -> bool:
        return name == "time" or bool(find_columns(name, self._names())[0])

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())

    def _ipython_key_completions_(self) -> list[str]:
        return ["time", *self._names(), *whole_names(self._names())]

    def expand(self, names: Sequence[str]) -> list[str]:
        """Replace the names of vectors and matrices by those of their columns.

        Raises BgError: BG065 for unknown names.
        """
        return [column for name in names for column in self._found(name)[0]]

    def in_words(self, name: str) -> Array:
        """A column, a vector or a matrix in the units as written."""
        columns, shape = self._found(name)
        parts = [self._numbers(column) / self.shown_in(column).factor for column in columns]
        return _joined(parts, shape)

    def _numbers(self, column: str) -> Array:
        is_time = column == "time" and column not in self._names()
        return self.time if is_time else self._values_of(column)

    def _found(self, name: str) -> tuple[list[str], tuple[int, ...]]:
        """The columns of a name and its shape; BG065 where there are none."""
        columns, shape = find_columns(name, self._names())
        if not columns and name == "time":
            return ["time"], ()
        if not columns:
            raise _missing(name, self._names())
        return columns, shape


class RunColumns(NamedColumns):
    """A base of the rows of one run, with what a plot of them shows besides."""

    scene: str
    status: str
    panels: Sequence[Plot]
    errors: Mapping[str, Array]


def _joined(parts: Sequence[Array], shape: tuple[int, ...]) -> Array:
    """Join components along the last axes; a single column stays as it is."""
    if not shape:
        return parts[0]
    side_by_side = np.stack(parts, axis=-1)
    return side_by_side.reshape(*side_by_side.shape[:-1], *shape)


def _missing(name: object, columns: Collection[str]) -> UnknownColumn:
    every = (*columns, *whole_names(columns))
    problem = unknown_column(name, dict.fromkeys((*every, *map(name_in_si, every))))
    alike = [column for column in columns if name_in_si(column) == name]
    if alike:
        problem = replace(problem, help=f"write it with its unit: {listed(alike)}")
    return UnknownColumn([problem])


def optional_package(name: str, purpose: str, extra: str = "") -> Any:
    """Import a package that few users need, and that is slow to load.

    `purpose` is what needs it, `extra` the extra of bgc that installs it, by default of the same
    name. Raises BgError: BG058 where it is not installed.
    """
    try:
        return import_module(name)
    except ImportError as problem:
        raise BgError([package_missing(name, purpose, extra or name)]) from problem


def dataset(
    variables: Mapping[str, Array],
    units: Mapping[str, str],
    dims: tuple[str, ...],
    coordinates: Mapping[str, Mapping[str, tuple[Any, str]]],
    about: Mapping[str, str],
) -> Any:
    """Make an xarray Dataset of variables over the same dimensions, each with its unit.

    `coordinates` are values with a unit by name, for each dimension that has some. Raises BgError:
    BG058 without xarray.
    """
    xarray = optional_package("xarray", "`to_xarray`")
    found = {
        name: (dims, values, {"units": units.get(name, "")}) for name, values in variables.items()
    }
    along = {
        name: (dim, values, {"units": unit} if unit else {})
        for dim, some in coordinates.items()
        for name, (values, unit) in some.items()
    }
    return xarray.Dataset(found, coords=along, attrs=dict(about))
