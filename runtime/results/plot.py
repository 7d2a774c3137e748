"""Plots of a result: time plots stacked by unit, or the user's own panels."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from itertools import cycle
from pathlib import Path
from typing import Any, TypeAlias

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, ScalarFormatter

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import bad_panel
from bgc.diagnostics.catalogue.machine import nothing_to_draw, unknown_file_kind
from bgc.diagnostics.diagnostic import BgError
from bgc.language.column_names import name_in_si
from bgc.language.scene import Plot
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import RunColumns
from bgc.runtime.results.files import written_whole
from bgc.runtime.results.runs import Runs

KINDS = (".png", ".svg", ".pdf")

_WIDTH, _PANEL_HEIGHT, _SQUARE_HEIGHT, _MARGIN = 8.0, 2.4, 4.2, 0.7  # inches
_MOST_IN_LEGEND = 10
_MOST_NAMED = 4  # columns of unknown error in a note
_PANEL_POINTS = 130.0  # height of the axis of a panel, about
_BAND, _BAND_POINTS = 0.25, 4000  # opacity; points along a band, at most
_NONE = np.empty(0)
_UNLIKE_RANGES = 10.0
_SMALL, _LARGE = 1e-3, 1e5  # numbers of an axis that are written in full
# Okabe and Ito's colours, which colour-blind readers can tell apart.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
GUIDE = "#999999"  # of lines that are no data
NOTE = "#666666"
STYLE: dict[Any, Any] = {
    "text.usetex": False,  # a `matplotlibrc` beside a stranger's model could start LaTeX
    "agg.path.chunksize": 20_000,  # long runs overflow the renderer otherwise
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9.5,
    "grid.alpha": 0.35,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "svg.hashsalt": "bgc",  # the same bytes for the same result
}


Target: TypeAlias = str | Path | None
"""A file to draw to, or None for the figure alone."""


class Picture(Figure):
    """A figure that a notebook shows, whether or not it has loaded `pyplot`."""

    def _repr_png_(self) -> bytes:
        out = BytesIO()
        self.savefig(out, format="png", dpi=100)
        return out.getvalue()


@contextmanager
def picture(path: Target, width: float, height: float) -> Iterator[Picture]:
    """Give a figure in the style of all plots, to be drawn; then write it where a path is given.

    Width and height are in inches. The ending of the name is the kind of file; the same figure
    gives the same bytes. Raises BgError: BG070 for another ending, BG055 where writing fails.
    """
    kind = Path(path).suffix.lower() if path is not None else KINDS[0]
    if kind not in KINDS:
        raise BgError([unknown_file_kind(str(path), KINDS)])
    with matplotlib.rc_context(STYLE):
        figure = Picture(figsize=(width, height), layout="constrained")
        yield figure
        if path is not None:
            undated = {"Date": None} if kind == ".svg" else None
            with written_whole(path) as aside:
                figure.savefig(aside, format=kind[1:], dpi=150, metadata=undated)


def read_panel(text: str) -> Plot:
    """Read `tip.z, handle.z` or `force against elevation`; BG069 for other texts."""
    first, against, second = text.partition(" against ")
    columns = tuple(name.strip() for name in re.split(r",(?![^\[]*\])", first))
    across = second.strip() if against else "time"
    if not all(columns) or not across or any(name.endswith(" against") for name in columns):
        raise BgError([bad_panel(text)])
    return Plot(columns, across)


def plot_result(
    result: RunColumns,
    path: Target,
    columns: Sequence[str] | None,
    panels: Sequence[str] | None,
) -> Figure:
    """Draw a result, and write the figure where a path is given; see `Result.plot`."""
    if len(result.time) < 2:
        raise BgError([nothing_to_draw("the run ended at its start")])
    if panels:
        chosen = [read_panel(text) for text in panels]
    elif columns is None and result.panels:
        chosen = list(result.panels)
    else:
        chosen = _panels_by_unit(result, result.expand(list(columns or result)))
    if not chosen:
        raise BgError([nothing_to_draw("the scene observes nothing")])
    chosen = [Plot(tuple(result.expand(p.columns)), _across(result, p)) for p in chosen]
    heights = [_PANEL_HEIGHT if p.across == "time" else _SQUARE_HEIGHT for p in chosen]
    with picture(path, _WIDTH, sum(heights) + _MARGIN) as figure:
        _draw(figure, result, chosen, heights)
    return figure


def plot_ensemble(runs: Runs, time: Array, columns: Sequence[str], path: Target) -> Figure:
    """Draw columns of all instances, whose rows are at `time`, s; see `Ensemble.plot`."""
    if not runs.count or len(time) < 2:
        raise BgError([nothing_to_draw("the runs ended at their start")])
    if not columns:
        raise BgError([nothing_to_draw("the scene observes nothing")])
    few = runs.count <= _MOST_IN_LEGEND
    with picture(path, _WIDTH, _PANEL_HEIGHT * len(columns) + _MARGIN) as figure:
        every = figure.subplots(len(columns), 1, squeeze=False, sharex=True)[:, 0]
        for k, (name, axes) in enumerate(zip(columns, every, strict=True)):
            values = runs.values[:, :, runs.names.index(name)] / runs.shown_in(name).factor
            for number, colour in zip(range(runs.count), cycle(COLOURS), strict=False):
                axes.plot(
                    time,
                    values[number],
                    color=colour if few else COLOURS[0],
                    alpha=1.0 if few else max(0.05, 10 / runs.count),
                    label=_instance(runs, number) if few and k == 0 else None,
                )
            axes.set_ylabel(runs.label(name))
        if few:
            every[0].legend()
        every[-1].set_xlabel("time [s]")
        figure.suptitle(f"{runs.scene}: {counted(runs.count, runs.noun)}")
    return figure


def _instance(runs: Runs, number: int) -> str:
    """The values of an instance, for the legend."""
    given = (f"{name} = {values[number]:.4g}" for name, values in runs.parameters.items())
    return ", ".join(given) or str(number)


def _across(result: RunColumns, panel: Plot) -> str:
    """The column of the horizontal axis; BG069 for a vector of several columns."""
    columns = result.expand([panel.across])
    if len(columns) != 1:
        raise BgError([bad_panel(f"{', '.join(panel.columns)} against {panel.across}")])
    return columns[0]


def _panels_by_unit(result: RunColumns, columns: Sequence[str]) -> list[Plot]:
    by_unit: dict[str, list[str]] = {}
    for column in columns:
        by_unit.setdefault(result.shown_in(column).unit, []).append(column)
    return [Plot(tuple(names)) for names in by_unit.values()]


def _draw(
    figure: Figure, result: RunColumns, panels: Sequence[Plot], heights: Sequence[float]
) -> None:
    grid = figure.add_gridspec(len(panels), 1, height_ratios=heights)
    timed: Any = None
    is_banded = False
    for k, panel in enumerate(panels):
        axes = figure.add_subplot(grid[k], sharex=timed if panel.across == "time" else None)
        if panel.across == "time":
            timed = axes
        is_banded |= _draw_panel(result, panel, axes)
        last = all(p.across != "time" for p in panels[k + 1 :])
        if panel.across != "time" or last:
            factor = "" if panel.across == "time" else _shorten_numbers(axes.xaxis)
            axes.set_xlabel(_label(panel.across, result, factor))
        else:
            axes.tick_params(labelbottom=False)
    if note := _note(result, panels, is_banded):
        figure.supxlabel(note, x=0.995, ha="right", fontsize="small", color=NOTE)
    figure.align_ylabels()
    figure.suptitle(
        result.scene if result.status == "done" else f"{result.scene} ({result.status})"
    )


def _note(result: RunColumns, panels: Sequence[Plot], is_banded: bool) -> str:
    """Explain the bands of a plot, and name the columns whose errors are not known."""
    drawn = dict.fromkeys(column for panel in panels for column in panel.columns)
    lost = [name for name in drawn if np.isnan(result.errors.get(name, 0.0)).any()]
    more = f" and {len(lost) - _MOST_NAMED} more" if len(lost) > _MOST_NAMED else ""
    lines = ["band: estimated error"] if is_banded else []
    lines += [f"error unknown: {', '.join(lost[:_MOST_NAMED])}{more}"] if lost else []
    return "; ".join(lines)


def _draw_band(result: RunColumns, column: str, line: Any) -> bool:
    """Draw the error of a column as a band along its curve, where it is wider; return whether."""
    error = result.errors.get(column, _NONE) / result.shown_in(column).factor
    low, high = line.axes.get_ylim()
    visible = (high - low) * STYLE["lines.linewidth"] / _PANEL_POINTS
    if not (error > visible).any():
        return False
    value = line.get_ydata()
    starts = np.arange(0, len(error), -(-len(error) // _BAND_POINTS))
    below, above = np.fmin.reduceat(value - error, starts), np.fmax.reduceat(value + error, starts)
    line.axes.fill_between(
        line.get_xdata()[starts], below, above, color=line.get_color(), alpha=_BAND, linewidth=0
    )
    return True


def _draw_panel(result: RunColumns, panel: Plot, axes: Any) -> bool:
    """Draw one panel, with a right-hand scale for columns that do not fit the left one.

    Over the time, curves have a band of their estimated errors where it would be seen; return
    whether one does.
    """
    across = result.in_words(panel.across)
    left, right = _sides(result, panel)
    other: Any = axes.twinx() if right else None
    lines = []
    for column, colour in zip(panel.columns, cycle(COLOURS), strict=False):
        side = other if column in right else axes
        lines += side.plot(across, result.in_words(column), label=column, color=colour)
    timed = panel.across == "time"
    bands = [
        timed and _draw_band(result, *drawn) for drawn in zip(panel.columns, lines, strict=False)
    ]
    axes.set_ylabel(_axis_label(left, result, _shorten_numbers(axes.yaxis)))
    if other is not None:
        other.grid(False)
        other.spines["right"].set_visible(True)
        other.set_ylabel(_axis_label(right, result, _shorten_numbers(other.yaxis)))
        for side, columns in ((axes, left), (other, right)):
            if len(columns) == 1:  # the scale has the colour of its curve
                colour = next(line.get_color() for line in lines if line.get_label() in columns)
                side.yaxis.label.set_color(colour)
                side.tick_params(axis="y", labelcolor=colour)
    if timed:
        axes.margins(x=0)
    if len(panel.columns) > 1:
        axes.legend(
            handles=lines[:_MOST_IN_LEGEND],
            loc="lower left",
            bbox_to_anchor=(0, 1),
            borderaxespad=0.1,
            ncols=5,
            fontsize="small",
        )
    return any(bands)


def _sides(result: RunColumns, panel: Plot) -> tuple[list[str], list[str]]:
    """Divide a panel's columns between its left and its right scale.

    RunColumns of a second unit go to the right. Of two columns in one unit, the second goes to the
    right if its range is far smaller or larger than that of the first.
    """
    units = list(dict.fromkeys(result.shown_in(column).unit for column in panel.columns))
    if len(units) == 2:
        left = [c for c in panel.columns if result.shown_in(c).unit == units[0]]
        return left, [column for column in panel.columns if column not in left]
    if len(panel.columns) == 2:
        first, second = (float(np.ptp(result.in_words(c))) for c in panel.columns)
        if min(first, second) * _UNLIKE_RANGES < max(first, second) and min(first, second) > 0:
            return [panel.columns[0]], [panel.columns[1]]
    return list(panel.columns), []


def _shorten_numbers(axis: Any) -> str:
    """Divide the numbers of an axis by a power of 1000 where they are long; return that factor.

    The factor stands in the label. Matplotlib's own place for it, the upper end of the axis, is
    that of the legend.
    """
    largest = max(map(abs, axis.get_view_interval()))
    power = 3 * math.floor(math.log10(largest) / 3) if largest > 0 else 0
    if _SMALL <= largest < _LARGE:
        axis.set_major_formatter(ScalarFormatter(useOffset=False))
        return ""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 10.0**power:.12g}"))
    return f"$10^{{{power}}}$ "


def _axis_label(columns: Sequence[str], result: RunColumns, factor: str) -> str:
    if len(columns) == 1:
        return _label(columns[0], result, factor)
    return _bracketed(factor + result.shown_in(columns[0]).unit)


def _label(name: str, result: RunColumns, factor: str) -> str:
    unit = result.shown_in(name).unit
    return f"{name_in_si(name)} {_bracketed(factor + unit)}".strip()


def _bracketed(unit: str) -> str:
    return f"[{unit.strip()}]" if unit else ""
