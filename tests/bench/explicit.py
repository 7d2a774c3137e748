"""Compare explicit methods with the default, in runs that advise one.

`python tests/bench/explicit.py [NAME ..]` runs the scenes of the library, the published problems
and the models of the tests by the default method at three tolerances (fixed steps: at the scene's).
It prints those whose summary advises an explicit method: its time relative to that of the run, the
least of three each, and both errors against `rodas5p` at 1e-10, relative to the range of each
quantity; with `--all` also the others. It also prints each run that warns of rounding (BG731).
"""

from __future__ import annotations

import sys

from measured_models import error_of, models, scenes

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.model import Model
from bgc.runtime.results.result import Result

FOLDERS = ("library/scenes", "library/examples", "tests/models/ivp", "tests/models")
REPEATS = 3


def timed(model: Model, duration: float, **options: object) -> tuple[Result, float]:
    """A run, and the least time of several."""
    runs = [model.simulate(duration, error=False, **options) for _ in range(REPEATS)]
    return runs[0], min(run.counts["run_seconds"] for run in runs)


def examine(name: str, model: Model, duration: float, everything: bool) -> None:
    """Print what a scene advises at each tolerance, and whether that is right."""
    fixed = model.facts.step is not None and model.facts.solver != "rodas5p"
    for rtol in (None,) if fixed else (1e-4, 1e-6, 1e-9):
        try:
            run, seconds = timed(model, duration, rtol=rtol)
        except BgError as problem:
            print(f"{name}: {problem.diagnostics[0].code}")
            return
        label = f"{name} {run.solver} {'' if rtol is None else f'{rtol:g}'}"
        if any(warning.code == "BG731" for warning in run.warnings):
            print(f"{label}: BG731")
        if not run.faster and not everything:
            continue
        counts = run.counts
        told = f"{label}: {counts['steps']:.0f} steps, {counts['controlled_steps']:.0f} wanted, "
        told += f"{counts['stiffness'] / 3:.3g} for stability"
        if not run.faster:
            print(told)
            continue
        try:
            other, others = timed(model, duration, rtol=rtol, solver=run.faster)
            reference = model.simulate(duration, solver="rodas5p", rtol=1e-10, error=False)
        except BgError as problem:
            print(f"{told}; {run.faster} FAILS: {problem.diagnostics[0].code}")
            continue
        errors = [error_of(each, reference) for each in (run, other)]
        print(
            f"{told}; {run.faster}: {other.counts['steps']:.0f} steps, {others / seconds:.2f} of "
            f"the time, error {errors[1]:.1e} for {errors[0]:.1e}",
            flush=True,
        )


def main(arguments: list[str]) -> None:
    everything = "--all" in arguments
    chosen = [text for text in arguments if text != "--all"]
    for name, model, duration in models(scenes(FOLDERS), chosen):
        examine(name, model, duration, everything)


if __name__ == "__main__":
    main(sys.argv[1:])
