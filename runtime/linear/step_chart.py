"""The chart of a step or impulse response."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from bgc.runtime.linear.time_response import TimeResponse
from bgc.runtime.results.plot import COLOURS, Target, picture

_GUIDE = "#999999"


def plot_time_response(response: TimeResponse, title: str, path: Target = None) -> Figure:
    """Draw each output of `response` in a panel of its own, with its steady value as a dotted line.

    `title` stands above the chart, and `path` is a .png, .svg or .pdf file to write.
    """
    count = len(response.outputs)
    with picture(path, 8.0, 0.8 + 2.8 * count) as figure:
        every = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
        for k, axes in enumerate(every):
            axes.plot(response.time, response.value[:, k], color=COLOURS[0])
            steady = float(response.steady[k])
            if math.isfinite(steady):
                axes.axhline(
                    steady, color=_GUIDE, linestyle=":", linewidth=0.9,
                    label=f"steady value {steady:.4g}",
                )  # fmt: skip
                axes.legend(fontsize="small")
            unit = f" [{response.units[k]}]" if response.units[k] else ""
            axes.set_ylabel(f"{response.outputs[k]}{unit}")
            axes.margins(x=0)
        every[-1].set_xlabel("time [s]")
        figure.align_ylabels()
        figure.suptitle(title)
    return figure
