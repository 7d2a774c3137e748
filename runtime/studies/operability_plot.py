"""Maps of operability over period and height."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from bgc.diagnostics.catalogue.machine import unknown_file_kind
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.plot import KINDS, STYLE, Picture, write_figure

_MOST_CELLS = 150  # of a map whose cells are written

_DARK = 0.75  # from a share of 1, where the colours are dark

_Axis = tuple[Array, str]


def plot_operability(
    titles: Sequence[str],
    periods: _Axis,
    heights: _Axis,
    worst: Array,
    limits: Array,
    cells: Sequence[Sequence[Sequence[str]]],
    legend: Sequence[str],
    path: str | Path | None,
) -> Figure:
    """Draw a map for each heading: colours of utilisation, its cells as texts, the limit."""
    if path is not None and Path(path).suffix.lower() not in KINDS:
        raise BgError([unknown_file_kind(str(path), KINDS)])
    (x, x_label), (y, y_label) = periods, heights
    columns = min(2, len(titles))
    rows = -(-len(titles) // columns)
    with matplotlib.rc_context(STYLE):
        wide = max(5.0, 1.5 + 0.5 * len(x))  # inches, so that the texts of cells stand apart
        figure = Picture(figsize=(wide * columns, 3.8 * rows + 0.8), layout="constrained")
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
        if path is not None:
            write_figure(figure, path)
    return figure
