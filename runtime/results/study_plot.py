"""Plots of observables over parameters: curves, maps, contours, scatters, histograms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import unknown_column
from bgc.diagnostics.catalogue.machine import nothing_to_draw
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import UnknownColumn
from bgc.runtime.results.plot import COLOURS, Target, picture
from bgc.runtime.results.runs import ObservedRuns
from bgc.runtime.results.study_kinds import check_kind

_PANELS = 6
_CURVES = 10  # values of the other parameters that get a curve of their own
_WIDTH, _HEIGHT, _SQUARE = 8.0, 2.8, 3.6  # inches


def plot_study(
    study: ObservedRuns, path: Target, observables: Sequence[str] | None, kind: str | None
) -> Figure:
    """Draw a study; see `Study.plot`.

    Raises BgError: BG065 for an unknown observable, BG066 for a kind that does not fit the study,
    BG075 where there is nothing to draw.
    """
    names = list(study.names if observables is None else observables)[:_PANELS]
    for name in names:
        if name not in study.names:
            raise UnknownColumn([unknown_column(name, study.names)])
    if not names or not np.isfinite(study.values).any():
        raise BgError([nothing_to_draw("no run has a finite observable")])
    chosen = kind or _usual(study)
    check_kind(chosen, len(study.parameters))
    rows, columns, height = _layout(chosen, study, len(names))
    with picture(path, _WIDTH, height * rows + 0.6) as figure:
        _DRAWN[chosen](figure.subplots(rows, columns, squeeze=False), study, names)
        figure.suptitle(f"{study.scene}: {counted(study.count, study.noun)}")
    return figure


def _usual(study: ObservedRuns) -> str:
    count = len(study.parameters)
    if count == 0:
        return "histogram"
    if count == 1:
        return "curves"
    return "map" if count == 2 and _is_grid(study) else "scatter"


def _is_grid(study: ObservedRuns) -> bool:
    axes = [np.unique(values) for values in study.parameters.values()]
    return int(np.prod([len(each) for each in axes])) == len(study)


def _layout(kind: str, study: ObservedRuns, count: int) -> tuple[int, int, float]:
    """Rows and columns of the panels of so many observables, and the height of one in inches."""
    if kind in ("map", "contour"):
        columns = min(2, count)
        return -(-count // columns), columns, _SQUARE
    return count, min(len(study.parameters), _PANELS) if kind == "scatter" else 1, _HEIGHT


def _curves(axes: Any, study: ObservedRuns, names: Sequence[str]) -> None:
    """Observables over the first parameter, a curve for each combination of the others."""
    across, *others = study.parameters
    x = study.in_words(across)
    keys = np.column_stack([np.zeros(len(study)), *(study[name] for name in others)])
    groups, group = np.unique(keys, axis=0, return_inverse=True)
    for k, name in enumerate(names):
        y = study.in_words(name)
        for g in range(len(groups)):
            some = np.flatnonzero(group.ravel() == g)
            some = some[np.argsort(x[some], kind="stable")]
            few = len(groups) <= _CURVES
            pairs = zip(others, groups[g, 1:], strict=True)
            label = ", ".join(
                f"{other} = {study.shown_in(other).text(value, 4)}" for other, value in pairs
            )
            axes[k, 0].plot(
                x[some],
                y[some],
                marker="." if len(some) <= 50 else None,
                color=COLOURS[g % len(COLOURS)] if few else COLOURS[0],
                alpha=1.0 if few else max(0.1, 10 / len(groups)),
                label=label if few and others and k == 0 else None,
            )
        axes[k, 0].set_ylabel(study.label(name))
        axes[k, 0].margins(x=0.02)
    if others and len(groups) <= _CURVES:
        axes[0, 0].legend(fontsize="small")
    axes[-1, 0].set_xlabel(study.label(across))


def _over_two(axes: Any, study: ObservedRuns, names: Sequence[str], filled: bool) -> None:
    """Observables over two parameters: cells of a grid, or contours, also of a sample."""
    first, second = study.parameters
    x, y = study.in_words(first), study.in_words(second)
    for k, place in enumerate(axes.flat):
        if k >= len(names):
            place.set_visible(False)
            continue
        z = study.in_words(names[k])
        place.grid(False)
        if filled and _is_grid(study):
            drawn = _cells(place, x, y, z)
        else:
            some = np.isfinite(z)
            if some.sum() < 3:
                raise BgError([nothing_to_draw("fewer than three runs have finite values")])
            triangles = Triangulation(_scaled(x[some]), _scaled(y[some])).triangles
            mesh = Triangulation(x[some], y[some], triangles)
            drawn = place.tricontourf(mesh, z[some], levels=12, cmap="viridis")
            place.plot(x, y, ".", color="k", markersize=2, alpha=0.5)
        place.figure.colorbar(drawn, ax=place, label=study.label(names[k]))
        place.set_xlabel(study.label(first))
        place.set_ylabel(study.label(second))


def _scaled(x: Array) -> Array:
    """Values from 0 to 1: triangles between points of two units are then not thin."""
    return np.asarray((x - x.min()) / (float(np.ptp(x)) or 1.0))


def _cells(place: Any, x: Array, y: Array, z: Array) -> Any:
    """A coloured cell for each run, with contour lines where the grid is wide enough."""
    xs, ys = np.unique(x), np.unique(y)
    table = np.full((len(ys), len(xs)), np.nan)
    table[np.searchsorted(ys, y), np.searchsorted(xs, x)] = z
    drawn = place.pcolormesh(xs, ys, table, shading="nearest", cmap="viridis")
    if min(table.shape) > 2 and np.isfinite(table).sum() > 4 and np.nanmax(z) > np.nanmin(z):
        lines = place.contour(xs, ys, table, colors="white", linewidths=0.8)
        place.clabel(lines, fontsize="x-small")
    return drawn


def _scatter(axes: Any, study: ObservedRuns, names: Sequence[str]) -> None:
    """Each observable over each parameter."""
    given = list(study.parameters)[:_PANELS]
    alpha = max(0.1, min(1.0, 100 / len(study)))
    for k, name in enumerate(names):
        for i, parameter in enumerate(given):
            x, y = study.in_words(parameter), study.in_words(name)
            axes[k, i].plot(x, y, ".", color=COLOURS[0], markersize=4, alpha=alpha)
            axes[k, i].tick_params(labelleft=i == 0, labelbottom=k == len(names) - 1)
            if k == len(names) - 1:
                axes[k, i].set_xlabel(study.label(parameter))
        axes[k, 0].set_ylabel(study.label(name))


def _histograms(axes: Any, study: ObservedRuns, names: Sequence[str]) -> None:
    for k, name in enumerate(names):
        values = study.in_words(name)
        axes[k, 0].hist(values[np.isfinite(values)], bins="auto", color=COLOURS[0])
        axes[k, 0].set_xlabel(study.label(name))
        axes[k, 0].set_ylabel("runs")


_Draw: TypeAlias = Callable[[Any, ObservedRuns, Sequence[str]], None]

_DRAWN: MappingProxyType[str, _Draw] = MappingProxyType(
    {
        "curves": _curves,
        "map": partial(_over_two, filled=True),
        "contour": partial(_over_two, filled=False),
        "scatter": _scatter,
        "histogram": _histograms,
    }
)
