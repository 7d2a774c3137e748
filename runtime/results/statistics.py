"""Statistics of observables over many runs, and the influence of the parameters on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.diagnostic import BgError
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.html import Tabled
from bgc.runtime.results.runs import ObservedRuns
from bgc.values.shown_units import Shown

_RESAMPLES = 1000
_FEWEST_RANKED_RUNS = 8  # runs of a ranking


@dataclass(frozen=True, slots=True, repr=False)
class Statistics(Tabled):
    """Statistics of each observable over the runs with a finite value, SI.

    `values` is (observables, 4 + quantiles): mean, standard deviation (with n - 1), least, largest,
    then the quantiles by linear interpolation. `counts` are the numbers of runs.
    """

    names: tuple[str, ...]
    quantiles: tuple[float, ...]
    counts: tuple[int, ...]
    values: Array
    shown: tuple[Shown, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the statistics."""
        return ("mean", "sd", "least", "largest", *(f"{100 * q:g} %" for q in self.quantiles))

    def __getitem__(self, name: str) -> dict[str, float]:
        row = self.values[self.names.index(name)].tolist()
        return dict(zip(self.columns, row, strict=True))

    def tables(self) -> list[Table]:
        """The one of `table`."""
        return [self.table()]

    def table(self) -> Table:
        """The statistics in the units in which the observables are shown.

        The observables are columns where that makes the narrower table, else rows.
        """
        rows = []
        for name, count, row, shown in zip(
            self.names, self.counts, self.values, self.shown, strict=True
        ):
            cells = (f"{x / shown.factor + 0.0:.6g}" for x in row)
            rows.append((shown.heading(name), str(count), *cells))
        header: tuple[str, ...] = ("", "runs", *self.columns)
        title = "statistics over the runs"
        if len(set(self.counts)) == 1:
            title = f"statistics over {counted(self.counts[0], 'run')}"
            header, *rows = (row[:1] + row[2:] for row in (header, *rows))
        turned = list(zip(header, *rows, strict=True))
        if _width(turned) < _width([header, *rows]):
            header, *rows = turned
        spare = tuple(name for name in ("5 %", "95 %", "50 %") if name in header)
        return Table(title, header, tuple(rows), spare=spare)


def _width(rows: Sequence[Sequence[str]]) -> int:
    """Characters of a line of a table, two between its columns."""
    return sum(max(map(len, column)) + 2 for column in zip(*rows, strict=True))


def statistics(study: ObservedRuns, quantiles: Sequence[float]) -> Statistics:
    """Compute the statistics of all observables; see `Statistics`."""
    if not all(0 <= q <= 1 for q in quantiles):
        raise BgError([bad_option("quantiles", tuple(quantiles), "numbers from 0 to 1", "0.95")])
    rows, counts = [], []
    for column in study.values.T:
        some = column[np.isfinite(column)]
        counts.append(len(some))
        if not len(some):
            rows.append(np.full(4 + len(quantiles), np.nan))
            continue
        spread = float(some.std(ddof=1)) if len(some) > 1 else float("nan")
        ends = (some.mean(), spread, some.min(), some.max())
        rows.append(np.array((*ends, *np.quantile(some, quantiles))))
    shown = tuple(study.shown_in(name) for name in study.names)
    table = np.array(rows).reshape(len(study.names), 4 + len(quantiles))
    return Statistics(tuple(study.names), tuple(quantiles), tuple(counts), table, shown)


@dataclass(frozen=True, slots=True, repr=False)
class Sensitivity(Tabled):
    """The influence of each parameter on each observable, with confidence intervals.

    Of a `saltelli` sample, `measure` is "Sobol index": `first` is the share of the variance that
    the parameter explains alone, `total` the share that vanishes if it is fixed, with its
    interactions. The estimators are those of A. Saltelli et al., Computer Physics Communications
    181 (2010) 259-270, table 2 (b) and (f, after Jansen); the intervals are percentiles of 1,000
    bootstrap resamples. Of any other sample, `measure` is "rank correlation": `first` is Spearman's
    coefficient, which measures a monotone influence, and `total` is empty; the interval is that of
    D. G. Bonett and T. A. Wright, Psychometrika 65 (2000) 23-28.

    Arrays are (observables, parameters), intervals (observables, parameters, 2).
    """

    measure: str
    names: tuple[str, ...]
    parameters: tuple[str, ...]
    runs: tuple[int, ...]
    confidence: float
    first: Array
    first_interval: Array
    total: Array
    total_interval: Array

    def ranking(self, name: str) -> list[str]:
        """The parameters of an observable, the most influential first."""
        k = self.names.index(name)
        by = self.total[k] if self.total.size else np.abs(self.first[k])
        return [self.parameters[i] for i in np.argsort(-np.nan_to_num(by), kind="stable")]

    def tables(self, local: Mapping[str, Mapping[str, str]] | None = None) -> list[Table]:
        """A table for each observable, the most influential parameter first.

        `local` are effects of 1 % of the parameters about one point, texts by observable and
        parameter, for a last column.
        """
        share = f"{100 * self.confidence:g} % interval"
        header: tuple[str, ...] = ("", self.measure, share)
        if self.total.size:
            header = ("", "first order", share, "total", share)
        if local:
            header = (*header, "by 1 % more")
        found = []
        for k, name in enumerate(self.names):
            rows = []
            for parameter in self.ranking(name):
                i = self.parameters.index(parameter)
                cells = [f"{self.first[k, i]:.3f}", _interval(self.first_interval[k, i])]
                if self.total.size:
                    cells += [f"{self.total[k, i]:.3f}", _interval(self.total_interval[k, i])]
                if local:
                    cells.append(local.get(name, {}).get(parameter, "-"))
                rows.append((parameter, *cells))
            title = f"{name}: influence of the parameters, from {counted(self.runs[k], 'run')}"
            found.append(Table(title, header, tuple(rows)))
        return found


