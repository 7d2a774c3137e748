"""One row for each run: its parameters, its observables, its status."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TextIO

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.public import public_class
from bgc.printing.text_tables import Table, table_text
from bgc.record_class import dataclass
from bgc.runtime.results.columns import optional_package
from bgc.runtime.results.files import append_rows
from bgc.runtime.results.runs import Interrupted, ObservedRuns
from bgc.runtime.results.statistics import Sensitivity, Statistics, sensitivity, statistics

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINES = 20  # of a table on the terminal


@public_class
@dataclass(frozen=True, eq=False, repr=False)
class Study(ObservedRuns):
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

    noun: ClassVar[str] = "run"

    def __len__(self) -> int:
        return self.count

    def __repr__(self) -> str:
        runs = counted(self.count, self.noun)
        return f"<bgc study of {self.scene}: {runs}, {', '.join(self.names)}{self.undone}>"

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.names, *self.parameters]

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.runtime.results.html import table_html

        return table_html(self.statistics().table())

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

    def write_csv(self, file: TextIO) -> None:
        """Write a line for each run: `instance,<parameter>,..,status,<observable>,..`, SI."""
        given = [column.tolist() for column in self.parameters.values()]
        rows = (
            (k, *(column[k] for column in given), self.status[k], *self.values[k].tolist())
            for k in self._written()
        )
        append_rows(file, ("instance", *self.parameters, "status", *self.names), rows)

    def to_npz(self, path: str | Path) -> None:
        """Write NumPy's compressed archive: `values`, `names`, `status`, `instance` and `about`.

        Each varied parameter is an array `parameter:<name>`; `about` is a JSON text with the units,
        the scene, the solver, the design and the failures.
        """
        self._write_archive(path, {}, {"design": self.design})

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame with a row for each run."""
        pd = optional_package("pandas", "`to_pandas`")
        columns = {**self.parameters, "status": list(self.status)}
        columns |= {name: self[name] for name in self.names}
        return pd.DataFrame(columns, index=pd.RangeIndex(len(self), name="instance"))

    def to_xarray(self) -> Any:
        """Return an xarray Dataset over `instance`: parameters and status are coordinates."""
        return self._dataset(("instance",), {}, design=self.design)


StudyInterrupted = Interrupted
"""An earlier name of `Interrupted`."""
