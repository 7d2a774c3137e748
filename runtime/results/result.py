"""The result of a run: named columns over time, and their export to files and pandas."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.accuracy import out_of_balance, value_not_finite
from bgc.diagnostics.catalogue.arguments import unknown_parameter
from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.public import public_class
from bgc.language.scene import Plot
from bgc.record_class import dataclass, field, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import RunColumns, dataset, find_columns, optional_package
from bgc.runtime.results.error_estimate import NOT_ASKED, unknown
from bgc.runtime.results.files import WrittenAsCsv, write_arrays
from bgc.runtime.results.recorded_shapes import Shape, arrays_of, described
from bgc.runtime.results.requirements import Requirement
from bgc.runtime.results.rest_report import AtRest
from bgc.runtime.results.row_files import CsvRows, RowArray, RowFile
from bgc.runtime.results.slopes import Slopes, column_name
from bgc.values.shown_units import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_UNBALANCED = 0.005  # of the energy exchanged: beyond rounding and the usual tolerances


def unbalanced(residual: float, exchanged: float) -> bool:
    """Return whether an energy residual is too large compared with the energy exchanged, both in J.

    A bond graph conserves energy whatever its laws, so the residual is an error of the method.
    """
    return residual > _UNBALANCED * exchanged > 0


def joules(values: Array, unit: str) -> Array:
    """Convert energies in a unit to J."""
    if unit == "J":
        return values
    # The compiler's units are slow to load, and results in J do without them.
    from bgc.values.units import parse_unit

    read = parse_unit(unit)
    assert read is not None
    return values * float(read.factor)


def balance_warnings(time: Array, residual: Array, exchanged: float) -> Iterator[Diagnostic]:
    """Warn of rows whose energy residual is too large (BG716).

    `residual` is the column at the times of the rows, s; it and the energy exchanged are in J.
    """
    sizes = np.abs(residual)
    if len(time) and unbalanced(largest := float(sizes.max()), exchanged):
        first = int(np.argmax(sizes > _UNBALANCED * exchanged))
        yield out_of_balance(float(time[first]), largest / exchanged)


def not_finite(time: Array, columns: Mapping[str, Array]) -> Iterator[Diagnostic]:
    """Warn of the column that is the first to have a value that is not finite (BG712)."""
    worst: tuple[int, str, bool] | None = None
    for name, column in columns.items():
        finite = np.isfinite(column)
        row = int(np.argmin(finite)) if len(finite) else 0  # the first that is not
        if not finite.all() and (worst is None or row < worst[0]):
            worst = row, name, not finite[row:].any()
    if worst is not None:
        row, name, to_the_end = worst
        yield value_not_finite(name, float(time[row]), to_the_end)


@public_class
@dataclass(frozen=True, eq=False, repr=False)
class Result(RunColumns, WrittenAsCsv):
    """Rows of a run, as columns by name; SI values.

    `result["tip.z"]` is a column, (n,); `result["tip"]` the vector `tip[1]`, `tip[2]`, .. in its
    shape, (n, 3), and so is a matrix `R[1,1]`, `R[1,2]`, ..; `result["time"]` is `result.time`. A
    column that the scene observes in a unit has it in its name, `angle [deg]`, and its values are
    in that unit; `result["angle"]` finds it too.

    Attributes
    ----------
    scene, solver
        The scene, and the integration method.
    time
        Times of the rows, s, (n,).
    columns, units
        Observed columns by name, in the scene's order, and the units of their values.
    shown
        The units as written, in which plots and tables show columns: `Shown("bar", 1e5)` where the
        column itself is in Pa. `result.in_words("pressure")` are the numbers in that unit.
    shapes
        The shapes of all parts with their poses at each row, of a run with `shapes=True`.
    counts
        Steps, evaluations and seconds of the run.
    status, message
        `done`; or `failed` or `interrupted` with the reason, and the rows up to there.
    panels
        The plots that the scene specifies.
    accounts
        Columns of the energy accounts: `{"residual": "energy.residual"}`; the first of each.
    notices
        Warnings about the method and the parameters of the run.
    faster
        An explicit method that would take much less time; empty where none is known.
    rows
        Of a run whose rows went to a file and are too many for memory: their number. The result
        then has a selection: rows at equal intervals, and those at which a column is least or
        largest. 0 where it has all rows; `row_count` is the number in both cases.
    at_rest
        The start at rest: residual, largest moves, varied parameters. None for other starts.
    errors, error_estimate
        By how much the observed columns are off, where that was estimated, and in words how, or why
        not. `error` finds them by the names of columns and vectors.
    sensitivities
        Derivatives of the columns, of a run with `sensitivities`, by the name of the parameter;
        `sensitivity` reads them.
    requirements
        What the scene requires, with the values of the run, their margins and whether they hold.
    warnings
        The notices, and warnings about the rows: a value that is not finite, energies that do
        not balance.
    """

    scene: str
    time: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    solver: str
    counts: Mapping[str, float]
    status: str = "done"
    message: str = ""
    panels: Sequence[Plot] = ()
    accounts: Mapping[str, str] = field(default_factory=dict)
    notices: tuple[Diagnostic, ...] = ()
    faster: str = ""
    shown: Mapping[str, Shown] = field(default_factory=dict)
    shapes: tuple[Shape, ...] = ()
    rows: int = 0
    at_rest: AtRest | None = None
    errors: Mapping[str, Array] = field(default_factory=dict)
    error_estimate: str = NOT_ASKED
    requirements: tuple[Requirement, ...] = ()
    sensitivities: Mapping[str, Slopes] = field(default_factory=dict)

    @property
    def error(self) -> Result:
        """The estimated errors, in the shapes and units of their columns; 0 or more.

        `result.error["tip.z"]` has for each row the largest error since the row before. It is NaN
        where there is no estimate that can be relied on: `error_estimate` says why. It is a result
        itself: `result.error.to_csv("errors.csv")`.
        """
        columns = {**unknown(self.columns), **self.errors}
        bare: dict[str, Any] = {"errors": {}, "accounts": {}}
        return replace(self, columns=columns, requirements=(), notices=(), shapes=(), **bare)

    def sensitivity(self, name: str, parameter: str) -> Array:
        """The derivative of a column or vector by a parameter of the run, in the shape of both.

        It has the unit of the column for each SI unit of the parameter: see `sensitivity_unit`. A
        vector as parameter has its components in the last axis. The run was made with
        `sensitivities`; by the name of a state it is the derivative by its initial value.

        Raises BgError: BG065 for an unknown column or an energy account, BG060 for a parameter
        that `sensitivities` did not name.
        """
        found, shape = find_columns(parameter, self.sensitivities)
        if not found:
            raise BgError([unknown_parameter(parameter, self.sensitivities)])
        parts = [replace(self, columns=self.sensitivities[each].columns)[name] for each in found]
        if not shape:
            return parts[0]
        side_by_side = np.stack(parts, axis=-1)
        return side_by_side.reshape(*side_by_side.shape[:-1], *shape)

    def sensitivity_unit(self, name: str, parameter: str) -> str:
        """The unit of `sensitivity` of a column by a parameter or a component: `m/kg`."""
        (column, *_) = self.expand([name])
        found, _ = find_columns(parameter, self.sensitivities)
        if not found:
            raise BgError([unknown_parameter(parameter, self.sensitivities)])
        return self.sensitivities[found[0]].unit_of(self.units[column])

    def with_sensitivities(self) -> Result:
        """The same rows with a column for each derivative, `d tip_height/d crane.boom.mass`."""
        columns, units = dict(self.columns), dict(self.units)
        for parameter, slopes in self.sensitivities.items():
            for column, values in slopes.columns.items():
                name = column_name(column, parameter)
                columns[name], units[name] = values, slopes.unit_of(self.units[column])
        return replace(self, columns=columns, units=units)

    @property
    def row_count(self) -> int:
        """The number of rows of the run."""
        return self.rows or len(self.time)

    def in_joules(self, account: str) -> Array:
        """An observed energy account, `"residual"`, in J whatever the unit of its column, (n,)."""
        column = self.accounts[account]
        return joules(self.columns[column], self.units[column])

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """The notices, and warnings about the rows: BG712, BG716."""
        return (*self.notices, *not_finite(self.time, self.columns), *self._unbalanced())

    def _unbalanced(self) -> Iterator[Diagnostic]:
        if "residual" in self.accounts:
            exchanged = self.counts.get("exchanged", 0.0)
            yield from balance_warnings(self.time, self.in_joules("residual"), exchanged)

    def ended(self, status: str, message: str) -> Result:
        """Return the same rows, marked as those of a run that ended early."""
        return replace(self, status=status, message=message)

    def noted(self, notice: Diagnostic) -> Result:
        """Return the same rows with one more warning."""
        return replace(self, notices=(*self.notices, notice))

    def _names(self) -> Mapping[str, Array]:
        return self.columns

    def _values_of(self, column: str) -> Array:
        return self.columns[column]

    def shown_in(self, name: str) -> Shown:
        """The unit in which a column is shown: as written, else that of its values."""
        return Shown("s") if name == "time" else super().shown_in(name)

    def __repr__(self) -> str:
        end = f"{self.time[-1]:g} s" if len(self.time) else "its start"
        ended = "" if self.status == "done" else f", {self.status}: {self.message}"
        rows = counted(len(self.time), "row")
        rows = f"{len(self.time):,} of {self.rows:,} rows" if self.rows else rows
        return f"<bgc result of {self.scene}: {rows} to {end}{ended}>"

    def _repr_html_(self) -> str:
        # Loads matplotlib; only a notebook needs it.
        from bgc.runtime.results.notebook import result_html

        return result_html(self)

    def write_csv(self, file: TextIO) -> None:
        """Write `time,<name>,..` and a line for each row; SI, in full precision."""
        self._append_to(CsvRows(file, self._row_arrays()))

    def to_npz(self, path: str | Path) -> None:
        """Write NumPy's compressed archive: an array for each column, `time`, and `about`.

        `about` is a JSON text with the units of the values, the units in which they are shown and
        their factors to SI, the scene, its panels, the solver and the status.
        """
        arrays = {
            **self.columns,
            **arrays_of(self.shapes),
            "time": self.time,
            "about": np.array(json.dumps(self.about())),
        }
        write_arrays(path, arrays)

    def to_zarr(self, path: str | Path) -> None:
        """Write a Zarr group (version 3): an array for each column and `time`; xarray opens it.

        A group that an earlier result was written to is replaced. Raises BgError: BG058 without
        Zarr, BG055 where the path holds something else or cannot be written.
        """
        # Only this file needs Zarr.
        from bgc.runtime.results.zarr_rows import ZarrRows

        try:
            self._append_to(ZarrRows(Path(path), self._row_arrays(), self.about()))
        except OSError as problem:
            raise BgError([cannot_write(str(path), problem.strerror or str(problem))]) from problem

    def about(self) -> dict[str, Any]:
        """Describe the columns and the run, as files of rows have it."""
        return {
            "scene": self.scene,
            "solver": self.solver,
            "status": self.status,
            "message": self.message,
            "units": {"time": "s", **self.units},
            "shown": {name: self.shown_in(name).unit for name in self.columns},
            "factors": {name: self.shown_in(name).factor for name in self.columns},
            "panels": [[panel.columns, panel.across] for panel in self.panels],
            **({"shapes": described(self.shapes)} if self.shapes else {}),
        }

    def _row_arrays(self) -> list[RowArray]:
        """The columns as arrays of a file."""
        units = self.units
        return [RowArray(name, units[name], (), (k,)) for k, name in enumerate(self.columns)]

    def _append_to(self, file: RowFile) -> None:
        rows = np.column_stack((*self.columns.values(), self.time))[:, : len(self.columns)]
        file.append(self.time, rows)
        file.end(self.about())

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame with a column for each name and `time` as its index."""
        pd = optional_package("pandas", "`to_pandas`")
        frame = pd.DataFrame(dict(self.columns), index=pd.Index(self.time, name="time"))
        frame.attrs["units"] = {"time": "s", **self.units}
        return frame

    def to_polars(self) -> Any:
        """Return a Polars DataFrame with `time` and a column for each name."""
        pl = optional_package("polars", "`to_polars`")
        return pl.DataFrame({"time": self.time, **self.columns})

    def to_xarray(self) -> Any:
        """Return an xarray Dataset over `time`: one variable for each name, with its unit."""
        about = {"scene": self.scene, "solver": self.solver, "status": self.status}
        time = {"time": {"time": (self.time, "s")}}
        return dataset(self.columns, self.units, ("time",), time, about)

    def plot(
        self,
        path: str | Path | None = None,
        columns: Sequence[str] | None = None,
        panels: Sequence[str] | None = None,
    ) -> Figure:
        """Plot the scene's panels, or else all columns stacked by unit; return the figure.

        Parameters
        ----------
        path
            The file to write (`.png`, `.svg`, `.pdf`); none by default.
        columns
            Columns or vectors to show against time, stacked by unit.
        panels
            The contents of each panel instead: `"tip.z, handle.z"` against time, or
            `"force against elevation"`.
        """
        # Loads matplotlib, which takes longer than most runs.
        from bgc.runtime.results.plot import plot_result

        return plot_result(self, path, columns, panels)
