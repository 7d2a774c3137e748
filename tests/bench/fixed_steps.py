"""Fixed steps over all scenes of the library: which method, whole or divided, is the best default?

`python tests/bench/fixed_steps.py [SCENE ..]`, `laws` for the laws alone. Every scene runs with the
step that it gives, or with a 2,000th of its run, by each method whole and with 8 sub-steps, and by
`rodas5p` at 1e-9 for reference. The error is the largest over the observed quantities, relative to
the range of each; the residual is that of the energies, relative to the largest account; the time
is relative to that of the whole `ros34prw`, the least of three runs. Two scalar laws show which
method rings where:

- a slope that jumps, x' = 1 - z max(x, 0) in steps of 1 (a relief valve, an end stop): the least z
  for which x is thrown back and forth for ever;
- a turbulent orifice, x' = -k x/sqrt(abs(x)) for large k: x after one step from 1.

Nothing of this is a test.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.model import Model
from bgc.runtime.results.result import Result

ROOT = Path(__file__).parents[2]
LONGEST = 20.0  # s of a scene that are run
STEPS = 2000  # where a scene gives no step
SUBSTEPS = 8
METHODS = ("ros34prw", "rodas23w", "ros23", "lie")
OTHERS = ("midpoint", "gauss4", "rk4", "heun")
SCENES = (
    ("library/scenes/planar_crane.bg", ("planar", "planar_rigid")),
    ("library/scenes/two_beam_crane.bg", ("two_beam_crane", "telescopic", "elevation_force")),
    ("library/examples/hanging_load.bg", ("pendulum", "carousel", "crane", "rigid")),
    ("library/examples/hydraulic_cylinder.bg", ("closed", "lift", "servo")),
    ("library/examples/motor_gearbox.bg", ("motor", "rigid", "drive")),
    ("library/examples/quarter_car.bg", ("over_bump", "on_track", "matrices")),
    ("library/examples/two_tanks.bg", ("emptying", "tanks")),
    ("tests/models/valve_cylinder.bg", ("out_and_in",)),
)


@dataclass(frozen=True)
class Measured:
    """A way to run a scene, and its result."""

    label: str
    error: float
    residual: float
    seconds: float
    counts: dict[str, float]


def error_of(result: Result, reference: Result) -> float:
    """The largest error over the quantities, relative to their ranges."""
    worst = 0.0
    for name in reference:
        if name in reference.accounts.values():
            continue
        spread = float(np.ptp(reference[name]))
        if spread > 1e-9 * float(np.abs(reference[name]).max()):
            worst = max(worst, float(np.abs(result[name] - reference[name]).max()) / spread)
    return worst


def residual_of(result: Result) -> float:
    """The largest energy residual over the energy exchanged."""
    column = result.accounts.get("residual")
    exchanged = result.counts["exchanged"]
    return float(np.abs(result[column]).max()) / exchanged if column and exchanged else np.nan


def ways() -> Iterator[tuple[str, dict[str, object]]]:
    """Label and options of each way to run a scene."""
    for method in METHODS:
        if method == "lie":  # it has no error estimate
            yield method, {"solver": method}
            continue
        yield method, {"solver": method, "substeps": 1}
        yield f"{method} / {SUBSTEPS}", {"solver": method, "substeps": SUBSTEPS}


def measure(model: Model) -> list[Measured]:
    """Run a scene in every way."""
    facts = model.facts
    duration = min(facts.duration or 1.0, LONGEST)
    step = facts.step or duration / STEPS
    reference = model.simulate(duration, solver="rodas5p", rtol=1e-9, error=False)
    found = []
    for label, options in ways():
        runs: list[Result] = []
        for _ in range(3):
            try:
                runs.append(model.simulate(duration, step=step, error=False, **options))
            except BgError as problem:
                print(f"  {label}: {problem.diagnostics[0].message}")
                break
        if runs:
            seconds = min(run.counts["run_seconds"] for run in runs)
            run = runs[0]
            found.append(Measured(label, error_of(run, reference), residual_of(run), seconds,
                                  dict(run.counts)))  # fmt: skip
    return found


def table(name: str, found: list[Measured]) -> None:
    """Print the ways to run a scene."""
    base = next(way.seconds for way in found if way.label == METHODS[0])
    print(f"\n{name}")
    print(f"  {'':14} {'error':>9} {'residual':>9} {'time':>6}  divided  most  beyond")
    for way in found:
        counts = way.counts
        print(
            f"  {way.label:14} {way.error:9.1e} {way.residual:9.1e} {way.seconds / base:6.2f} "
            f" {counts['subdivided']:7.0f} {counts['most_attempts']:5.0f} "
            f"{counts['over_budget']:7.0f}"
        )


def rings_from(model: Model, options: dict[str, object]) -> str:
    """The least slope z at which a knee makes steps ring, or the code of the failure there."""
    for z in np.geomspace(1.0, 1e4, 81):
        try:
            run = model.simulate(parameters={"z": float(z)}, error=False, **options)
        except BgError as problem:
            return f"{problem.diagnostics[0].code} from {z:.3g}"
        if not np.ptp(run["x"][-50:]) < 1e-3:
            return f"{z:.3g}"
    return "never"


def laws() -> None:
    """Print where each method rings."""
    file = ROOT / "tests/models/ringing.bg"
    knee, orifice = (bgc.compile(file, scene=name) for name in ("knee", "orifice"))
    print(f"\n  {'':14} {'slope jump':>16} {'orifice':>9}")
    for label, options in (*ways(), *((name, {"solver": name}) for name in OTHERS)):
        try:
            left = f"{orifice.simulate(error=False, **options)['x'][-1]:.2g}"
        except BgError as problem:
            left = problem.diagnostics[0].code
        print(f"  {label:14} {rings_from(knee, options):>16} {left:>9}")


def main(chosen: list[str]) -> None:
    for file, scenes in SCENES:
        for scene in scenes:
            name = f"{Path(file).stem}: {scene}"
            if not chosen or any(text in name for text in chosen):
                table(name, measure(bgc.compile(ROOT / file, scene=scene)))
    if not chosen or "laws" in chosen:
        laws()


if __name__ == "__main__":
    main(sys.argv[1:])
