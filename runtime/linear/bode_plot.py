"""The Bode plot: magnitude and phase over a logarithmic axis of frequencies."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from bgc.runtime.linear.frequency import Response
from bgc.runtime.results.plot import COLOURS, STYLE, write_figure

_WIDTH, _HEIGHT = 8.0, 5.6  # inches
_PHASE_STEPS = (15.0, 30.0, 45.0, 90.0, 180.0, 360.0)
_MOST_TICKS = 8


def plot_bode(response: Response, path: Path) -> Figure:
    """Draw a response, and write it as .png, .svg or .pdf."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.semilogx(response.omega, response.magnitude, color=COLOURS[0])
        lower.semilogx(response.omega, response.phase, color=COLOURS[0])
        unit = f" re 1 {response.unit}" if response.unit else ""
        upper.set_ylabel(f"magnitude [dB{unit}]")
        lower.set_ylabel("phase [deg]")
        lower.set_xlabel("frequency [rad/s]")
        lower.yaxis.set_major_locator(MultipleLocator(_phase_step(response)))
        for axes in (upper, lower):
            axes.margins(x=0)
            axes.grid(True, which="minor", axis="x", alpha=0.15)
        figure.suptitle(f"{response.output} by {response.input}")
        write_figure(figure, path)
    return figure


def _phase_step(response: Response) -> float:
    """Choose the degrees between ticks, so that there are at most eight."""
    span = float(response.phase.max() - response.phase.min())
    return next((s for s in _PHASE_STEPS if span / s <= _MOST_TICKS), 360.0 * (1 + span // 2880))
