"""One row for each run: its parameters, its observables, its status."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import unknown_column
from bgc.diagnostics.catalogue.machine import package_missing
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.doors import with_doors
from bgc.printing.tables import Table, table_text
from bgc.runtime.results.arrays import Array, Mask
from bgc.runtime.results.ensemble import DONE, INTERRUPTED, placed
from bgc.runtime.results.files import write_arrays, written_whole
from bgc.runtime.results.result import UnknownColumn
from bgc.runtime.results.statistics import Sensitivity, Statistics, sensitivity, statistics
from bgc.values.shown import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINES = 20  # of a table on the terminal


@with_doors
@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """Observables of many runs, SI: `study["max(tension)"]` is (n,), as is `study["mass"]`.

    Attributes
    ----------
    scene, solver
        The scene, and the integration method.
    parameters
        The varied parameters by name, (n,) each.
    names, units
        Observables in the order in which they were asked for, and the units of their values.
    values
        (n, observables); NaN in runs that failed or that have values which are not finite.
    status
        `done`, `failed` or `interrupted`, for each run.
    failures
        The errors, by the number of the run (from 0).
    design
        `grid`, `latin`, `sobol`, `saltelli` or `cases`.
    shown
        Units in which tables and plots show parameters and observables.
    together, alone, warnings, run_warnings, recalled
        As in `Ensemble`.
    """

    scene: str
    solver: str
    parameters: Mapping[str, Array]
    names: tuple[str, ...]
    units: Mapping[str, str]
    values: Array
    status: tuple[str, ...]
    failures: Mapping[int, Diagnostic] = field(default_factory=dict)
    design: str = "cases"
    shown: Mapping[str, Shown] = field(default_factory=dict)
    together: int = 0
    alone: str = ""
    warnings: tuple[Diagnostic, ...] = ()
    recalled: int = 0
    run_warnings: Mapping[int, tuple[Diagnostic, ...]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.values)

    def __contains__(self, name: object) -> bool:
        return name in self.names or name in self.parameters

    def __getitem__(self, name: str) -> Array:
        if name in self.names:
            return self.values[:, self.names.index(name)]
        if name in self.parameters:
            return self.parameters[name]
        known = (*self.names, *self.parameters)
        raise UnknownColumn([unknown_column(name, known)])

    def __repr__(self) -> str:
        bad = len(self) - self.status.count(DONE)
        ended = f", {bad} not completed" if bad else ""
        runs = counted(len(self), "run")
        return f"<bgc study of {self.scene}: {runs}, {', '.join(self.names)}{ended}>"

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.names, *self.parameters]

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.runtime.results.html import table_html

        return table_html(self.statistics().table())

    @property
    def done(self) -> Mask:
        """Mask of the completed runs, (n,) of bool."""
        return np.array([status == DONE for status in self.status], dtype=bool)

    def shown_in(self, name: str) -> Shown:
        """The unit in which a parameter or an observable is shown."""
        return self.shown.get(name) or Shown(self.units.get(name, ""))

    def in_words(self, name: str) -> Array:
        """A parameter or an observable in the unit in which it is shown, (n,)."""
        return self[name] / self.shown_in(name).factor

    def label(self, name: str) -> str:
        """A name with the unit in which it is shown, for axes and headings."""
        unit = self.shown_in(name).label
        return f"{name} [{unit}]" if unit else name

    def statistics(self, quantiles: Sequence[float] = (0.05, 0.5, 0.95)) -> Statistics:
        """Mean, standard deviation, extremes and quantiles of each observable over the runs."""
        return statistics(self, quantiles)

    def sensitivity(self, confidence: float = 0.95) -> Sensitivity:
        """Rank the parameters by their influence on each observable; see `Sensitivity`.

        `confidence` is the probability of the intervals.
        """
        return sensitivity(self, confidence)

    def plot(
        self,
        path: str | Path | None = None,
        observables: Sequence[str] | None = None,
        kind: str | None = None,
    ) -> Figure:
        """Draw observables over the varied parameters; return the figure.

        Parameters
        ----------
        path
            The file to write (`.png`, `.svg`, `.pdf`); none by default.
        observables
            The observables to draw; by default all, up to 6.
        kind
            `curves` over the first parameter, a curve for each value of the others; `map` or
            `contour` over two parameters; `scatter` over each parameter; `histogram`. By default
            curves or a map where the runs form a grid of one or two parameters, else a scatter.
        """
        # Loads matplotlib.
        from bgc.runtime.results.study_plot import plot_study

        return plot_study(self, path, observables, kind)

    def table(self, lines: int = _LINES) -> Table:
        """The first `lines` runs with their parameters and observables."""
        names = (*self.parameters, *self.names)
        columns = [self.in_words(name)[:lines] for name in names]
        rows = tuple(
            (str(k), self.status[k], *(f"{column[k] + 0.0:.6g}" for column in columns))
            for k in range(min(lines, len(self)))
        )
        more = len(self) - len(rows)
        note = f"and {more:,} more" if more else ""
        return Table(f"{self.scene}:", ("run", "status", *map(self.label, names)), rows, note)

    def __str__(self) -> str:
        return table_text(self.table()).rstrip()

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each run: `instance,<parameter>,..,status,<observable>,..`, SI.

        Runs that an interruption left undone are omitted; the others keep their numbers.
        """
        with written_whole(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
            self.write_csv(file)

    def write_csv(self, file: TextIO) -> None:
        """Write as `to_csv` does, to an open file."""
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("instance", *self.parameters, "status", *self.names))
        given = list(self.parameters.values())
        for k in self._written():
            start = (repr(float(column[k])) for column in given)
            writer.writerow((k, *start, self.status[k], *map(repr, self.values[k].tolist())))

    def to_npz(self, path: str | Path) -> None:
        """Write NumPy's compressed archive: `values`, `names`, `status`, `instance` and `about`.

        Each varied parameter is an array `parameter:<name>`; `about` is a JSON text with the units,
        the scene, the solver, the design and the failures.
        """
        about = {
            "scene": self.scene,
            "solver": self.solver,
            "design": self.design,
            "units": dict(self.units),
            "failures": {str(k): why.message for k, why in self.failures.items()},
        }
        written = self._written()
        arrays = {
            "values": self.values[written],
            "instance": np.array(written, dtype=np.int64),
            "names": np.array(self.names),
            "status": np.array(self.status)[written],
            "about": np.array(json.dumps(about)),
            **{f"parameter:{name}": v[written] for name, v in self.parameters.items()},
        }
        write_arrays(path, arrays)

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame with a row for each run."""
        try:
            import pandas as pd  # optional, and slow to load
        except ImportError as problem:
            raise BgError([package_missing("pandas", "`to_pandas`", "pandas")]) from problem
        columns = {**self.parameters, "status": list(self.status)}
        columns |= {name: self[name] for name in self.names}
        return pd.DataFrame(columns, index=pd.RangeIndex(len(self), name="instance"))

    def to_xarray(self) -> Any:
        """Return an xarray Dataset over `instance`: parameters and status are coordinates."""
        try:
            import xarray as xr  # optional, and slow to load
        except ImportError as problem:
            raise BgError([package_missing("xarray", "`to_xarray`", "xarray")]) from problem
        coords: dict[str, Any] = {
            name: ("instance", values, {"units": self.units.get(name, "")})
            for name, values in self.parameters.items()
        }
        found = {name: ("instance", self[name], {"units": self.units[name]}) for name in self.names}
        about = {"scene": self.scene, "solver": self.solver, "design": self.design}
        return xr.Dataset(
            found, coords={**coords, "status": ("instance", list(self.status))}, attrs=about
        )

    def placed_failures(self) -> Iterator[Diagnostic]:
        """List the errors, each with the number and the values (SI) of its run."""
        return placed(self.failures, self.parameters)

    def _written(self) -> list[int]:
        return [k for k, status in enumerate(self.status) if status != INTERRUPTED]


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C while a study ran; `result` holds the runs that were done by then.

    `kept` is true where the next equal call goes on from there.
    """

    def __init__(self, result: Study, kept: bool = False) -> None:
        done = result.status.count(DONE)
        super().__init__(f"interrupted when {done} of {counted(len(result), 'run')} were done")
        self.result = result
        self.kept = kept
