"""Reductions of scenes at three requirements each: states, time side by side, and true errors.

    python tests/bench/reductions.py [FILE.csv [SCENE ..]]

`bgc reduce` finds each reduced scene without a hint, within ten minutes; `bgc trade` the cheapest
method of the whole scene for the same requirement. Then the three run in turns: the reduced scene,
the whole one with its own method, and the whole one with the method of trade. The true error of the
reduced scene, as it was written, is that against the whole scene by a method that took no part in
the reduction, at rtol 1e-10, over the rows. Rows that the file has are not measured again.
"""

from __future__ import annotations

import csv
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

import bgc
import bgc.library
from bgc.language.column_names import name_in_si
from bgc.language.solver import Solver
from bgc.runtime.measuring.timed_run import timed_run
from bgc.runtime.model import Model
from bgc.runtime.reduce.reduce import Reduction
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.run import choose_method

LIBRARY = Path(bgc.library.__path__[0])
BUDGET = 600.0  # s
ROUNDS = 5
TIGHT = 1e-10
INDEPENDENT = ("rodas4p2", "dopri5", "rodas5p", "radau5")


@dataclass(frozen=True, slots=True)
class Case:
    """A scene, the value that is required, and three requirements on it, in its unit.

    `over` are values of parameters in all of which the reduced scene has to hold.
    """

    name: str
    path: Path
    scene: str
    value: str
    within: tuple[float, ...]
    over: tuple[str, ...] = ()


CASES = (
    Case(
        "flexible_crane",
        LIBRARY / "scenes" / "flexible_crane.bg",
        "flexible_crane",
        "load",
        (0.05, 0.01, 0.001),
    ),
    Case(
        "paper's crane",
        Path(__file__).parent / "claims.bg",
        "compliant",
        "tip",
        (0.01, 1e-3, 1e-4),
    ),
    Case(
        "offshore_lift",
        LIBRARY / "scenes" / "offshore_lift.bg",
        "offshore_lift",
        "height",
        (0.2, 0.05, 0.01),
    ),
    Case(
        "offshore_lift, three seas",
        LIBRARY / "scenes" / "offshore_lift.bg",
        "offshore_lift",
        "height",
        (0.2,),
        ("vessel.sea.seed=1, 2, 3",),
    ),
    Case(
        "water_hammer",
        LIBRARY / "examples" / "water_hammer.bg",
        "water_hammer",
        "middle",
        (10.0, 6.0, 3.0),  # bar
    ),
    Case(
        "knuckle_boom_at_sea",
        LIBRARY / "scenes" / "knuckle_boom_at_sea.bg",
        "knuckle_boom_at_sea",
        "height",
        (0.1, 0.02, 0.005),
    ),
)


@dataclass(frozen=True, slots=True)
class Row:
    """A reduction: times in s, ratios of times over that of the scene that was found.

    `error` is the true one over the requirement; `study` is the time of the reduction.
    """

    scene: str
    within: float
    states: int
    of_states: int
    method: str
    run: float
    own: float
    trade: float
    claimed: float
    error: float
    study: float
    changes: str


def measured(case: Case, within: float) -> Row:
    begin = time.monotonic()
    goal = {case.value: within}
    found = bgc.reduce(
        case.path, case.scene, within=goal, over=case.over, deadline=60.0, budget=BUDGET
    )
    study = time.monotonic() - begin
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "reduced.bg"
        if found.reduced is not None:
            found.to_bg(written)
        path, scene = (written, None) if written.exists() else (case.path, case.scene)
        error = max(true_error(case, within, path, scene, each, found) for each in found.cases)
        reduced = bgc.compile(path, scene)
    whole = bgc.compile(case.path, case.scene)
    best = bgc.trade(
        case.path, case.scene, within=goal, deadline=60.0, budget=BUDGET / 4
    ).recommended
    runs = {
        "reduced": (reduced, choose_method(reduced.library, reduced.facts)),
        "own": (whole, choose_method(whole.library, whole.facts)),
    }
    if best is not None:
        runs["trade"] = (whole, best.method)
    seconds = in_turns(runs, found.duration)
    return Row(
        scene=case.name,
        within=within,
        states=found.best.states,
        of_states=found.whole.states,
        method="" if found.proof is None else found.proof.method,
        run=seconds["reduced"],
        own=seconds["own"] / seconds["reduced"],
        trade=seconds.get("trade", np.nan) / seconds["reduced"],
        claimed=found.best.error if found.proof is None else found.proof.error,
        error=error,
        study=study,
        changes=" ".join(change.statement for change in found.best.changes),
    )


def true_error(
    case: Case,
    within: float,
    path: Path,
    scene: str | None,
    values: Mapping[str, float],
    found: Reduction,
) -> float:
    """The error of the scene that was found in one case, over the requirement."""
    whole = bgc.compile(case.path, case.scene, parameters=dict(values))
    reduced = bgc.compile(path, scene, parameters=dict(values))
    name = next(name for name in INDEPENDENT if name not in found.reference.methods)
    times = np.linspace(0.0, found.duration, 2001)
    exact = rows(whole, Solver(name, rtol=TIGHT), times)
    other = rows(reduced, choose_method(reduced.library, reduced.facts), times)
    columns = [
        k
        for k, variable in enumerate(whole.measured)
        if name_in_si(variable.name).partition("[")[0] == case.value
    ]
    return float(np.max(np.abs(exact - other)[:, columns])) / within


def rows(model: Model, method: Solver, times: Array) -> Array:
    run = timed_run(model, method, times, accounts=False, limit=3600.0)
    if run.status != "done":
        raise RuntimeError(run.message)
    return run.rows


def in_turns(runs: Mapping[str, tuple[Model, Solver]], duration: float) -> dict[str, float]:
    found: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(ROUNDS):
        for name, (model, method) in runs.items():
            times = np.linspace(0.0, duration, 101)
            run = timed_run(model, method, times, accounts=False, limit=600.0)
            found[name].append(run.seconds if run.status == "done" else np.nan)
    return {name: statistics.median(seconds) for name, seconds in found.items()}


def kept(path: Path) -> Iterator[tuple[str, float]]:
    if path.exists():
        with path.open(newline="") as file:
            for row in csv.DictReader(file):
                yield row["scene"], float(row["within"])


def main(arguments: list[str]) -> None:
    path = Path(arguments[0]) if arguments else Path(__file__).with_name("reductions.csv")
    wanted, done = set(arguments[1:]), set(kept(path))
    for case in CASES:
        for within in case.within:
            if (case.name, within) in done or (wanted and case.name not in wanted):
                continue
            try:
                row = measured(case, within)
            except (bgc.BgError, RuntimeError) as problem:
                print(case.name, within, problem, file=sys.stderr)
                continue
            is_new = not path.exists()
            with path.open("a", newline="") as file:
                writer = csv.DictWriter(file, [field.name for field in fields(Row)])
                if is_new:
                    writer.writeheader()
                writer.writerow(asdict(row))
            print(row)


if __name__ == "__main__":
    main(sys.argv[1:])