def _interval(ends: Array) -> str:
    return f"{ends[0]:.3f} .. {ends[1]:.3f}"


def sensitivity(study: ObservedRuns, confidence: float) -> Sensitivity:
    """Compute Sobol indices of a `saltelli` sample, else rank correlations; see `Sensitivity`.

    Raises BgError: BG066 for a confidence outside 0 to 1, and for fewer than 8 finite runs.
    """
    if not 0 < confidence < 1:
        raise BgError([bad_option("confidence", confidence, "a number between 0 and 1", "0.95")])
    pairs = [
        _sobol(study, values, confidence)
        if study.design == "saltelli"
        else _ranks(study, values, confidence)
        for values in study.values.T
    ]
    is_sobol = study.design == "saltelli"
    first, total = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    empty = np.empty(0)
    return Sensitivity(
        "Sobol index" if is_sobol else "rank correlation",
        tuple(study.names),
        tuple(study.parameters),
        tuple(pair[2] for pair in pairs),
        confidence,
        np.array([each[0] for each in first]),
        np.array([each[1] for each in first]),
        np.array([each[0] for each in total]) if is_sobol else empty,
        np.array([each[1] for each in total]) if is_sobol else empty,
    )


_Part = tuple[Array, Array]


def check_enough(count: int) -> None:
    """Raise BG066 for too few runs (base points of a `saltelli` sample) to rank parameters."""
    if count < _FEWEST_RANKED_RUNS:
        wanted = f"a sample of {_FEWEST_RANKED_RUNS} runs or more, as a ranking needs"
        raise BgError([bad_option("sample", count, wanted, "64")])


def _sobol(study: ObservedRuns, values: Array, confidence: float) -> tuple[_Part, _Part, int]:
    """Indices and intervals of first and total order; a point with a failed run is dropped."""
    count = len(study.parameters)
    blocks = values.reshape(count + 2, -1)  # A, B, then A with one column of B each
    blocks = blocks[:, np.isfinite(blocks).all(axis=0)]
    check_enough(blocks.shape[1])
    base = blocks[:2].mean()
    a, b, mixed = blocks[0] - base, blocks[1] - base, blocks[2:] - base

    def indices(at: Array) -> Array:
        """(2, parameters) of points with the weights `at`, their counts in a resample."""
        n = at.sum()
        mean = ((a + b) @ at) / (2 * n)
        variance = ((a * a + b * b) @ at) / (2 * n) - mean**2
        if not variance > 0:
            return np.full((2, count), np.nan)
        return np.array(
            ((b * (mixed - a)) @ at / n / variance, ((a - mixed) ** 2) @ at / (2 * n) / variance)
        )

    points = blocks.shape[1]
    found = indices(np.ones(points))
    rng = np.random.default_rng(0)
    draws = (rng.multinomial(points, np.full(points, 1 / points)) for _ in range(_RESAMPLES))
    again = np.array([indices(draw.astype(float)) for draw in draws])
    tail = (1 - confidence) / 2
    ends = np.nanquantile(again, (tail, 1 - tail), axis=0) if np.isfinite(again).any() else None
    intervals = np.full((2, count, 2), np.nan) if ends is None else np.moveaxis(ends, 0, 2)
    return (found[0], intervals[0]), (found[1], intervals[1]), blocks.size


def _ranks(study: ObservedRuns, values: Array, confidence: float) -> tuple[_Part, _Part, int]:
    """Spearman's rank correlation with each parameter; NaN for one that does not vary."""
    # Slow to load, and only this needs it.
    from scipy.stats import norm, rankdata

    some = np.isfinite(values)
    count = int(some.sum())
    check_enough(count)
    result = _centred(rankdata(values[some]))
    found, intervals = [], []
    for column in study.parameters.values():
        ranks = _centred(rankdata(column[some]))
        length = float(np.linalg.norm(ranks) * np.linalg.norm(result))
        rho = float(ranks @ result) / length if length > 0 else float("nan")
        rho = min(max(rho, -1.0), 1.0) if rho == rho else rho
        width = norm.ppf((1 + confidence) / 2) * np.sqrt((1 + rho**2 / 2) / (count - 3))
        inside = min(max(rho, -1 + 1e-15), 1 - 1e-15) if rho == rho else rho
        found.append(rho)
        intervals.append(np.tanh(np.arctanh(inside) + np.array((-width, width))))
    return (np.array(found), np.array(intervals)), (np.empty(0), np.empty(0)), count


def _centred(ranks: Array) -> Array:
    return np.asarray(ranks - ranks.mean(), dtype=float)
