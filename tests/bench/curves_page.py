"""The page of benchmarks: log-log plots of points over the size of a model, and tables of them."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

_FAMILIES = {
    "crane": ("Cranes", "beams on compliant joints"),
    "beam": ("Flexible beams", "elements in space"),
    "arm": ("Arms", "rigid links on hinges"),
    "tree": ("Trees", "rigid links on hinges, two on each"),
    "chain": ("Chains", "masses with springs and dampers"),
    "motors": ("Motors", "on one twisted shaft"),
    "circuit": ("Circuits", "nodes with capacitors and coils"),
    "ladder": ("Ladders", "nodes with resistive loops"),
    "grid": ("Grids", "nodes along an edge"),
    "field": ("Fields", "coupled coils"),
    "hydraulic": ("Hydraulic cranes", "states: on a quay, at sea"),
}
_DIFFERENT = {"hydraulic"}  # its points are of different models: there is no growth
_FIGURES = {
    "error": ("Time to an error of 1e-4", "processor time of a run, ms",
              "A run of 1 s (cranes, beams, arms, trees) or 10 s, against CVODE with KLU on the "
              "same compiled f and J, and SciPy's LSODA on the same f with dense differences (to "
              "400 states, without events); of arms and trees also against Drake by its quickest "
              "integrator. Each tool has the tolerance that is cheapest for it."),
    "controlled": ("Steps under error control", "processor time of a step, us",
                   "The same runs, over their accepted steps."),
    "rates": ("Accelerations", "processor time of a call, us",
              "The whole right-hand side, against Pinocchio's ABA, MuJoCo's `mj_forward`, and C "
              "that CasADi prints of the same equations."),
    "derivatives": ("Derivatives of the accelerations", "processor time of a call, us",
                    "The Jacobian, against Pinocchio's `computeABADerivatives` and CasADi's C. "
                    "Ours also has the derivatives of the friction and by the time."),
    "steps": ("Fixed steps of 1 ms", "processor time of a step, us",
              "Ours is of order three (`ros34prw`), or four where explicit steps resolve all "
              "motions (`switching_fixed`); MuJoCo's methods are of order one."),
    "compile": ("Compilation", "processor time, s",
                "`bgc build --target c`, and the C compiler for the shared object, with an empty "
                "cache; less the time of a model with one state."),
    "size": ("Size of the C", "kB", "The model's own code, without the runtime."),
    "memory": ("Memory of the compiler", "MB", "The largest of `bgc build --target c`."),
}  # fmt: skip
_INTRODUCTION = """\
# Benchmarks

Times are processor time, the least or the median of several measurements; the tools take turns in
one process, on a shared machine: ratios hold, absolute times vary with its load. A straight line
is a power of the size, and its exponent stands in the last column. `python tests/bench/curves.py`
measures everything again. The rules of each comparison stand at the top of `growth.py`,
`drake_peers.py`, `arm_peers.py` and `curves.py` in `tests/bench`.
"""
_OURS = ("ours", "ours, 1 ms", "our f", "our J", "ros34prw, 1 ms", "bgc", "C")
_COLOURS = ("#c2410c", "#1d4ed8", "#15803d", "#7e22ce")


@dataclass(frozen=True, slots=True)
class Point:
    """A value of a tool at a size of a family; its unit is that of the figure."""

    figure: str
    family: str
    tool: str
    size: int
    value: float
    machine: str

    @property
    def key(self) -> tuple[str, str, str, int]:
        return self.figure, self.family, self.tool, self.size


def read_points(path: Path) -> list[Point]:
    """Read the points of a file; none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Point(row["figure"], row["family"], row["tool"], int(row["size"]), float(row["value"]),
                  row["machine"])
            for row in csv.DictReader(file)
        ]  # fmt: skip


