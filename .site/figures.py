"""Pages of the site with figures: benchmarks from recorded numbers, and the paper's figures."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt
from pages import Page

_INTRODUCTION = """\
# Benchmarks

Numbers from the scripts in `tests/bench`, recorded in `tests/bench/recorded.csv`; both axes are
logarithmic. They are from a shared machine with 2 cores (gcc 12): ratios hold,
absolute times vary with its load. `python tests/bench/run.py` measures again, against CVODE,
SciPy, MuJoCo, Pinocchio and CasADi.
"""

# Figures of the paper: number, subject, and the part of the library that stands for it here.
_PAPER = (
    ("2", "a rigid body", "mechanics.body.RigidBody"),
    ("4", "a rigid beam", "crane.beam.Beam"),
    ("5", "a spherical joint", "mechanics.joints.Spherical"),
    ("7", "a kinematic typology, two beams that slew", "crane.kinematics.Slew2R"),
    ("8", "a vessel", "marine.vessel.Vessel"),
    ("9", "the two-beam crane", "crane.two_beam.TwoBeamCrane"),
)


@dataclass(frozen=True, slots=True)
class Point:
    """A recorded number: its plot with the labels of its axes, its curve, and the command."""

    plot: str
    x: str
    y: str
    series: str
    at: float
    value: float
    command: str


def read_points(path: Path) -> list[Point]:
    """Read recorded numbers."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Point(row["plot"], row["x"], row["y"], row["series"], float(row["at"]),
                  float(row["value"]), row["command"])
            for row in csv.DictReader(file)
        ]  # fmt: skip


def benchmarks(docs: Path, recorded: Path) -> list[Page]:
    """Draw each plot of the recorded numbers, with the numbers below it."""
    lines = [*_INTRODUCTION.splitlines(), ""]
    (docs / "benchmarks").mkdir(parents=True, exist_ok=True)
    for number, (title, found) in enumerate(groupby(read_points(recorded), lambda p: p.plot), 1):
        points = list(found)
        name = f"benchmarks/plot{number}.svg"
        _draw(docs / name, points)
        lines += [f"## {title}", "", f"![{title}]({name})", "", *_table(points), ""]
        lines += [f"`{command}`" for command in dict.fromkeys(p.command for p in points)] + [""]
    return [Page("benchmarks.md", "Benchmarks", "", lines)]


def _draw(path: Path, points: Sequence[Point]) -> None:
    """Draw the curves over logarithmic axes; errors run from coarse to fine."""
    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for series in dict.fromkeys(p.series for p in points):
        curve = [(p.at, p.value) for p in points if p.series == series]
        axes.loglog(*zip(*curve, strict=True), marker="o", label=series)
    places = sorted({p.at for p in points})
    axes.set_xticks(places, [f"{place:g}" for place in places])
    axes.minorticks_off()
    if places[-1] < 1:
        axes.invert_xaxis()
    axes.set_xlabel(points[0].x)
    axes.set_ylabel(points[0].y)
    axes.grid(which="both", alpha=0.3)
    axes.legend()
    # Without the date, and with fixed names inside: the same numbers make the same file.
    with mpl.rc_context({"svg.hashsalt": "bgc"}):
        figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def _table(points: Sequence[Point]) -> list[str]:
    places = list(dict.fromkeys(p.at for p in points))
    value = {(p.series, p.at): f"{p.value:g}" for p in points}
    head = f"| {points[0].y} at {points[0].x} |" + "".join(f" {place:g} |" for place in places)
    rows = [
        f"| {series} |" + "".join(f" {value.get((series, place), '-')} |" for place in places)
        for series in dict.fromkeys(p.series for p in points)
    ]
    return [head, "|---|" + "---:|" * len(places), *rows]


def paper() -> list[Page]:
    """Show the counterparts of the paper's figures: drawings of the library and plots of a run."""
    lines = [
        "# Figures of the paper",
        "",
        "Sanfilippo, Hildre, Aesoey, Zhang and Pedersen, *Flexible modeling and simulation "
        "architecture for haptic control of maritime cranes and robotic arms* (2013), and the "
        "counterparts of its figures here. Bond graphs are drawn by bgc from the models.",
        "",
    ]
    for number, subject, name in _PAPER:
        anchor = name.rpartition(".")[0].replace(".", "")
        lines += [f"## Fig. {number}: {subject}", ""]
        lines += [f"{name} of [the library](library/README.md#{anchor})", ""]
        lines += [f"![Bond graph of {name}](library/pictures/{name}.svg)", ""]
    lines += [
        "## Fig. 11 and 12: the operator lifts a load",
        "",
        "Above: the height of the tip follows the operator's hand (Fig. 11). Below: the force in "
        "the hand against the elevation of the tip (Fig. 12).",
        "",
        "```sh",
        "bgc run library/scenes/two_beam_crane.bg --plot crane.png",
        "```",
        "",
        "![Tip height and force](.assets/two_beam_crane.png)",
        "",
    ]
    return [Page("paper.md", "Figures of the paper", "paper.md", lines)]
