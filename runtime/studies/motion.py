"""A recorded motion, and its columns matched to those that a scene observes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from bgc.diagnostics.catalogue import did_you_mean, listed
from bgc.diagnostics.catalogue.studies import bad_case_table, cannot_fit
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.column_names import column_of, name_in_si
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array, Mask
from bgc.runtime.results.result import Result
from bgc.runtime.running.csv_tables import factor, read_columns
from bgc.runtime.running.loaded_model import LoadedModel, Variable

_LARGEST_VALUE = 1e100  # value: sums of its squares, weighted, are far from the largest double

Motion: TypeAlias = str | Path | Result | Mapping[str, Array]
"""A CSV file with the column `time`, a result, or columns by name (SI)."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """Recorded values of columns of a scene.

    Attributes
    ----------
    time
        Times of the rows of a run, s, (rows,); the first is 0.
    names
        The fitted columns.
    values
        The recorded values in the units of these columns, (rows, columns); NaN where none is
        recorded: in a row that a run needs at its start, and in empty cells.
    """

    time: Array
    names: tuple[str, ...]
    values: Array

    @property
    def known(self) -> Mask:
        """Mask of the recorded values."""
        return np.isfinite(self.values)


def read_motion(
    motion: Motion, model: LoadedModel, match: Mapping[str, str], columns: Sequence[str] = ()
) -> Recorded:
    """Read a motion, and match its columns to the observed ones.

    `match` gives the observed column of a recorded one of another name. `columns` are the observed
    columns to fit; by default all that were recorded.

    Raises BgError: BG788 for an unreadable file, BG479 where no column matches, BG063 for a unit.
    """
    path = str(motion) if isinstance(motion, (str, Path)) else "the motion"
    found = _columns_of(motion)
    time = _times(found, path)
    names = [name for name, _ in found if name != "time"]
    for name in match:
        if name not in names:
            way_out = did_you_mean(name, names) or f"the data have {listed(names)}"
            raise BgError([cannot_fit(f"the data have no column `{name}`", way_out)])
    known = {spelling: v for v in model.outputs for spelling in (v.name, name_in_si(v.name))}
    fitted: dict[str, Array] = {}
    for (name, unit), values in found.items():
        if name == "time" or (name not in match and name in match.values()):
            continue  # a column that another one replaces
        wanted = match.get(name, name)
        variable = known.get(wanted) or known.get(column_of(wanted))
        if variable is None or (columns and not {wanted, variable.name} & {*columns}):
            if name in match:
                near = did_you_mean(wanted, known) or f"the scene observes {listed([*known])}"
                raise BgError([cannot_fit(f"the scene does not observe `{wanted}`", near)])
            continue
        if len(values) != len(time):
            raise BgError([bad_case_table(path, f"`{name}` and `time` differ in length")])
        fitted[variable.name] = _fitted(values, name, unit, variable)
    if not fitted:
        raise BgError([_nothing_in_common(names, model)])
    table = np.column_stack(list(fitted.values()))
    if time[0] > 0:  # a run begins at 0, where nothing is recorded
        time = np.concatenate(([0.0], time))
        table = np.concatenate((np.full((1, table.shape[1]), np.nan), table))
    return Recorded(time, tuple(fitted), table)


def _columns_of(motion: Motion) -> Mapping[tuple[str, str], Array]:
    """The columns of a motion by name and unit; an empty unit stands for SI."""
    if isinstance(motion, (str, Path)):
        return read_columns(motion)
    if isinstance(motion, Result):
        pairs = ((name, motion[name]) for name in ("time", *motion))
        return {(name_in_si(name), _unit_of(motion, name)): values for name, values in pairs}
    return {(name, ""): np.asarray(values, float) for name, values in motion.items()}


def _times(found: Mapping[tuple[str, str], Array], path: str) -> Array:
    """The recorded times, s, which rise; BG788 where they do not."""
    times = [values * factor(unit, name, "s") for (name, unit), values in found.items()
             if name == "time"]  # fmt: skip
    if not times:
        raise BgError([bad_case_table(path, "it has no column `time`")])
    time = times[-1]
    if len(time) < 2:
        raise BgError([bad_case_table(path, "it has fewer than two rows")])
    if not (np.diff(time) > 0).all() or time[0] < 0 or not np.isfinite(time).all():
        raise BgError([bad_case_table(path, "its times do not rise from 0 or later")])
    return time


def _fitted(values: Array, name: str, unit: str, variable: Variable) -> Array:
    """A recorded column in the unit of the observed one; BG479 for values without a square."""
    converted = values * _into(unit, name, variable)
    largest = float(np.abs(converted[np.isfinite(values)]).max(initial=0.0))
    if largest > _LARGEST_VALUE:
        reason = f"`{name}` has a value of {largest:.3g}, whose square is no longer a number"
        raise BgError([cannot_fit(reason, "correct the value or its unit")])
    return converted


def _nothing_in_common(names: Sequence[str], model: LoadedModel) -> Diagnostic:
    recorded = ", ".join(f"`{name}`" for name in names)
    observed = ", ".join(f"`{v.name}`" for v in model.outputs)
    return cannot_fit(
        f"the scene observes {observed or 'nothing'}, the data have {recorded}",
        'name the columns alike, or give `--match "OBSERVED=RECORDED"`',
    )


def _into(unit: str, name: str, variable: Variable) -> float:
    """The factor from the unit of a recorded column to that of an observed one."""
    if not unit:
        return 1.0
    return factor(unit, name, variable.unit) / factor(variable.unit, name, variable.unit)


def _unit_of(result: Result, name: str) -> str:
    unit = "s" if name == "time" else result.units.get(name, "")
    return "" if unit == "1" else unit