def page(points: Sequence[Point], folder: Path, pictures: str) -> list[str]:
    """Draw a picture of each figure into a folder; return the lines of the page.

    `pictures` is the path of the folder in the links of the page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lines = _INTRODUCTION.splitlines()
    for figure, (title, unit, about) in _FIGURES.items():
        chosen = [each for each in points if each.figure == figure]
        if chosen:
            _draw(chosen, unit, folder / f"{figure}.svg")
            lines += ["", f"## {title}", "", about, "", f"![{title}]({pictures}{figure}.svg)", ""]
            lines += _table(chosen, unit)
    machines = sorted({point.machine for point in points})
    return [*lines, "", "## Machine", "", *(f"- {each}" for each in machines)]


def exponent(points: Sequence[Point]) -> float | None:
    """The power of the size from the smallest to the largest, None for a single point."""
    first, last = points[0], points[-1]
    if first.size == last.size or first.value <= 0 or last.value <= 0:
        return None
    return math.log(last.value / first.value) / math.log(last.size / first.size)


def _curves(points: Iterable[Point]) -> list[tuple[str, str, list[Point]]]:
    """Family, tool and points by size; families in their order, ours first."""
    order = list(_FAMILIES)
    points = sorted(
        points, key=lambda p: (order.index(p.family), p.tool not in _OURS, p.tool, p.size)
    )
    groups = groupby(points, key=lambda p: (p.family, p.tool))
    return [(family, tool, list(group)) for (family, tool), group in groups]


def _table(points: Sequence[Point], unit: str) -> list[str]:
    """A table for each family: a row for each tool, a column for each size."""
    lines: list[str] = []
    for family, group in groupby(_curves(points), key=lambda curve: curve[0]):
        curves = list(group)
        title, of = _FAMILIES[family]
        sizes = sorted({point.size for _, _, found in curves for point in found})
        lines += [f"**{title}** ({of}), {unit.rpartition(', ')[2]}", ""]
        lines.append("| | " + " | ".join(map(str, sizes)) + " | growth |")
        lines.append("|---" * (len(sizes) + 2) + "|")
        for _, tool, found in curves:
            values = {point.size: f"{point.value:.3g}" for point in found}
            power = None if family in _DIFFERENT else exponent(found)
            growth = "" if power is None else f"n^{power:.2f}"
            cells = [values.get(size, "") for size in sizes]
            lines.append(f"| {tool} | " + " | ".join([*cells, growth]) + " |")
        lines.append("")
    return lines[:-1]


def _draw(points: Sequence[Point], unit: str, path: Path) -> None:
    """A row of log-log plots, one for each family, with the same scale of the values."""
    import matplotlib as mpl  # heavy, and needed for drawing only

    mpl.use("svg")
    from matplotlib import pyplot as plt
    from matplotlib.ticker import FormatStrFormatter

    curves = _curves(points)
    families = list(dict.fromkeys(family for family, _, _ in curves))
    tools = list(dict.fromkeys(tool for _, tool, _ in curves))
    columns = min(4, len(families))
    rows = math.ceil(len(families) / columns)
    size = (max(6.0, 2.6 * columns + 0.6), 2.5 * rows + 0.5)
    with mpl.rc_context({"font.size": 8, "svg.hashsalt": "bgc", "axes.titlesize": 9}):
        figure, axes = plt.subplots(rows, columns, figsize=size, sharey=True, squeeze=False)
        for place, axis in enumerate(axes.flat):
            if place >= len(families):
                axis.set_visible(False)
                continue
            title, of = _FAMILIES[families[place]]
            sizes: set[int] = set()
            for family, tool, found in curves:
                if family == families[place]:
                    sizes |= {point.size for point in found}
                    colour = _COLOURS[tools.index(tool) % len(_COLOURS)]
                    axis.loglog([p.size for p in found], [p.value for p in found], "o-",
                                color=colour, markersize=3, linewidth=1.2, label=tool)  # fmt: skip
            axis.set_title(title)
            axis.set_xlabel(of)
            axis.set_xticks(sorted(sizes), [str(each) for each in sorted(sizes)])
            axis.minorticks_off()
            axis.yaxis.set_major_formatter(FormatStrFormatter("%g"))
            axis.grid(visible=True, color="#e5e7eb", linewidth=0.6)
            axis.spines[["top", "right"]].set_visible(False)
            if place % columns == 0:
                axis.set_ylabel(unit)
        handles = {
            label: handle
            for axis in axes.flat
            for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles.keys(), loc="upper center", ncols=len(tools),
                      frameon=False)  # fmt: skip
        figure.tight_layout(rect=(0, 0, 1, 1 - 0.3 / size[1]))
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)
