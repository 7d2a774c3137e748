"""The result of a study of operability: cells, limits, downtime, tables and files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.studies import bad_case_table
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.public import public_class
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array, Mask
from bgc.runtime.results.files import write_rows
from bgc.runtime.results.html import Tabled
from bgc.runtime.results.observables import Criterion
from bgc.runtime.results.study import Study
from bgc.runtime.running.csv_tables import number_of, read_rows
from bgc.values.shown_units import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LETTERS = "abcdefghijklmnopqrstuvwxyz"
_FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Scatter:
    """A scatter diagram: how often each sea state occurs, (heights, periods), of sum 1."""

    heights: Array
    periods: Array
    shares: Array


@dataclass(frozen=True, slots=True)
class Downtime:
    """Shares of the time, for each heading and for all with equal weight.

    `outside` is the share of sea states outside the heights and periods that were run: above the
    heights they count as downtime, beside the periods the nearest period decides.
    """

    headings: Array
    shares: Array
    total: float
    outside: float


def read_scatter(path: str | Path) -> Scatter:
    """Read a scatter diagram: periods (s) in the first line, heights (m) in the first column.

    The numbers are the middles of their bins; cells are counts or shares, empty for none.

    Raises BgError: BG788.
    """
    (line, header), *rows = read_rows(path)
    periods = np.array([number_of(cell, path, line) for cell in header[1:]])
    table = np.zeros((len(rows), len(periods)))
    heights = np.empty(len(rows))
    for k, (number, row) in enumerate(rows):
        if len(row) != len(header):
            reason = f"it has {counted(len(row), 'cell')} below {counted(len(header), 'name')}"
            raise BgError([bad_case_table(str(path), reason, number)])
        heights[k] = number_of(row[0], path, number)
        table[k] = [number_of(cell, path, number) if cell else 0.0 for cell in row[1:]]
        if (table[k] < 0).any():
            raise BgError([bad_case_table(str(path), "a count is negative", number)])
    if not table.sum() > 0:
        raise BgError([bad_case_table(str(path), "it counts no sea state")])
    return Scatter(heights, periods, table / table.sum())


@public_class
@dataclass(frozen=True, eq=False, repr=False)
class Operability(Tabled):
    """Sea states with the criteria that hold in them.

    Arrays over cells are (headings, periods, heights), those of criteria have them last; SI.

    Attributes
    ----------
    headings, periods, heights
        The values of the sea; one NaN where no heading was given.
    criteria
        The criteria, in the order of the last axis.
    values, utilisation
        What each criterion limits, and its share of the limit; above 1, or infinite after a failed
        run, the sea state is not operable.
    failed
        Whether a run of a cell failed.
    study
        All runs.
    """

    scene: str
    parameters: Mapping[str, str]
    shown: Mapping[str, Shown]
    headings: Array
    periods: Array
    heights: Array
    criteria: tuple[Criterion, ...]
    values: Array
    utilisation: Array
    failed: Mask
    study: Study
    judge: str
    exposure: float | None

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Warnings about the method and the runs: those of `study`."""
        return self.study.warnings

    @property
    def worst(self) -> Array:
        """The largest utilisation of each cell; infinite where it is not known."""
        return np.asarray(np.where(np.isnan(self.utilisation), np.inf, self.utilisation).max(-1))

    @property
    def operable(self) -> Mask:
        """True in cells in which all criteria hold."""
        return np.asarray(self.worst <= 1)

    def governing(self, heading: int, period: int, height: int) -> str:
        """The criterion of the largest utilisation in a cell, or `failed`.

        `heading`, `period` and `height` are places from 0 in the values of the study.
        """
        if self.failed[heading, period, height]:
            return _FAILED
        known = np.nan_to_num(self.utilisation[heading, period, height], nan=np.inf)
        return self.criteria[int(known.argmax())].name

    def limiting_heights(self) -> Array:
        """The height up to which all heights are operable, m, (headings, periods).

        Between two heights the utilisation is linear. 0 where the least height is not operable, the
        largest where all are.
        """
        worst = self.worst
        found = np.zeros(worst.shape[:2])
        for place in np.ndindex(found.shape):
            column = worst[place]
            bad = np.flatnonzero(~(column <= 1))
            if not len(bad):
                found[place] = self.heights[-1]
            elif bad[0] > 0:
                k = int(bad[0])
                rise = column[k] - column[k - 1]
                share = (1 - column[k - 1]) / rise if np.isfinite(rise) else 0.0
                found[place] = self.heights[k - 1] + share * (self.heights[k] - self.heights[k - 1])
        return found

    def downtime(self, scatter: Scatter | str | Path) -> Downtime:
        """The share of the sea states of a scatter diagram that are not operable.

        A sea state is operable up to the limiting height, linear between the periods.
        """
        given = scatter if isinstance(scatter, Scatter) else read_scatter(scatter)
        limits = self.limiting_heights()
        shares = []
        for row in limits:
            limit = np.interp(given.periods, self.periods, row)
            shares.append(float(given.shares[given.heights[:, None] > limit[None, :]].sum()))
        beside = (given.periods < self.periods[0]) | (given.periods > self.periods[-1])
        outside = beside[None, :] | (given.heights > self.heights[-1])[:, None]
        return Downtime(
            self.headings,
            np.array(shares),
            float(np.mean(shares)),
            float(given.shares[outside].sum()),
        )

    def tables(self) -> list[Table]:
        """A table of cells for each heading, and the letters of the criteria."""
        limits = self.limiting_heights()
        period, height = self.shown["period"], self.shown["height"]
        found = []
        for h in range(len(self.headings)):
            rows = []
            for k in reversed(range(len(self.heights))):
                cells = (self._cell(h, p, k) for p in range(len(self.periods)))
                rows.append((f"{height.number(self.heights[k]):.4g} {height.label}", *cells))
            ends = (f"{height.number(limit):.3g}" for limit in limits[h])
            rows.append(("limit", *ends))
            header = ("", *(f"{period.number(t):.4g} {period.label}" for t in self.periods))
            found.append(Table(self._title(h), header, tuple(rows)))
        letters = [(_LETTERS[k], c.name) for k, c in enumerate(self.criteria)]
        if self.failed.any():
            letters.append(("x", f"a run failed ({self.study.status.count('failed')} runs)"))
        note = "* above its limit; numbers are shares of the limit of the governing criterion"
        found.append(Table("criteria", (), tuple(letters), note))
        return found

    def downtime_table(self, found: Downtime) -> Table:
        """The downtime of each heading, and of all."""
        shown = self.shown.get("heading")
        rows = [
            (shown.text(angle) if shown else "all", f"{100 * share:.2f} %")
            for angle, share in zip(found.headings, found.shares, strict=True)
        ]
        rows.append(("mean", f"{100 * found.total:.2f} %"))
        note = f"{100 * found.outside:.2f} % of the sea states lie outside those that were run"
        return Table("downtime", ("heading", "downtime"), tuple(rows), note)

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each cell and criterion, SI."""
        header = ("heading", "period", "height", "criterion", "value", "utilisation", "governing")
        write_rows(path, header, self._lines())

    def _lines(self) -> Iterator[tuple[object, ...]]:
        for h, p, k in np.ndindex(self.failed.shape):
            governing = self.governing(h, p, k)
            for c, criterion in enumerate(self.criteria):
                marked = governing if governing in (criterion.name, _FAILED) else ""
                numbers = self.values[h, p, k, c], self.utilisation[h, p, k, c]
                sea = self.headings[h], self.periods[p], self.heights[k]
                yield *sea, criterion.name, *numbers, marked

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw a map of utilisation with its limit for each heading; return the figure."""
        # Loads matplotlib.
        from bgc.runtime.studies.plots import plot_operability

        worst = self.worst
        cells = [
            [
                [self._cell(h, p, k) for p in range(len(self.periods))]
                for k in range(len(self.heights))
            ]
            for h in range(len(self.headings))
        ]
        period, height = self.shown["period"], self.shown["height"]
        legend = [f"{_LETTERS[k]}: {c.name}" for k, c in enumerate(self.criteria)]
        return plot_operability(
            [self._title(h) for h in range(len(self.headings))],
            (self.periods / period.factor, f"peak period [{period.label}]"),
            (self.heights / height.factor, f"significant height [{height.label}]"),
            worst,
            self.limiting_heights() / height.factor,
            cells,
            legend,
            path,
        )

    def _title(self, heading: int) -> str:
        shown = self.shown.get("heading")
        return f"heading {shown.text(self.headings[heading])}" if shown else self.scene

    def _cell(self, heading: int, period: int, height: int) -> str:
        """Utilisation and letter of a cell: `0.83 a`, `*1.20 b`, `*x` after a failed run."""
        if self.failed[heading, period, height]:
            return "*x"
        known: Sequence[float] = self.utilisation[heading, period, height].tolist()
        values = [float("inf") if u != u else u for u in known]
        largest = max(values)
        mark = "" if largest <= 1 else "*"
        return f"{mark}{largest:.2f} {_LETTERS[values.index(largest) % len(_LETTERS)]}"
