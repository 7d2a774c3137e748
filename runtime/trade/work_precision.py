"""The work-precision plot: error against processor time, a line for each method."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

from matplotlib.figure import Figure

from bgc.diagnostics.catalogue.machine import nothing_to_draw
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.measuring.agreement import AT_THE_REFERENCE
from bgc.runtime.results.plot import COLOURS, Target, picture
from bgc.runtime.trade.configurations import Variant
from bgc.runtime.trade.judge import spelled
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.trade_result import TradeResult
from bgc.runtime.trade.trade_tables import letter

_MARKERS = "osD^vPX<>ph8"
# Those of other plots, and five of Tol's, so that no two methods share one.
_LINE_COLOURS = (*COLOURS, "#882255", "#999933", "#332288", "#44AA99", "#661100", "#888888")
_FIGURE_INCHES = (9.0, 6.0)  # inches
_BEYOND = 1e4  # times the limit: larger errors are not drawn
_LEAST_DRAWN_ERROR = 1e-17


def plot_trade(trade: TradeResult, path: Target = None) -> Figure:
    """Draw a trade; write the figure if a path is given."""
    if not any(row.done for row in trade.measurements):
        raise BgError([nothing_to_draw("no configuration completed the run")])
    with picture(path, *_FIGURE_INCHES) as figure:
        _draw(figure.add_subplot(), trade)
    return figure


def _draw(axes: Any, trade: TradeResult) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    styles: dict[str, tuple[str, str]] = {}
    unused = zip(cycle(_LINE_COLOURS), cycle(_MARKERS), strict=False)
    for (solver, keep, changes), rows in _lines(trade).items():
        if solver not in styles:
            styles[solver] = next(unused)
        colour, marker = styles[solver]
        first = solver not in axes.get_legend_handles_labels()[1]
        axes.plot(
            [row.cpu for row in rows],
            [_height(trade, row) for row in rows],
            color=colour,
            marker=marker,
            markersize=4.5,
            markerfacecolor="white" if keep > 1 or changes else colour,
            linestyle=":" if changes else "-" if keep == 1 else "--",
            linewidth=1.0,
            alpha=0.9 if keep == 1 else 0.65,
            label=solver if first else None,
        )
        _name_variant(trade, axes, rows, colour)
    _explain_lines(axes, list(_lines(trade)))
    _draw_front(trade, axes)
    _draw_limits(trade, axes)
    axes.grid(True, which="minor", alpha=0.12)
    axes.set_xlabel("processor time for a second of the scene [s]")
    worst = [q.name for q in trade.quantities if q.decides]
    about = worst[0] if len(worst) == 1 else "the worst quantity"
    axes.set_ylabel(f"error of {about}, as a part of {trade.target.scale}")
    axes.set_title(f"{trade.scene}: {spelled(trade.duration)} on {trade.machine}", fontsize=9)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small")


def _explain_lines(axes: Any, ladders: Sequence[tuple[str, int, Variant]]) -> None:
    """Add the meaning of open markers, dashes and dots to the legend, where they occur."""
    open_grey: Any = {"color": "0.4", "marker": "o", "markerfacecolor": "white", "markersize": 4.5}
    if any(keep > 1 and not changes for _, keep, changes in ladders):
        axes.plot([], [], linestyle="--", label="Jacobian kept for steps", **open_grey)
    if any(changes for _, _, changes in ladders):
        axes.plot([], [], linestyle=":", label="a variant of the model", **open_grey)


def _name_variant(trade: TradeResult, axes: Any, rows: Sequence[Measurement], colour: str) -> None:
    """Write the letter of a variant at the coarse end of its line."""
    if changes := rows[0].configuration.changes:
        axes.annotate(
            letter(trade, changes),
            (rows[0].cpu, _height(trade, rows[0])),
            xytext=(-4, 0),
            textcoords="offset points",
            ha="right",
            va="center",
            fontsize="x-small",
            color=colour,
        )


def _lines(trade: TradeResult) -> dict[tuple[str, int, Variant], list[Measurement]]:
    """Group the completed measurements into lines, each from coarse to fine."""
    found: dict[tuple[str, int, Variant], list[Measurement]] = {}
    for row in trade.measurements:
        if row.done and trade.target.error(row) <= _BEYOND * max(trade.target.limit, 1.0):
            found.setdefault(row.configuration.ladder, []).append(row)
    for rows in found.values():
        rows.sort(key=lambda row: (-row.configuration.step, -row.configuration.rtol))
    return found


def _height(trade: TradeResult, row: Measurement) -> float:
    return max(trade.target.error(row), _LEAST_DRAWN_ERROR)


def _draw_front(trade: TradeResult, axes: Any) -> None:
    front: Sequence[Measurement] = sorted(
        (row for row in trade.measurements if row.configuration in trade.verdict.front),
        key=lambda row: row.cpu,
    )
    axes.plot(
        [row.cpu for row in front],
        [_height(trade, row) for row in front],
        color="0.55",
        linewidth=5,
        alpha=0.35,
        solid_capstyle="round",
        zorder=0,
        label="Pareto front",
    )
    best = trade.verdict.recommended
    if best is not None:
        axes.plot(
            [best.cpu],
            [_height(trade, best)],
            "o",
            markersize=15,
            markerfacecolor="none",
            markeredgecolor="black",
            label=f"recommended:\n{best.configuration.solver} {best.configuration.setting}",
        )


def _draw_limits(trade: TradeResult, axes: Any) -> None:
    """Draw the limit of errors, real time, missed deadlines, and the accuracy of the reference."""
    target = trade.target
    what = " and ".join(target.required_by) if target.required else f"{target.limit:g} of the range"
    axes.axhline(target.limit, color="#D55E00", linewidth=0.9, linestyle="-.", label=what)
    floor, bottom = max(AT_THE_REFERENCE * target.floor, _LEAST_DRAWN_ERROR), axes.get_ylim()[0]
    if floor > bottom:
        label = "accuracy of the reference"
        axes.axhspan(_LEAST_DRAWN_ERROR * 1e-3, floor, color="0.5", alpha=0.12, label=label)
        axes.set_ylim(bottom=bottom)
    low, high = axes.get_xlim()
    speed = max(target.speed, 1.0)
    if low < 1 / speed < 3 * high:
        name = "real time" if speed == 1 else f"{speed:g} x real time"
        axes.axvline(1 / speed, color="#D55E00", linewidth=0.9, label=name)
    late = [row for rows in _lines(trade).values() for row in rows if target.late(row)]
    if target.deadline is not None and late:
        axes.plot(
            [row.cpu for row in late],
            [_height(trade, row) for row in late],
            "x",
            color="#B00020",
            markersize=8,
            markeredgewidth=1.0,
            label=f"misses the deadline\nof {spelled(target.deadline)}",
        )
