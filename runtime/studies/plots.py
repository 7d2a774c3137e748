"""Plots of an estimation, of an optimisation and of operability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from bgc.runtime.results.arrays import Array
from bgc.runtime.results.plot import COLOURS, Target, picture

_MOST_CELLS = 150  # of a map whose cells are written
_DARK = 0.75  # from a share of 1, where the colours are dark

_Axis = tuple[Array, str]


def plot_estimate(
    columns: Sequence[tuple[str, Array, Array, Array]], scene: str, path: Target
) -> Figure:
    """Draw columns, each with its label, times, recorded and computed values."""
    with picture(path, 8.0, 2.6 * len(columns) + 0.7) as figure:
        axes = figure.subplots(len(columns), 1, squeeze=False, sharex=True)[:, 0]
        for place, (label, time, recorded, computed) in zip(axes, columns, strict=True):
            place.plot(time, recorded, ".", color=COLOURS[1], markersize=3, label="recorded")
            place.plot(time, computed, color=COLOURS[0], label="computed")
            place.set_ylabel(label)
        axes[0].legend()
        axes[-1].set_xlabel("time [s]")
        figure.suptitle(f"{scene}: estimated parameters")
    return figure


def plot_optimum(history: Array, label: str, scene: str, path: Target) -> Figure:
    """Draw a step for each better design: runs, objective as shown, excess over the limits.

    Designs that exceed a limit are hollow.
    """
    runs, values, excess = history.T
    with picture(path, 8.0, 3.6) as figure:
        axes = figure.subplots()
        axes.step(runs, values, where="post", color=COLOURS[0], linewidth=1.0)
        held = excess <= 1e-6
        axes.plot(runs[held], values[held], "o", color=COLOURS[0], markersize=4, label="limits met")
        if not held.all():
            axes.plot(
                runs[~held], values[~held], "o", color=COLOURS[1], markersize=4, fillstyle="none",
                label="a limit exceeded",
            )  # fmt: skip
            axes.legend()
        axes.set_xlabel("runs")
        axes.set_ylabel(label)
        figure.suptitle(f"{scene}: best design by then")
    return figure


def plot_operability(
    titles: Sequence[str],
    periods: _Axis,
    heights: _Axis,
    worst: Array,
    limits: Array,
    cells: Sequence[Sequence[Sequence[str]]],
    legend: Sequence[str],
    path: Target,
) -> Figure:
    """Draw a map for each heading: colours of utilisation, its cells as texts, the limit."""
    (x, x_label), (y, y_label) = periods, heights
    columns = min(2, len(titles))
    rows = -(-len(titles) // columns)
    wide = max(5.0, 1.5 + 0.5 * len(x))  # inches, so that the texts of cells stand apart
    with picture(path, wide * columns, 3.8 * rows + 0.8) as figure:
        axes = figure.subplots(rows, columns, squeeze=False)
        for h, place in enumerate(axes.flat):
            if h >= len(titles):
                place.set_visible(False)
                continue
            place.grid(False)
            shown = np.minimum(worst[h].T, 2.0)
            drawn = place.pcolormesh(
                x, y, shown, shading="nearest", cmap="RdYlBu_r", vmin=0, vmax=2
            )
            place.plot(x, limits[h], color="black", marker="o", markersize=3, label="limit")
            if worst[h].size <= _MOST_CELLS:
                for k, i in np.ndindex(len(y), len(x)):
                    colour = "white" if abs(shown[k, i] - 1.0) > _DARK else "black"
                    place.text(
                        x[i],
                        y[k],
                        cells[h][k][i],
                        color=colour,
                        ha="center",
                        va="center",
                        fontsize=7,
                    )
            place.set_ylim(bottom=max(place.get_ylim()[0], 0.0))
            place.set_title(titles[h])
            place.set_xlabel(x_label)
            place.set_ylabel(y_label)
        figure.colorbar(drawn, ax=axes, label="share of the limit (black line: limiting height)")
        figure.suptitle("\n".join(legend), fontsize="small")
    return figure


def plot_effects(
    columns: Sequence[tuple[str, Sequence[str], Array]], scene: str, path: Target
) -> Figure:
    """Draw a panel for each observable: its label, parameters, and the effects of 1 % of them."""
    columns = [each for each in columns if each[1]] or columns[:1]
    tall = max(len(names) for _, names, _ in columns)
    with picture(path, 8.0, (0.9 + 0.24 * tall) * len(columns) + 0.5) as figure:
        panels = figure.subplots(len(columns), 1, squeeze=False)[:, 0]
        for place, (label, names, effects) in zip(panels, columns, strict=True):
            rows = np.arange(len(names))
            for sign, text in ((1, "1 % more"), (-1, "1 % less")):
                place.barh(rows, sign * effects, 0.7, color=COLOURS[sign < 0], label=text)
            place.axvline(0.0, color="black", linewidth=0.8)
            place.set_yticks(rows, names)
            place.invert_yaxis()
            place.grid(axis="y", visible=False)
            place.set_xlabel(f"change of {label}")
        panels[0].legend(loc="lower right")
        figure.suptitle(f"{scene}: effects of the parameters")
    return figure
