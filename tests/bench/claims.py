"""The paper's claims about simulation time, measured: one page with plots.

    python tests/bench/claims.py [FOLDER]

Writes `claims.html`, self-contained, and its pictures to the folder (`claims` by default). The
paper damped its joints to shorten the simulation, held them by springs rather than rigidly, and
used Euler angles. Here its crane on a vessel (`claims.bg`) is run over joint stiffness and damping
by methods of several kinds, then compliant beside rigid, and in Euler angles beside quaternions.
CPU time is that of the integration alone, the shortest of three runs; errors are those of the tip
at all rows against a run at rtol 1e-11. SciPy's BDF has the same compiled right-hand side and
Jacobian, but is driven from Python: it is counted in evaluations of f.
"""

from __future__ import annotations

import base64
import html
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from table import machine

import bgc
from bgc.runtime.model import Model

SOURCE = Path(__file__).parent / "claims.bg"
STIFFNESSES = (1e7, 1e8, 1e9, 1e10)
DAMPING_RATIOS = (0.0, 0.01, 0.1, 0.3, 1.0)
STIFFNESS, RTOL = 1e8, 1e-6
MOST_EVALUATIONS = 50_000
LONG = 1.0  # s: what takes longer is not run again
SETTLE = 1.0  # Hz: between the vessel's motions and the joints'


@dataclass(frozen=True, slots=True)
class Measured:
    """One run: CPU seconds per simulated second, steps, error of the tip in m."""

    cost: float
    steps: int
    error: float


def given(stiffness: float, damping: float) -> dict[str, float]:
    """The locks of the three joints."""
    joints = ("pedestal", "shoulder", "elbow")
    return {
        f"crane.{joint}.lock.{name}": value
        for joint in joints
        for name, value in (("stiffness", stiffness), ("damping_ratio", damping))
    }


def measure(
    model: Model, parameters: dict[str, float], solver: str, settle: float | None = None
) -> Measured:
    """The shortest of three runs, or NaN where it fails."""
    exact = model.simulate(
        solver="rodas5p", rtol=1e-11, parameters=parameters, settle=settle, error=False
    )
    try:
        runs = []
        while len(runs) < 3 and (not runs or runs[-1].counts["run_seconds"] < LONG):
            runs.append(
                model.simulate(
                    solver=solver, rtol=RTOL, parameters=parameters, settle=settle, error=False
                )
            )
    except bgc.SimulationError:
        return Measured(float("nan"), 0, float("nan"))
    best = min(runs, key=lambda run: run.counts["run_seconds"])
    error = float(np.abs(best["tip"] - exact["tip"]).max())
    return Measured(best.counts["run_seconds"] / best.time[-1], int(best.counts["steps"]), error)


class TooManyEvaluations(Exception):
    """A run of SciPy's that takes too long."""


def bdf_evaluations(model: Model, parameters: dict[str, float]) -> float:
    """Count SciPy's evaluations of f by BDF over the scene; infinite beyond the bound."""
    count = 0

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        nonlocal count
        count += 1
        if count > MOST_EVALUATIONS:
            raise TooManyEvaluations
        instance.state[:] = state
        return instance.rhs()[1]

    def jacobian(time: float, state: np.ndarray) -> np.ndarray:
        instance.state[:] = state
        return instance.jacobian()[1]

    instance = model.parameters.instance(parameters)
    instance.reset()
    start = instance.state.copy()
    try:
        solve_ivp(
            rates, (0, model.facts.duration), start, "BDF", rtol=RTOL, atol=RTOL, jac=jacobian
        )
    except TooManyEvaluations:
        return float("inf")
    return count


KINDS = (("rodas5p", None), ("rodas5p", SETTLE), ("radau5", None), ("dopri5", None))


def label(solver: str, settle: float | None) -> str:
    return solver if settle is None else f"{solver}, settled start"


