"""The picture of a stress map: a cell for each point, coloured by verdict, with its error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from bgc.runtime.results.plot import picture
from bgc.runtime.stress.stress import Point, StressMap
from bgc.runtime.stress.stress_judge import Judgement, Verdict
from bgc.values.shown_units import Shown

# The order is light to dark also in grey; green and red differ in lightness and text.
_COLOURS: Mapping[Verdict, str] = MappingProxyType(
    {
        Verdict.HOLDS: "#b7e1b0",
        Verdict.DEGRADED: "#f5d76e",
        Verdict.WARNED: "#e8a04c",
        Verdict.WRONG: "#c0392b",
        Verdict.FAILS: "#8e9aa6",
        Verdict.SLOW: "#d5dbe1",
        Verdict.UNJUDGED: "#ffffff",
    }
)
_Cells = list[tuple[float, Judgement]]
_Row = tuple[str, _Cells]
_CELL = 0.62, 0.5  # inches, across and up
_MARGIN = 3.4, 1.6


def draw(found: StressMap, path: str | Path) -> Figure:
    """Draw a map and write it: a row for each drive, or a grid of two drives."""
    rows = _grid_rows(found) if found.grid else _drive_rows(found)
    widest = max(len(cells) for _, cells in rows)
    width, height = widest * _CELL[0] + _MARGIN[0], len(rows) * _CELL[1] + _MARGIN[1]
    with picture(path, width, height) as figure:
        _draw(figure, found, rows, widest)
    return figure


def _draw(figure: Figure, found: StressMap, rows: Sequence[_Row], widest: int) -> None:
    axes: Any = figure.add_subplot()
    for height, (_, cells) in enumerate(rows):
        for place, (value, judgement) in enumerate(cells):
            _cell(axes, place, height, value, judgement)
    axes.set_xlim(0, widest)
    axes.set_ylim(len(rows), 0)
    axes.set_yticks([k + 0.5 for k in range(len(rows))], [name for name, _ in rows])
    axes.tick_params(length=0)
    axes.set_xticks([])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    if found.grid:
        across = found.points[0].settings[0][0]
        unit = _shown(found, across).label
        axes.set_xlabel(f"{across} in {unit}" if unit else across)
    axes.set_title(f"{found.scene}: {found.method}", loc="left")
    seen = found.counts()
    patches = [
        Patch(facecolor=colour, edgecolor="#555555", label=f"{verdict.value} ({seen[verdict]})")
        for verdict, colour in _COLOURS.items()
        if seen.get(verdict)
    ]
    figure.legend(
        handles=patches,
        loc="outside lower center",
        ncols=min(len(patches), 4),
        frameon=False,
        title="in a cell: the value, and below it the largest error",
        title_fontsize="small",
    )


def _drive_rows(found: StressMap) -> list[_Row]:
    return [
        (
            f"{drive.name}, {drive.shown.label}" if drive.shown.label else drive.name,
            _ordered(found.of_drive(drive), drive.shown),
        )
        for drive in found.drives
    ]


def _grid_rows(found: StressMap) -> list[_Row]:
    """Make a row for each value of the second drive, the largest on top."""
    name = found.points[0].settings[1][0]
    heights = sorted({point.settings[1][1] for point in found.points}, reverse=True)
    across, up = _shown(found, found.points[0].settings[0][0]), _shown(found, name)
    return [
        (
            f"{name} = {up.text(y, 3)}",
            _ordered([p for p in found.points if p.settings[1][1] == y], across),
        )
        for y in heights
    ]


def _shown(found: StressMap, name: str) -> Shown:
    """The unit in which a drive is shown."""
    return next((drive.shown for drive in found.drives if drive.name == name), Shown(""))


def _ordered(points: Sequence[Point], shown: Shown) -> _Cells:
    """Sort points by the value of their first drive, in the unit in which it is shown."""
    cells = ((shown.number(point.settings[0][1]), point.judgement) for point in points)
    return sorted(cells, key=lambda cell: cell[0])


def _text(judgement: Judgement) -> str:
    if judgement.error is not None:
        return f"{judgement.error:.0e}"
    return judgement.message[:5] if judgement.verdict is Verdict.FAILS else ""


def _cell(axes: Any, x: int, y: int, value: float, judgement: Judgement) -> None:
    verdict = judgement.verdict
    dark = verdict is Verdict.WRONG
    axes.add_patch(
        Rectangle((x, y), 1, 1, facecolor=_COLOURS[verdict], edgecolor="white", linewidth=1.5)
    )
    text = _text(judgement)
    colour = "white" if dark else "#222222"
    axes.text(x + 0.5, y + 0.33, f"{value:.3g}", ha="center", va="center", fontsize=7,
              color=colour)  # fmt: skip
    axes.text(x + 0.5, y + 0.7, text, ha="center", va="center", fontsize=6.5, color=colour)
