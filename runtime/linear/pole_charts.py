"""Maps of poles and zeros, and root loci, in the complex plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bgc.runtime.linear.root_loci import Locus
from bgc.runtime.linear.zeros import Factors
from bgc.runtime.results.arrays import Complex
from bgc.runtime.results.plot import COLOURS, GUIDE, Target, picture

_WIDTH, _HEIGHT = 7.0, 5.8  # inches
_RATIOS = (0.1, 0.2, 0.3, 0.5, 0.7, 0.9)  # damping ratios of the rays
_LABEL = 0.07  # of half an axis: rays closer than this have no label of their own
_ROOM = 1.25  # of the poles and zeros around which a chart is drawn
_ROOM_OF_BRANCHES = 2.0  # the same of a root locus, whose branches leave the poles
_SPREAD = 30.0  # ratio of magnitudes from which on both axes are symmetrical logarithms


def plot_poles(poles: Complex, zeros: Complex, title: str, path: Target = None) -> Figure:
    """Draw poles as crosses and zeros as circles, with rays of equal damping ratio.

    `poles` and `zeros` are in 1/s, `title` stands above the chart, and `path` is a .png, .svg or
    .pdf file to write.
    """
    with picture(path, _WIDTH, _HEIGHT) as figure:
        axes = figure.subplots()
        _frame(axes, np.concatenate((poles, zeros)), _ROOM)
        _draw_zeros(axes, zeros, "zeros")
        _draw_poles(axes, poles, "poles")
        if len(zeros):
            _draw_legend(axes)
        figure.suptitle(title)
    return figure


def plot_locus(locus: Locus, factors: Factors, title: str, path: Target = None) -> Figure:
    """Draw the branches of a root locus from the poles to the zeros, with its crossings.

    `locus` and `factors` are those of one model, `title` stands above the chart, and `path` is a
    .png, .svg or .pdf file to write.
    """
    with picture(path, _WIDTH, _HEIGHT) as figure:
        axes = figure.subplots()
        crossings = np.array([1j * crossing.omega for crossing in locus.crossings])
        points = np.concatenate((factors.poles, factors.zeros, crossings, crossings.conj()))
        _frame(axes, points, _ROOM_OF_BRANCHES)
        for branch in locus.poles.T:
            axes.plot(branch.real, branch.imag, color=COLOURS[0], linewidth=1.1)
        _draw_zeros(axes, factors.zeros, "zeros: gain infinite")
        _draw_poles(axes, factors.poles, "poles: gain 0")
        _draw_legend(axes)
        for crossing in locus.crossings:
            axes.plot([0], [crossing.omega], "o", color=COLOURS[1], markersize=4)
            axes.annotate(
                f"gain {crossing.gain:.4g}", (0, crossing.omega), textcoords="offset points",
                xytext=(-6, 6), fontsize=8, color=COLOURS[1], ha="right",
            )  # fmt: skip
        figure.suptitle(title)
    return figure


def _draw_poles(axes: Any, poles: Complex, label: str) -> None:
    axes.plot(
        poles.real, poles.imag, "x", color=COLOURS[0], markersize=8, markeredgewidth=1.6,
        label=label,
    )  # fmt: skip


def _draw_zeros(axes: Any, zeros: Complex, label: str) -> None:
    if len(zeros):
        axes.plot(
            zeros.real, zeros.imag, "o", markerfacecolor="none", color=COLOURS[2], markersize=8,
            markeredgewidth=1.4, label=label,
        )  # fmt: skip


def _draw_legend(axes: Any) -> None:
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize="small")


def _frame(axes: Any, points: Complex, room: float) -> None:
    """Set the limits around the points, draw the axes and the rays of equal damping ratio.

    The limits are `room` times as far from 0 as the points. Where magnitudes differ much, both
    scales are linear up to the smallest and logarithmic beyond it; rays would be bent there and
    are left out.
    """
    sizes = np.abs(points)
    sizes = sizes[sizes > 1e-9 * sizes.max(initial=0.0)]
    largest = float(sizes.max()) if len(sizes) else 1.0
    spread = largest / float(sizes.min()) if len(sizes) else 1.0
    left = min(float(points.real.min(initial=0.0)), -0.1 * largest)
    right = max(float(points.real.max(initial=0.0)), 0.1 * largest)
    up = max(float(np.abs(points.imag).max(initial=0.0)), 0.3 * largest)
    if spread > _SPREAD:
        linear = 10.0 ** math.floor(math.log10(float(sizes.min())))
        axes.set_xscale("symlog", linthresh=linear)
        axes.set_yscale("symlog", linthresh=linear)
        left, right, up = left * 2, max(right, linear) * 2, max(up, linear) * 2
    else:
        left, right, up = left * room, right * room, up * room
        _draw_rays(axes, left, up)
    axes.axhline(0, color=GUIDE, linewidth=0.8)
    axes.axvline(0, color=GUIDE, linewidth=0.8)
    axes.set_xlim(left, right)
    axes.set_ylim(-up, up)
    axes.set_xlabel("real part [1/s]")
    axes.set_ylabel("imaginary part [rad/s]")


def _draw_rays(axes: Any, left: float, up: float) -> None:
    """Draw rays of equal damping ratio up to the frame, each with its ratio at its end."""
    last = (math.inf, math.inf)
    for ratio in _RATIOS:
        across = math.sqrt(1 - ratio**2)
        length = min(-left / ratio, up / across)
        for side in (1, -1):
            x, y = -length * ratio, side * length * across
            axes.plot([0, x], [0, y], color=GUIDE, linewidth=0.5, linestyle=":")
        end = (-length * ratio, length * across)
        if max(abs(end[0] - last[0]) / -left, abs(end[1] - last[1]) / up) < _LABEL:
            continue
        last = end
        axes.annotate(
            f"{ratio:g}", end, textcoords="offset points",
            xytext=(3, -3), fontsize=7, color=GUIDE, va="top",
        )  # fmt: skip