def curves(
    model: Model, xs: Sequence[float], parameters, name: str, title: str, folder: Path
) -> tuple[Path, list[list[str]]]:
    """Cost over one parameter by all methods: a picture and a table."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2))
    table = [[name, *(label(*kind) for kind in KINDS), "BDF (SciPy), evaluations of f"]]
    rows: dict[float, list[str]] = {x: [f"{x:g}"] for x in xs}
    places = np.arange(len(xs))
    for kind in KINDS:
        solver, settle = kind
        found = [measure(model, parameters(x), solver, settle) for x in xs]
        left.semilogy(places, [m.cost * 1e3 for m in found], "o-", label=label(*kind))
        right.semilogy(places, [m.steps or np.nan for m in found], "o-", label=label(*kind))
        for x, m in zip(xs, found, strict=True):
            rows[x].append(f"{m.cost * 1e3:.3g} ms/s, {m.steps:,} steps, {m.error:.1e} m")
    for x in xs:
        evaluations = bdf_evaluations(model, parameters(x))
        many = f"more than {MOST_EVALUATIONS:,}"
        rows[x].append(many if np.isinf(evaluations) else f"{evaluations:,}")
    for axes, what in ((left, "CPU time [ms per simulated s]"), (right, "steps")):
        axes.set(xlabel=name, ylabel=what)
        axes.set_xticks(places, [f"{x:g}" for x in xs])
        axes.grid(alpha=0.3)
    left.legend(fontsize=8)
    return save(figure, title, folder), table + [rows[x] for x in xs]


def save(figure: Figure, title: str, folder: Path) -> Path:
    target = folder / f"{title}.png"
    figure.tight_layout()
    figure.savefig(target, dpi=110)
    plt.close(figure)
    return target


def bars(models: dict[str, Model], folder: Path) -> tuple[Path, list[list[str]]]:
    """Compliant, rigid and Euler scenes beside each other."""
    table = [["scene", "states", "CPU time", "steps", "tip's error", "largest energy residual"]]
    costs = []
    for name, model in models.items():
        parameters = given(1e9, 1.0) if name != "rigid" else {}
        settle = None if name == "rigid" else SETTLE
        m = measure(model, parameters, "rodas5p", settle)
        run = model.simulate(rtol=RTOL, parameters=parameters, settle=settle, error=False)
        costs.append(m.cost * 1e3)
        residual = float(np.abs(run["residual"]).max())
        table.append([name, f"{len(model.states)}", f"{m.cost * 1e3:.3g} ms/s", f"{m.steps:,}",
                      f"{m.error:.1e} m", f"{residual:.2g} J"])  # fmt: skip
    figure, axes = plt.subplots(figsize=(5, 3.5))
    axes.bar([*models], costs)
    axes.set(ylabel="CPU time [ms per simulated s]")
    return save(figure, "variants", folder), table


def page(sections: Sequence[tuple[str, str, Path, list[list[str]]]], target: Path) -> None:
    parts = ["<!doctype html><meta charset='utf-8'><title>Simulation time</title>",
             "<style>body{font:15px sans-serif;max-width:70em;margin:2em auto}",
             "td,th{padding:.2em .8em;text-align:left;border-bottom:1px solid #ddd}",
             "table{font-size:13px;border-collapse:collapse}img{max-width:100%}</style>",
             "<h1>The paper's claims about simulation time</h1>",
             f"<p>{html.escape(machine('numpy', 'scipy'))}</p>"]  # fmt: skip
    for title, text, picture, table in sections:
        data = base64.b64encode(picture.read_bytes()).decode()
        head, *rows = table
        parts.append(f"<h2>{html.escape(title)}</h2><p>{html.escape(text)}</p>")
        parts.append(f"<img alt='{html.escape(title)}' src='data:image/png;base64,{data}'>")
        cells = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
        parts.append(f"<table><tr>{cells}</tr>")
        for row in rows:
            cells = "".join(f"<td>{html.escape(cell)}</td>" for cell in row)
            parts.append(f"<tr>{cells}</tr>")
        parts.append("</table>")
    target.write_text("\n".join(parts), encoding="utf-8")


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "claims")
    folder.mkdir(parents=True, exist_ok=True)
    plt.switch_backend("Agg")
    models = {
        name: bgc.compile(SOURCE, scene=name) for name in ("compliant", "rigid", "euler")
    }  # fmt: skip
    crane = models["compliant"]
    damping = curves(
        crane, DAMPING_RATIOS, lambda z: given(STIFFNESS, z), "damping ratio", "damping", folder
    )
    stiffness = curves(
        crane, STIFFNESSES, lambda k: given(k, 0.1), "stiffness [N/m]", "stiffness", folder
    )
    variants = bars(models, folder)
    sections = [
        ("Damping of the joints", "The paper damped its joints to shorten the simulation. A method"
         " for stiff oscillations, from a start with the springs under their loads, has no need"
         f" of it. Stiffness {STIFFNESS:g} N/m, rtol {RTOL:g}.", *damping),
        ("Stiffness of the joints", f"Damping ratio 0.1, rtol {RTOL:g}.", *stiffness),
        ("Compliant, rigid, Euler angles", "Springs of 1e9 N/m, critically damped, against joints"
         " that hold exactly; quaternions against the paper's Euler angles.", *variants),
    ]  # fmt: skip
    page(sections, folder / "claims.html")
    for title, _, _, table in sections:
        print(f"\n{title}")
        for row in table:
            print("  " + " | ".join(row))
    print(f"\n{folder / 'claims.html'}")


if __name__ == "__main__":
    main()
