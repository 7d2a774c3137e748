"""The result of an optimisation: the best design, its limits, and the way to it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.public import public_class
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.files import write_rows
from bgc.runtime.results.observables import Criterion, Observable
from bgc.runtime.results.runs import Interrupted
from bgc.runtime.studies.found_parameters import FoundParameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_REACHED = 1e-3  # share of a limit within which it counts as reached


@dataclass(frozen=True, slots=True)
class Limit:
    """A criterion at the best design: its value in the worst case, and the free share of it."""

    criterion: Criterion
    value: float
    case: int
    slack: float

    @property
    def note(self) -> str:
        """`exceeded`, `reached`, or nothing."""
        if self.slack < -1e-6:
            return "exceeded"
        return "reached" if self.slack <= _REACHED else ""


@public_class
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Optimum(FoundParameters):
    """The best design: `optimum["k"]` is the value of a parameter, SI.

    Attributes
    ----------
    names, values, low, high, start
        The varied parameters, their values in the best design, their bounds and the values from
        which the search started, SI.
    at_bound
        Whether a parameter lies at a bound.
    objective, at_start
        The observable `goal` of the best design and of the start, in the unit of its column; of
        several cases the worst one or the mean (`judge`).
    governing
        The number of the case that is worst for the objective.
    limits
        The criteria with their values in the worst case.
    over
        Parameters over which each design runs, with their values in its cases, SI.
    converged, search
        Whether the search converged; `gradient` or `evolution`.
    runs, failed, failures
        The number of runs, of those that failed, and their errors.
    history
        Runs, objective and largest excess over a limit (a share of it) whenever a better design was
        found, (n, 3).
    warnings
        Limits that no design met (BG656), parameters without influence (BG657).
    """

    low: Array
    high: Array
    goal: Observable
    largest: bool
    judge: str
    objective: float
    at_start: float
    governing: int
    limits: tuple[Limit, ...]
    over: Mapping[str, Array]
    search: str
    failures: tuple[Diagnostic, ...]
    history: Array

    @property
    def feasible(self) -> bool:
        """True where all limits are met."""
        return all(each.note != "exceeded" for each in self.limits)

    def tables(self) -> list[Table]:
        """The design with its objective; the limits, if there are any."""
        rows = []
        for k, shown, label, value, start, note in self._rows():
            bounds = " .. ".join(f"{shown.number(x):.6g}" for x in (self.low[k], self.high[k]))
            rows.append((label, value, start, bounds, note))
        found = [
            Table(f"{self.scene}: best design", ("", "best", "start", "bounds", ""), tuple(rows)),
            self._objective_table(),
        ]
        if self.limits:
            lines = tuple(
                (each.criterion.name, each.criterion.observable.shown.text(each.value), each.note)
                for each in self.limits
            )
            found.append(Table("limits", ("", "value", ""), lines))
        return found

    def _objective_table(self) -> Table:
        shown = self.goal.shown
        way = "maximised" if self.largest else "minimised"
        joined = ""
        if self.over:
            count = len(next(iter(self.over.values())))
            joined = f", {'mean' if self.judge == 'mean' else 'worst'} of {count} cases"
        worst = []
        if self.over and self.judge == "worst":
            at = ", ".join(
                f"{name} = {self.shown[name].text(float(values[self.governing]))}"
                for name, values in self.over.items()
            )
            worst = [f"the worst case is {at}"]
        cells = (self.goal.name, shown.text(self.objective), shown.text(self.at_start))
        return Table(
            f"{way}{joined}", ("", "best", "start"), (cells,), self._note("search", *worst)
        )

    def to_csv(self, path: str | Path) -> None:
        """Write `name,best,start,low,high`: parameters, the objective and limits, SI numbers."""
        columns = (self.names, self.values, self.start, self.low, self.high)
        rows: list[tuple[object, ...]] = [*zip(*columns, strict=True)]
        rows.append((self.goal.name, self.objective, self.at_start, None, None))
        for each in self.limits:
            limit = each.criterion.limit
            ends = (None, limit) if each.criterion.below else (limit, None)
            rows.append((each.criterion.observable.name, each.value, None, *ends))
        write_rows(path, ("name", "best", "start", "low", "high"), rows)

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw the objective and the largest excess over the runs; return the figure."""
        # Loads matplotlib.
        from bgc.runtime.studies.plots import plot_optimum

        shown = self.goal.shown
        label = shown.heading(self.goal.name)
        return plot_optimum(self.history / (1.0, shown.factor, 1.0), label, self.scene, path)


OptimisationInterrupted = Interrupted
"""An earlier name of `Interrupted`."""
