"""Work and precision of the methods on published problems: the slope of error against tolerance.

    python tests/bench/ivp.py [--out FOLDER] [PROBLEM ..]

For each problem of `tests/models/ivp` with reference values and each method, the error at the end
for tolerances from 1e-3 to 1e-10, the slope of log error over log tolerance (1: the error is in
proportion to the tolerance) and the time. `--out` also draws a work-precision diagram.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import numpy.typing as npt

import bgc

FOLDER = Path(__file__).parents[1] / "models" / "ivp"
REFERENCES = json.loads((FOLDER / "references.json").read_text())
METHODS = ("rodas5p", "rodas4p2", "radau5", "dopri5")
NOT_STIFF = {
    "pleiades", "arenstorf", "five_bodies", "euler_pulse",
    "detest_f1", "detest_f2", "detest_f3", "detest_f4",
}  # fmt: skip
TOLERANCES = 10.0 ** np.arange(-3, -11, -1)
REPEATS = 3  # the least time counts
# What the states amount to where that is not 1: atol is so much of rtol.
SIZES = {
    "robertson": 1e-9, "e5": 1e-17, "hires": 1e-3, "pollution": 1e-2, "chemical_akzo": 1e-2,
    "stiff_pendulum": 1e-2, "plate": 1e-3, "ring_modulator": 1e-4, "robertson_dae": 1e-5,
    "reactor": 1e-4, "detest_f4": 1e-9,
}  # fmt: skip

Curve = npt.NDArray[np.float64]


def measure(name: str, solver: str) -> tuple[Curve, Curve, list[int]]:
    """Errors relative to the largest reference of their kind, seconds, steps, by tolerance."""
    model = bgc.compile(FOLDER / f"{name}.bg")
    end = REFERENCES[name]["end"]
    exact = np.array(list(end.values()))
    size = np.abs(exact) + SIZES.get(name, 1.0)
    errors, seconds, steps = [], [], []
    for rtol in TOLERANCES:
        try:
            atol = rtol * SIZES.get(name, 1.0)
            runs = [
                model.simulate(solver=solver, rtol=rtol, atol=atol, error=False)
                for _ in range(REPEATS)
            ]
        except bgc.SimulationError:
            errors.append(np.nan)
            seconds.append(np.nan)
            steps.append(0)
            continue
        found = np.array([runs[0][column][-1] for column in end])
        errors.append(float((np.abs(found - exact) / size).max()))
        seconds.append(min(run.counts["run_seconds"] for run in runs))
        steps.append(int(runs[0].counts["steps"]))
    return np.array(errors), np.array(seconds), steps


def slope(errors: Curve) -> float:
    """Slope of log error over log tolerance, where the error is above rounding."""
    good = np.isfinite(errors) & (errors > 1e-13)
    if good.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(TOLERANCES[good]), np.log(errors[good]), 1)[0])


def draw(name: str, curves: dict[str, tuple[Curve, Curve]], target: Path) -> None:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6, 4.5))
    for solver, (errors, seconds) in curves.items():
        axes.loglog(seconds * 1e3, errors, "o-", label=solver)
    axes.set(xlabel="time [ms]", ylabel="error at the end", title=name)
    axes.grid(alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(target)
    plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("problems", nargs="*", default=[*REFERENCES], metavar="PROBLEM")
    parser.add_argument("--out", type=Path, help="draw a diagram of each problem there")
    options = parser.parse_args()
    print(f"{'problem':22}{'method':10}{'slope':>6}  error (steps, ms) at 1e-4, 1e-7, 1e-10")
    for name in options.problems:
        curves = {}
        for solver in METHODS:
            if solver == "dopri5" and name not in NOT_STIFF:
                continue
            errors, seconds, steps = measure(name, solver)
            curves[solver] = errors, seconds
            cells = [f"{errors[k]:8.1e} ({steps[k]}, {seconds[k] * 1e3:.3g})" for k in (1, 4, 7)]
            print(f"{name:22}{solver:10}{slope(errors):6.2f}  {'  '.join(cells)}", flush=True)
        if options.out is not None:
            options.out.mkdir(parents=True, exist_ok=True)
            draw(name, curves, options.out / f"{name}.png")


if __name__ == "__main__":
    main()
