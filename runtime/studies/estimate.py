"""The result of an estimation: values with intervals, and the motion with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.doors import with_doors
from bgc.printing.tables import Table
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.files import written_whole
from bgc.runtime.results.tabled import Tabled
from bgc.runtime.studies.motion import Recorded
from bgc.values.shown import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@with_doors
@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Tabled):
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

    scene: str
    names: tuple[str, ...]
    values: Array
    half_widths: Array
    start: Array
    at_bound: tuple[bool, ...]
    confidence: float
    correlation: Array
    recorded: Recorded
    computed: Array
    noise: Mapping[str, float]
    shown: Mapping[str, Shown]
    shown_columns: Mapping[str, Shown]
    converged: bool
    loss: str
    runs: int
    failed: int
    warnings: tuple[Diagnostic, ...] = ()

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)])

    def interval(self, name: str) -> tuple[float, float]:
        """Ends of the confidence interval of a parameter, SI; NaN where there is none."""
        k = self.names.index(name)
        half = float(self.half_widths[k])
        return float(self.values[k]) - half, float(self.values[k]) + half

    def parameters(self) -> dict[str, float]:
        """The estimates by name, SI: an argument of `Model.simulate(parameters=..)`."""
        return dict(zip(self.names, self.values.tolist(), strict=True))

    def tables(self) -> list[Table]:
        """Estimates, residuals of the columns, and correlations if there are several."""
        rows = []
        for k, name in enumerate(self.names):
            shown = self.shown[name]
            half = self.half_widths[k]
            ends = "-" if np.isnan(half) else " .. ".join(
                f"{shown.number(end):.6g}" for end in self.interval(name)
            )  # fmt: skip
            note = "at its bound" if self.at_bound[k] else ""
            label = f"{name} [{shown.label}]" if shown.label else name
            start = f"{shown.number(self.start[k]):.6g}"
            rows.append((label, f"{shown.number(self.values[k]):.6g}", ends, start, note))
        header = ("", "estimate", f"{100 * self.confidence:g} % interval", "start", "")
        ended = "" if self.converged else "the iteration did not converge"
        failed = f", {self.failed} of which failed" if self.failed else ""
        note = "\n".join(filter(None, (f"{counted(self.runs, 'run')}{failed}", ended)))
        found = [Table(f"{self.scene}: estimated parameters", header, tuple(rows), note)]
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
        """Write `parameter,unit,estimate,low,high,start`, SI numbers."""
        with written_whole(path) as aside, aside.open("w", encoding="utf-8") as file:
            file.write("parameter,estimate,low,high,start\n")
            for k, name in enumerate(self.names):
                cells = (self[name], *self.interval(name), float(self.start[k]))
                file.write(f"{name},{','.join(map(repr, cells))}\n")

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
            label = f"{name} [{shown.label}]" if shown.label and "[" not in name else name
            recorded, computed = (
                table[:, k] / shown.factor for table in (self.recorded.values, self.computed)
            )
            found.append((label, self.recorded.time, recorded, computed))
        return found
