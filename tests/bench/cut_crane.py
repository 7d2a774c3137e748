"""The hydraulic crane cut in two: mechanism and oil as FMUs of ours, in co-simulation by FMPy.

`python tests/bench/cut_crane.py [SECONDS]`. Both FMUs are written by `bgc build --target fmu2` and
step by themselves with ros23 at 1 ms or the communication step, whichever is less. Each holds
what the other gave at the last communication point (Jacobi), or the mechanism takes the forces of
the new point (Gauss-Seidel). Errors are those of the strokes against the crane as one model by
rodas5p at 1e-9; the row of the one model is ros23 at 1 ms. Times are processor times of all that
runs, FMPy included. The published pair of FMUs of this crane (libcosim, tests/data/fmi2)
diverges at 0.2 ms and above. Measured over 15 s (2 shared cores, a load of 10 to 20):

| communication step | Jacobi: error, ends at, cost | Gauss-Seidel: error, cost |
|---|---|---|
| 10 ms | diverges, 0.2 s | 0.33 mm, 0.016 s/s |
| 5 ms | diverges, 0.25 s | 0.16 mm, 0.021 s/s |
| 2 ms | diverges, 0.5 s | 0.065 mm, 0.035 s/s |
| 1 ms | diverges, 1.1 s | 0.033 mm, 0.045 s/s |
| 0.5 ms | diverges, 3.5 s | 0.018 mm, 0.09 s/s |
| 0.2 ms | 0.012 mm, 0.23 s/s | 0.007 mm, 0.26 s/s |
| 0.1 ms | 0.005 mm, 0.53 s/s | 0.004 mm, 0.53 s/s |
| one model, 1 ms | 0.0013 mm, 0.005 s/s | |

A force that is a step late pumps energy into the spring of the oil; the first order of the error
stays in any case. So the one model is 25 times as exact as the best pair at its step of 1 ms, and
takes a ninth of its time.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import run

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

import bgc

HERE = Path(__file__).parent
DURATION = 15.0
STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
LIMIT = 100.0  # seconds of processor time for a row


def built(folder: Path, scene: str, given: str, *options: str) -> Path:
    """FMU of a scene of cut_crane.bg."""
    command = ("bgc", "build", HERE / "cut_crane.bg", "--scene", scene, "--target", "fmu2")
    run((*command, "--input", given, "-o", folder, *options), check=True, capture_output=True)
    return folder / f"cut_crane_{scene}.fmu"


class Part:
    """One FMU in co-simulation: its input and outputs as vectors."""

    def __init__(self, path: Path, folder: Path, given: str, taken: tuple[str, ...]):
        description = fmpy.read_model_description(path)
        numbers = {v.name: v.valueReference for v in description.modelVariables}
        self.given = [numbers[f"{given}[{k}]"] for k in (1, 2, 3)]
        self.taken = [numbers[name] for name in taken]
        self.slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=fmpy.extract(path, folder),
            instanceName=given,
        )
        self.slave.instantiate()

    def start(self, values: np.ndarray) -> None:
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.give(values)
        self.slave.exitInitializationMode()

    def give(self, values: np.ndarray) -> None:
        self.slave.setReal(self.given, list(values))

    def take(self) -> np.ndarray:
        return np.array(self.slave.getReal(self.taken))

    def advance(self, at: float, step: float) -> None:
        self.slave.doStep(currentCommunicationPoint=at, communicationStepSize=step)


@contextmanager
def parts(mechanism: Path, oil: Path) -> Iterator[tuple[Part, Part]]:
    with tempfile.TemporaryDirectory() as name:
        rates = ("rate[1]", "rate[2]", "rate[3]", "stroke[1]", "stroke[2]")
        forces = ("force[1]", "force[2]", "force[3]")
        pair = (
            Part(mechanism, Path(name) / "mechanism", "force", rates),
            Part(oil, Path(name) / "oil", "rate", forces),
        )
        try:
            yield pair
        finally:
            for part in pair:
                part.slave.freeInstance()


def cut(
    mechanism: Path, oil: Path, step: float, seidel: bool, duration: float
) -> tuple[np.ndarray, str]:
    """Strokes every 10 ms, and how the run ended."""
    count, every = round(duration / step), max(round(0.01 / step), 1)
    rows: list[np.ndarray] = []
    begun = time.process_time()
    with parts(mechanism, oil) as (body, drive):
        drive.start(np.zeros(3))
        force = drive.take()
        body.start(force)
        state = body.take()
        rows.append(state[3:])
        for k in range(count):
            at = k * step
            try:
                drive.give(state[:3])
                drive.advance(at, step)
                force = drive.take()
                if not seidel:
                    body.advance(at, step)
                    body.give(force)
                else:
                    body.give(force)
                    body.advance(at, step)
            except fmpy.fmi1.FMICallException as failed:
                return np.array(rows), f"ends at {at:.3f} s: {failed}"
            state = body.take()
            if not np.isfinite(state).all() or not np.isfinite(force).all():
                return np.array(rows), f"NaN at {at:.3f} s"
            if np.abs(state[3:]).max() > 10:
                return np.array(rows), f"diverges at {at:.3f} s"
            if (k + 1) % every == 0:
                rows.append(state[3:])
            if time.process_time() - begun > LIMIT:
                return np.array(rows), f"stopped at {at:.3f} s after {LIMIT:.0f} s"
    return np.array(rows), ""


def report(name: str, found: np.ndarray, truth: np.ndarray, spent: float, note: str = "") -> None:
    """Print one row; found and truth are strokes every 10 ms."""
    shared = min(len(found), len(truth))
    error = 1e3 * np.abs(found[:shared] - truth[:shared]).max()
    passed = max(shared - 1, 1) * 0.01
    print(f"{name:28} {error:10.4g} mm {spent / passed:10.4g} s/s  {note}", flush=True)


def main(duration: float = DURATION) -> None:
    """Print the error and the processor time of one model and of the cut pair."""
    model = bgc.compile(HERE / "cut_crane.bg", scene="cut_nowhere")
    given = {"every": 0.01, "start": "given"}  # as FMUs start: without a search for rest
    reference = model.simulate(duration, solver="rodas5p", rtol=1e-9, error=False, **given)
    truth = reference["stroke"]
    loads = [reference[name][0] for name in ("boom_force", "jib_force")]
    print(f"{'communication step':28} {'stroke':>13} {'processor':>14}")
    begun = time.process_time()
    found = model.simulate(duration, error=False, **given)["stroke"]
    report("one model, ros23 1 ms", found, truth, time.process_time() - begun)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mechanism = built(folder, "cut_mechanism", "force")
        sets = [x for k, load in enumerate(loads, 1) for x in ("--set", f"load0[{k}]={load} N")]
        oil = built(folder, "cut_hydraulics", "rate", *sets)
        for seidel in (False, True):
            for step in STEPS:
                begun = time.process_time()
                found, note = cut(mechanism, oil, step, seidel, duration)
                spent = time.process_time() - begun
                label = f"cut, {'Gauss-Seidel' if seidel else 'Jacobi'}, {1e3 * step:g} ms"
                report(label, found, truth, spent, note)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else DURATION)
