"""The result of an estimation: values with intervals, and the motion with them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bgc.diagnostics.public import public_class
from bgc.language.column_names import name_in_si
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.files import write_rows
from bgc.runtime.studies.found_parameters import FoundParameters
from bgc.runtime.studies.motion import Recorded
from bgc.values.shown_units import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@public_class
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Estimate(FoundParameters):
    """Estimated parameters: `estimate["k"]` is a value, SI, `estimate.interval("k")` its ends.

    Attributes
    ----------
    names, values, half_widths
        The parameters, their estimates and the half widths of their confidence intervals, SI; NaN
        at a bound, and where the data do not determine the parameters.
    start, at_bound
        The values from which the iteration started; whether an estimate lies at its bound.
    confidence, correlation
        The probability of the intervals; the correlation matrix of the estimates.
    recorded, computed
        The data, and the values of the run with the estimates, (rows, columns).
    noise
        The standard deviation of the residuals of each column, or the one that was given.
    converged, runs, failed
        Whether the iteration converged; the number of runs, and of those that failed.
    warnings
        Combinations of parameters that the data do not determine (BG478).
    """

    half_widths: Array
    confidence: float
    correlation: Array
    recorded: Recorded
    computed: Array
    noise: Mapping[str, float]
    shown_columns: Mapping[str, Shown]
    loss: str

    def interval(self, name: str) -> tuple[float, float]:
        """Ends of the confidence interval of a parameter, SI; NaN where there is none."""
        k = self.names.index(name)
        half = float(self.half_widths[k])
        return float(self.values[k]) - half, float(self.values[k]) + half

    def tables(self) -> list[Table]:
        """Estimates, residuals of the columns, and correlations if there are several."""
        rows = []
        for k, shown, label, value, start, note in self._rows():
            ends = " .. ".join(f"{shown.number(end):.6g}" for end in self.interval(self.names[k]))
            interval = "-" if np.isnan(self.half_widths[k]) else ends
            rows.append((label, value, interval, start, note))
        header = ("", "estimate", f"{100 * self.confidence:g} % interval", "start", "")
        title = f"{self.scene}: estimated parameters"
        found = [Table(title, header, tuple(rows), self._note("iteration"))]
        columns = []
        for k, name in enumerate(self.recorded.names):
            known = self.recorded.known[:, k]
            error = (self.computed - self.recorded.values)[known, k]
            shown = self.shown_columns[name]
            cells = (self.noise[name], float(np.sqrt(np.mean(error**2))))
            columns.append((name, *(shown.text(cell, 4) for cell in cells), str(int(known.sum()))))
        heads = ("", "noise", "rms of the residuals", "values")
        found.append(Table("fitted columns", heads, tuple(columns)))
        if len(self.names) > 1 and np.isfinite(self.correlation).any():
            matrix = tuple(
                (name, *(f"{value:.3f}" for value in row))
                for name, row in zip(self.names, self.correlation, strict=True)
            )
            found.append(Table("correlation of the estimates", ("", *self.names), matrix))
        return found

    def to_csv(self, path: str | Path) -> None:
        """Write `parameter,estimate,low,high,start`, SI numbers."""
        rows = (
            (n, self[n], *self.interval(n), x)
            for n, x in zip(self.names, self.start.tolist(), strict=True)
        )
        write_rows(path, ("parameter", "estimate", "low", "high", "start"), rows)

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw each fitted column, recorded and computed; return the figure."""
        # Loads matplotlib.
        from bgc.runtime.studies.plots import plot_estimate

        return plot_estimate(self._drawn(), self.scene, path)

    def _drawn(self) -> list[tuple[str, Any, Any, Any]]:
        """For each column its label, and times, recorded and computed values as shown."""
        found = []
        for k, name in enumerate(self.recorded.names):
            shown = self.shown_columns[name]
            label = shown.heading(name_in_si(name))
            recorded, computed = (
                table[:, k] / shown.factor for table in (self.recorded.values, self.computed)
            )
            found.append((label, self.recorded.time, recorded, computed))
        return found
