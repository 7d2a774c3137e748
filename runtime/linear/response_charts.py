"""Charts of responses: the Bode plot over frequencies, a step or an impulse over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle

from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from bgc.runtime.linear.frequency import Response
from bgc.runtime.linear.time_response import TimeResponse
from bgc.runtime.results.plot import COLOURS, GUIDE, Target, picture

_WIDTH, _HEIGHT = 8.0, 5.6  # inches
_PHASE_STEPS = (15.0, 30.0, 45.0, 90.0, 180.0, 360.0)
_MOST_TICKS = 8


def plot_bode(responses: Sequence[Response], path: Target = None) -> Figure:
    """Draw responses in one chart, and write it as .png, .svg or .pdf."""
    several = len(responses) > 1
    with picture(path, _WIDTH, _HEIGHT) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        for response, colour in zip(responses, cycle(COLOURS), strict=False):
            label = f"{response.output} by {response.input}"
            upper.semilogx(response.omega, response.magnitude, color=colour, label=label)
            lower.semilogx(response.omega, response.phase, color=colour)
        units = {response.unit for response in responses}
        unit = units.pop() if len(units) == 1 else "1 SI unit"
        upper.set_ylabel(f"magnitude [dB{_reference(unit)}]")
        lower.set_ylabel("phase [deg]")
        lower.set_xlabel("frequency [rad/s]")
        lower.yaxis.set_major_locator(MultipleLocator(_phase_step(responses)))
        for axes in (upper, lower):
            axes.margins(x=0)
            axes.grid(True, which="minor", axis="x", alpha=0.15)
        figure.align_ylabels()
        if several:
            upper.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, fontsize="small")
        else:
            figure.suptitle(f"{responses[0].output} by {responses[0].input}")
    return figure


def _reference(unit: str) -> str:
    return f" re {unit if unit.startswith('1 ') else f'1 {unit}'}" if unit else ""


def _phase_step(responses: Sequence[Response]) -> float:
    """Choose the degrees between ticks, so that there are at most eight."""
    low = min(float(response.phase.min()) for response in responses)
    span = max(float(response.phase.max()) for response in responses) - low
    return next((s for s in _PHASE_STEPS if span / s <= _MOST_TICKS), 360.0 * (1 + span // 2880))


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
                    steady, color=GUIDE, linestyle=":", linewidth=0.9,
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
