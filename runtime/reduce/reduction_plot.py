"""The plot of a reduction: error against the operations of all that was tried."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from bgc.runtime.reduce.reduction import ReductionResult
from bgc.runtime.reduce.search import MODEL_SHARE
from bgc.runtime.results.plot import COLOURS, Target, picture
from bgc.runtime.trade.judge import spelled
from bgc.runtime.trade.measurement import DONE

_FIGURE_INCHES = (8.0, 5.0)
_LEAST_DRAWN_ERROR = 1e-9


def plot_reduction(found: ReductionResult, path: Target = None) -> Figure:
    """Draw a reduction; write the figure if a path is given."""
    with picture(path, *_FIGURE_INCHES) as figure:
        _draw(figure.add_subplot(), found)
    return figure


def _draw(axes: Any, found: ReductionResult) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    tried = [trial for trial in found.tried if trial.status == DONE and trial.work > 0]
    for accurate, colour, name in (
        (True, COLOURS[0], "within the requirement"),
        (False, COLOURS[1], "beyond it"),
    ):
        those = [trial for trial in tried if trial.accurate == accurate]
        axes.plot(
            [trial.work for trial in those],
            [max(trial.error, _LEAST_DRAWN_ERROR) for trial in those],
            "o",
            color=colour,
            markersize=4.5,
            label=name,
        )
    path = [found.whole, *(stage.after for stage in found.stages)]
    axes.plot(
        [trial.work for trial in path],
        [max(trial.error, _LEAST_DRAWN_ERROR) for trial in path],
        color="0.55",
        linewidth=1.0,
        zorder=0,
        label="accepted, one after the other",
    )
    for trial in path:
        axes.annotate(
            f"{trial.states} states",
            (trial.work, max(trial.error, _LEAST_DRAWN_ERROR)),
            xytext=(4, 4),
            textcoords="offset points",
            fontsize="x-small",
        )
    axes.axhline(1.0, color="#D55E00", linewidth=0.9, linestyle="-.", label="the requirement")
    axes.axhline(
        MODEL_SHARE, color="0.5", linewidth=0.7, linestyle=":", label="the share of the model"
    )
    axes.grid(True, which="minor", alpha=0.12)
    axes.set_xlabel("operations of the run")
    axes.set_ylabel("error over the requirement")
    axes.set_title(f"{found.scene}: {spelled(found.duration)}", fontsize=9)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small")
