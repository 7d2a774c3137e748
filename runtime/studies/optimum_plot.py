"""Plot of an optimisation: the objective and the excess over the limits against the runs."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from bgc.diagnostics.catalogue.machine import unknown_file_kind
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.plot import COLOURS, KINDS, STYLE, Picture, write_figure


def plot_optimum(history: Array, label: str, scene: str, path: str | Path | None) -> Figure:
    """Draw a step for each better design: runs, objective as shown, excess over the limits.

    Designs that exceed a limit are hollow.
    """
    if path is not None and Path(path).suffix.lower() not in KINDS:
        raise BgError([unknown_file_kind(str(path), KINDS)])
    runs, values, excess = history.T
    with matplotlib.rc_context(STYLE):
        figure = Picture(figsize=(8.0, 3.6), layout="constrained")
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
        if path is not None:
            write_figure(figure, path)
    return figure
