"""Nyquist and Nichols charts of an open loop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from bgc.runtime.linear.frequency import Response
from bgc.runtime.linear.landmarks import Landmark
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.results.plot import COLOURS, GUIDE, Target, picture

_FIGURE_INCHES = 6.4  # inches
_WIDEST = 8.0  # half the width of a Nyquist chart whose curve is unbounded
_CIRCLES = (-20.0, -12.0, -6.0, -3.0, 0.0, 1.0, 3.0, 6.0, 12.0)  # dB of the closed loop
_LOWEST, _HIGHEST = -60.0, 40.0  # dB that a Nichols chart shows at most


def plot_nyquist(response: Response, path: Target = None) -> Figure:
    """Draw G(i omega) for positive and, dashed, for negative frequencies, with the point -1.

    `response` is that of an open loop, and `path` a .png, .svg or .pdf file to write. A curve that
    leaves to infinity, by a pole on the imaginary axis, is cut off.
    """
    value = response.value
    with picture(path, _FIGURE_INCHES, _FIGURE_INCHES) as figure:
        axes = figure.subplots()
        angle = np.linspace(0, 2 * math.pi, 361)
        axes.plot(np.cos(angle), np.sin(angle), color=GUIDE, linewidth=0.8, linestyle=":")
        axes.plot(value.real, value.imag, color=COLOURS[0], label="frequency above 0")
        axes.plot(
            value.real, -value.imag, color=COLOURS[0], linestyle="--", linewidth=0.9,
            label="below 0",
        )  # fmt: skip
        half = _half_width(value)
        _draw_arrow(axes, value, half)
        _draw_critical(axes, -1.0)
        for mark in _margins(response):
            _draw_margin(axes, mark, mark.value.real, mark.value.imag)
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, fontsize="small")
        centre = _centre(value, half)
        axes.set_xlim(centre.real - half, centre.real + half)
        axes.set_ylim(centre.imag - half, centre.imag + half)
        axes.set_aspect("equal")
        unit = f" [{response.unit}]" if response.unit else ""
        axes.set_xlabel(f"real part{unit}")
        axes.set_ylabel(f"imaginary part{unit}")
        figure.suptitle(f"{response.output} by {response.input}")
    return figure


def _half_width(value: Complex) -> float:
    """Half the width of the chart: the whole curve with -1, or a part of a very large one."""
    largest = float(max(np.abs(value.real).max(), np.abs(value.imag).max()))
    if largest > _WIDEST and largest > 20 * float(np.median(np.abs(value))):
        return max(1.5, min(_WIDEST, 3 * float(np.median(np.abs(value)))))
    low, high = min(-1.0, float(value.real.min())), max(0.0, float(value.real.max()))
    return 1.1 * max((high - low) / 2, float(np.abs(value.imag).max()))


def _centre(value: Complex, half: float) -> complex:
    low, high = min(-1.0, float(value.real.min())), max(0.0, float(value.real.max()))
    return complex((low + high) / 2 if (high - low) / 2 <= half else -0.5, 0.0)


def _draw_arrow(axes: Any, value: Complex, half: float) -> None:
    """Mark the direction of rising frequency at the middle of the visible curve."""
    seen = np.flatnonzero((np.abs(value) < 1.2 * half) & (np.abs(value) > 0.05 * half))
    if len(seen) < 2:
        return
    way = np.cumsum(np.abs(np.diff(value[seen], prepend=value[seen[0]])))
    k = int(seen[np.searchsorted(way, way[-1] / 2)])
    k = min(max(k, 1), len(value) - 1)
    axes.annotate(
        "",
        xy=(value[k].real, value[k].imag),
        xytext=(value[k - 1].real, value[k - 1].imag),
        arrowprops={"arrowstyle": "-|>", "color": COLOURS[0], "mutation_scale": 16},
    )


def plot_nichols(response: Response, path: Target = None) -> Figure:
    """Draw the magnitude over the phase, on curves of equal magnitude of the closed loop.

    `response` is that of the open loop, and `path` a .png, .svg or .pdf file to write.
    """
    phase, magnitude = response.phase, response.magnitude
    shown = np.isfinite(magnitude) & (magnitude > _LOWEST)
    low, high = _limits(phase[shown])
    with picture(path, 8.0, 5.6) as figure:
        axes = figure.subplots()
        bottom = max(_LOWEST, math.floor(magnitude[shown].min(initial=-30) / 10) * 10)
        top = min(_HIGHEST, max(20.0, math.ceil(magnitude[shown].max(initial=10) / 10) * 10))
        _draw_closed_magnitudes(axes, low, high, bottom, top)
        axes.plot(phase, magnitude, color=COLOURS[0])
        for turn in np.arange(math.ceil((low - 180) / 360), math.floor((high - 180) / 360) + 1):
            at = 180.0 + 360.0 * turn
            _draw_critical(axes, at)
        for mark in _margins(response):
            k = int(np.argmin(np.abs(response.omega - mark.omega)))  # the phase without jumps
            _draw_margin(axes, mark, float(phase[k]), float(magnitude[k]))
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, fontsize="small")
        axes.set_xlim(low, high)
        axes.set_ylim(bottom, top)
        axes.xaxis.set_major_locator(MultipleLocator(45 if high - low <= 540 else 180))
        axes.set_xlabel("phase [deg]")
        unit = f" re 1 {response.unit}" if response.unit else ""
        axes.set_ylabel(f"magnitude [dB{unit}]")
        figure.suptitle(f"{response.output} by {response.input}")
    return figure


def _margins(response: Response) -> list[Landmark]:
    """Return the landmarks that are margins: where the loop has magnitude 1 or phase -180 deg."""
    return [mark for mark in response.landmarks if mark.kind in ("phase margin", "gain margin")]


def _draw_margin(axes: Any, mark: Landmark, x: float, y: float) -> None:
    """Draw a dot where a margin is taken, and write the margin beside it."""
    axes.plot([x], [y], "o", color=COLOURS[2], markersize=4)
    axes.annotate(
        mark.meaning, (x, y), textcoords="offset points", xytext=(6, -9), fontsize=8,
        color=COLOURS[2],
    )  # fmt: skip


def _draw_critical(axes: Any, x: float) -> None:
    """Draw the critical point -1, which has the magnitude 0 dB and the phase -180 deg."""
    marks = axes.get_legend_handles_labels()[1]
    axes.plot(
        [x], [0], "+", markersize=11, markeredgewidth=1.8, color=COLOURS[1],
        label=None if "-1" in marks else "-1",
    )  # fmt: skip


def _limits(phase: Array) -> tuple[float, float]:
    """The range of phases, to multiples of 45 deg, with the nearest -180 + 360 k inside."""
    low, high = float(phase.min(initial=-180.0)), float(phase.max(initial=-90.0))
    middle = (low + high) / 2
    critical = 180.0 + 360.0 * round((middle - 180.0) / 360.0)
    low, high = min(low, critical - 45), max(high, critical + 45)
    return math.floor(low / 45 - 1e-9) * 45.0, math.ceil(high / 45 + 1e-9) * 45.0


def _draw_closed_magnitudes(axes: Any, low: float, high: float, bottom: float, top: float) -> None:
    phase, magnitude = np.meshgrid(np.linspace(low, high, 481), np.linspace(bottom, top, 321))
    loop = 10 ** (magnitude / 20) * np.exp(1j * np.deg2rad(phase))
    with np.errstate(divide="ignore", invalid="ignore"):
        closed = 20 * np.log10(np.abs(loop / (1 + loop)))
    lines = axes.contour(
        phase, magnitude, closed, levels=_CIRCLES, colors=GUIDE, linewidths=0.6, linestyles=":"
    )
    axes.clabel(lines, fmt=lambda level: f"{level:g} dB", fontsize=7)
