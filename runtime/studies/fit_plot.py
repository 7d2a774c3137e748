"""Plot of an estimation: recorded and computed columns over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from bgc.diagnostics.catalogue.machine import unknown_file_kind
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.plot import COLOURS, KINDS, STYLE, Picture, write_figure


def plot_estimate(
    columns: Sequence[tuple[str, Array, Array, Array]], scene: str, path: str | Path | None
) -> Figure:
    """Draw columns, each with its label, times, recorded and computed values."""
    if path is not None and Path(path).suffix.lower() not in KINDS:
        raise BgError([unknown_file_kind(str(path), KINDS)])
    with matplotlib.rc_context(STYLE):
        figure = Picture(figsize=(8.0, 2.6 * len(columns) + 0.7), layout="constrained")
        axes = figure.subplots(len(columns), 1, squeeze=False, sharex=True)[:, 0]
        for place, (label, time, recorded, computed) in zip(axes, columns, strict=True):
            place.plot(time, recorded, ".", color=COLOURS[1], markersize=3, label="recorded")
            place.plot(time, computed, color=COLOURS[0], label="computed")
            place.set_ylabel(label)
        axes[0].legend()
        axes[-1].set_xlabel("time [s]")
        figure.suptitle(f"{scene}: estimated parameters")
        if path is not None:
            write_figure(figure, path)
    return figure
