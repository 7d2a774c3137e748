"""Estimated errors of runs over true ones, at three tolerances.

    python tests/bench/errors.py [CASE ..]

For each problem of `tests/models/ivp` and for scenes of the library: the least, middle and largest
ratio over the columns of the largest estimate to the largest true error, and how many columns have
it between 0.5 and 2; a withheld figure counts as none, and `?` marks a run whose errors are said to
be uncertain. True errors are against another method at its tightest. Both are compared at fifty
equal intervals and at steps of the runs, so that fast changes between rows count, but not beside a
jump of either, which may come a little earlier or later. Columns at rounding level, below 1e-12 of
their size, are left out.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from multiprocessing import Process, Queue
from pathlib import Path
from queue import Empty

import numpy as np
import numpy.typing as npt
from ivp import FOLDER, NOT_STIFF, SIZES

import bgc
import bgc.library
from bgc.language.solver import Solver
from bgc.runtime.running.run import run_watched
from bgc.runtime.running.simulate import method_of, simulate

Array = npt.NDArray[np.float64]

LIBRARY = Path(bgc.library.__path__[0])
SCENES = (
    "examples/two_tanks tanks", "examples/two_tanks emptying", "examples/water_hammer",
    "examples/bouncing_ball", "examples/backlash", "examples/clutch", "examples/gyroscope",
    "examples/hanging_load carousel", "examples/hanging_load crane", "examples/heated_wall",
    "examples/hydraulic_cylinder lift", "examples/motor_gearbox drive", "examples/pendulum_swing",
    "examples/pumped_swing", "examples/quarter_car over_bump", "examples/rectifier",
    "examples/stick_slip", "examples/dc_servo", "examples/wave_buoy", "scenes/planar_crane",
    "scenes/knuckle_boom", "scenes/ur5", "scenes/gantry", "scenes/excavator",
)  # fmt: skip
TOLERANCES = (1e-4, 1e-6, 1e-8)
PATIENCE = 120.0  # s, of a case
ROWS, STEPS = 51, 400  # compared: equal intervals, and steps of each run
ROUNDING = 1e-12
BESIDE = 2e-9  # of the run: rows within a billionth of a step of its end show that end
FIFTH = 0.2


def step_ends(model: bgc.Model, method: Solver, end: float) -> Array:
    """Ends of at most STEPS steps of a run."""
    ends = []
    row = np.empty((1, model.row_width))
    last = 0.0
    with model.started(method, bool(model.accounts)) as instance:
        while (time := instance.time) < end:
            beyond = max(1e-8 * (time - last), 1e-14 * time, 1e-18 * end)
            run_watched(instance, np.array([time + beyond]), row, False)
            last = time
            ends.append(min(instance.time, end))
    return np.array(ends)[:: max(1, len(ends) // STEPS)]


def beside_jumps(times: Array, values: Array) -> npt.NDArray[np.bool_]:
    """Instants at which a value that jumps may have done so or not, by rounding."""
    near = 2 * BESIDE * times[-1]
    first, last = np.searchsorted(times, times - near), np.searchsorted(times, times + near)
    spread = [np.ptp(values[a : max(b, a + 1)]) for a, b in zip(first, last, strict=True)]
    return np.array(spread) > 1e-3 * np.ptp(values)


def ratios(case: str) -> Iterator[tuple[float, Array, bool]]:
    """Tolerances with the ratios of all columns, and whether they are said to be uncertain.

    A ratio is NaN where an error is withheld.
    """
    name, _, scene = case.partition(" ")
    is_ivp = "/" not in name
    path = FOLDER / f"{name}.bg" if is_ivp else LIBRARY / f"{name}.bg"
    model = bgc.compile(path, scene=scene) if scene else bgc.compile(path)
    size = SIZES.get(name, 1.0) if is_ivp else 0.0
    fixed = method_of(model)[0].fixed
    end = model.facts.duration
    methods = [
        method_of(model, Solver() if fixed else Solver(rtol=rtol, atol=rtol * size))[0]
        for rtol in TOLERANCES[: 1 if fixed else 3]
    ]
    ends = [step_ends(model, method, end) for method in methods]
    times = np.unique(np.concatenate((np.linspace(0.0, end, ROWS), *ends)))
    if model.library.model.n_switch > 0:
        times = np.unique(np.clip((times, times - BESIDE * end, times + BESIDE * end), 0.0, end))
    tight = "dopri5" if name in NOT_STIFF else "radau5"
    exact_by = method_of(model, Solver(tight, rtol=1e-12, atol=1e-14 * size))[0]
    exact = simulate(model, exact_by, times)
    for method in methods:
        run = simulate(model, method, times, errors=True)
        compared = np.full(len(times), True)
        for each in (run, exact) if model.library.model.n_switch > 0 else ():
            for column in exact.columns:
                compared &= ~beside_jumps(times, each[column])
        found = []
        for column, estimate in run.errors.items():
            true = np.abs(run[column] - exact[column])[compared].max()
            if true > ROUNDING * np.abs(exact[column]).max():
                found.append(estimate.max() / true)
        yield method.rtol, np.array(found), run.counts["doubtful_errors"] > 0


def measure(case: str, results: Queue) -> None:
    try:
        results.put(list(ratios(case)))
    except bgc.BgError as problem:
        results.put(str(problem))


def main() -> None:
    cases = sys.argv[1:] or [*sorted(p.stem for p in FOLDER.glob("*.bg")), *SCENES]
    shares, withheld, uncertain, too_small = [], [], 0, 0
    for case in cases:
        results: Queue = Queue()
        process = Process(target=measure, args=(case, results))
        process.start()
        try:
            found = results.get(timeout=PATIENCE)
        except Empty:
            found = "too slow"
        process.terminate()
        if isinstance(found, str):
            print(f"{case:32} {found.splitlines()[0]}", flush=True)
            continue
        for rtol, all_ratios, doubtful in found:
            if not len(all_ratios):
                continue
            known = all_ratios[np.isfinite(all_ratios)]
            shares.append(float(((known >= 0.5) & (known <= 2)).sum() / len(all_ratios)))
            withheld.append(1 - len(known) / len(all_ratios))
            spread = np.percentile(known, [0, 50, 100]) if len(known) else np.full(3, np.nan)
            uncertain += doubtful
            too_small += 0 if doubtful else int((known < FIFTH).sum())
            mark = "?" if doubtful else " "
            print(f"{case:32} {rtol:5.0e} {mark}{shares[-1]:4.0%}  {spread.round(3)}", flush=True)
    print(f"between 0.5 and 2: {np.mean(shares):.1%} of the columns of {len(shares)} runs")
    print(f"withheld: {np.mean(withheld):.1%}; said to be uncertain: {uncertain} runs")
    print(f"below a fifth of the true error, and nothing said: {too_small} columns")


if __name__ == "__main__":
    main()
