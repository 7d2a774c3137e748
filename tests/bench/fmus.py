"""FMUs of all scenes of the library: `python tests/bench/fmus.py [NAMES] [--csv FILE]`.

Each scene is exported in FMI 2 and 3, validated by FMPy, and driven by it, in a process of its own.
The columns:

problems    of `fmpy validate`
cs          Co-Simulation against a run: the largest difference of all outputs and rows as a part of
            the range of the output, without energy.residual, a difference of energies that is
            rounding itself; a row at an event that rounding moves counts too. With a device each
            output is compared with the row of the sample before too, and the nearer one counts.
cs median   the median over the outputs of the same
steps       whether communication steps of 1/1, 1/3 and 1/7 of an interval give the same bits
            (scenes with devices: their inputs change at samples, and so do these steps)
rollback    whether a restored instance continues with the same bits, the serialised one too
me          Model Exchange by CVode at 1e-8 against Co-Simulation, median over the outputs
built       `fmpy compile`: the sources built by CMake, against the binary of the archive (FMI 3 and
            sources below 1 MB; all with --build, which takes twice as long)

`fmus.csv` beside this file holds recorded rows; a scene without one was not measured.

Devices are replayed: what the scene's drivers gave to the run at each sample is the FMU's input.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

LIBRARY = Path(__file__).parents[2] / "library"
FIELDS = ("scene", "version", "problems", "cs", "cs median", "steps", "rollback", "me", "built",
          "seconds")  # fmt: skip
ME_SECONDS = 40  # for CVode
LIMIT = 600  # s a scene, by default


def scenes() -> Iterator[tuple[Path, str]]:
    """Files of the library with the names of their scenes."""
    from bgc.resolution.resolve import load

    for path in sorted([*LIBRARY.glob("scenes/*.bg"), *LIBRARY.glob("examples/*.bg")]):
        for scene in load(path).scene_names:
            yield path, scene


# --- one FMU ----------------------------------------------------------------------------------


@dataclass
class Unit:
    """An unpacked FMU: references of its outputs, and its inputs at samples.

    `sizes` are the numbers behind each reference. `period` is 0 without a device. `fed` are the
    first inputs of the model; values that sampled parts hold follow them there.
    """

    folder: str
    description: Any
    outputs: list[int]
    sizes: list[int]
    inputs: list[int]
    period: float
    fed: np.ndarray  # (samples, inputs)

    @property
    def three(self) -> bool:
        return bool(self.description.fmiVersion.startswith("3"))

    def opened(self) -> Any:
        """An initialised instance for Co-Simulation."""
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave

        fmu = (FMU3Slave if self.three else FMU2Slave)(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        fmu.instantiate()
        self.feed(fmu, 0)
        if self.three:
            fmu.enterInitializationMode(startTime=0.0)
        else:
            fmu.setupExperiment(startTime=0.0)
            fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        return fmu

    def feed(self, fmu: Any, sample: int) -> None:
        """Set the inputs that the devices gave at a sample."""
        if self.period:
            values = self.fed[min(sample, len(self.fed) - 1)].tolist()
            (fmu.setFloat64 if self.three else fmu.setReal)(self.inputs, values)

    def row(self, fmu: Any) -> list[float]:
        """The outputs."""
        if self.three:
            return list(fmu.getFloat64(self.outputs, nValues=sum(self.sizes)))
        return list(fmu.getReal(self.outputs))

    def advance(self, fmu: Any, start: float, end: float, parts: int) -> None:
        """Step from one time to another, with new inputs at the samples between them."""
        if self.period:
            first, last = round(start / self.period), round(end / self.period)
            for k in range(first, last):
                self.feed(fmu, k)
                fmu.doStep(k * self.period, self.period)
        else:
            times = np.linspace(start, end, parts + 1)
            for t, after in pairwise(times):
                fmu.doStep(float(t), float(after - t))

    def rows(self, times: np.ndarray, parts: int = 1) -> np.ndarray:
        """The outputs at times."""
        fmu = self.opened()
        found = [self.row(fmu)]
        for start, end in pairwise(times):
            self.advance(fmu, float(start), float(end), parts)
            found.append(self.row(fmu))
        fmu.freeInstance()
        return np.array(found)

    def rolls_back(self, times: np.ndarray) -> bool:
        """Return whether restored instances, also from serialised bytes, continue equally."""
        fmu = self.opened()
        half = len(times) // 2
        for start, end in pairwise(times[: half + 1]):
            self.advance(fmu, float(start), float(end), 1)
        state = (fmu.getFMUState if self.three else fmu.getFMUstate)()
        saved = (fmu.serializeFMUState if self.three else fmu.serializeFMUstate)(state)
        end = times[min(half + 20, len(times) - 1)]
        found = []

        def go(fmu: Any) -> None:
            self.advance(fmu, float(times[half]), float(end), 3)
            found.append(self.row(fmu))

        go(fmu)
        (fmu.setFMUState if self.three else fmu.setFMUstate)(state)
        go(fmu)
        other = self.opened()
        read = other.deserializeFMUState if self.three else other.deSerializeFMUstate
        (other.setFMUState if self.three else other.setFMUstate)(read(saved))
        go(other)
        fmu.freeInstance()
        other.freeInstance()
        return found[0] == found[1] == found[2]


@dataclass
class Run:
    """A run of a scene: its rows at times, and the inputs that devices gave at samples.

    `late` are the rows of the samples before: an FMU answers an input after its next step, so an
    output that follows an input at once is one sample late. `period` is 0 without a device.
    """

    times: np.ndarray
    rows: np.ndarray
    late: np.ndarray
    period: float
    fed: np.ndarray


def native(path: Path, scene: str) -> Run:
    """Run a scene, with its devices."""
    import bgc
    from bgc.runtime.running.run import with_capped_step
    from bgc.runtime.running.simulate import method_of, times_of
    from bgc.runtime.running.structures import Status

    model = bgc.compile(path, scene)
    method, _ = method_of(model)
    times = times_of(model, method)
    method = with_capped_step(method, times, model.facts.timed)
    with model.started(method, bool(model.accounts)) as instance:
        rows = np.full((len(times), model.row_width), np.nan)
        if not model.library.model.n_device:
            status, _ = instance.run(times, rows)
            assert status is Status.OK, status
            return Run(times, rows, rows, 0.0, np.zeros((0, 0)))
        period, fed, late = instance.sample_period, [], np.copy(rows)
        row = np.full((1, model.row_width), np.nan)
        place = {round(float(t) / period): k for k, t in enumerate(times)}
        for k in range(round(float(times[-1]) / period) + 1):
            before = np.copy(row[0])
            status, _ = instance.run(np.array([k * period]), row)
            assert status is Status.OK, status
            fed.append(instance.input.copy())
            if k in place:
                rows[place[k]] = row[0]
                late[place[k]] = before if k else row[0]
    return Run(times, rows, late, period, np.array(fed))


def exported(
    path: Path, scene: str, version: int, folder: Path
) -> tuple[Path, Any, list[int], list[int]]:
    """Write an FMU: its path, table, the columns of its outputs in a run, the residual."""
    from bgc.options import Options
    from bgc.runtime.fmi.binaries import read_platforms
    from bgc.runtime.fmi.export import fmu_files
    from bgc.runtime.fmi.fmu_model import prepare_model
    from bgc.runtime.results.files import write_files

    model = prepare_model(path, Options(scene), version)
    (fmu, *_) = write_files(folder, fmu_files(model, read_platforms(None)))
    measured = len(model.loaded.measured)
    columns = [
        v.index if v.kind == "output" else measured + v.index
        for v in model.table.listed
        if v.causality == "output" and v.kind in ("output", "account")
    ]
    residual = [k for k, column in enumerate(columns) if column == measured + 3]
    return fmu, model.table, columns, residual


def unit_of(fmu: Path, table: Any, folder: Path, run: Run) -> Unit:
    """Unpack an FMU, which gets the inputs of a run."""
    import fmpy

    from bgc.runtime.fmi.fmu_variables import arrays_of

    unpacked = fmpy.extract(str(fmu), unzipdir=str(folder))
    description = fmpy.read_model_description(unpacked)
    three = description.fmiVersion.startswith("3")
    groups = {
        kinds: [
            (a.variable.reference, len(a.components))
            for a in arrays_of(table)
            if a.variable.kind in kinds and a.variable.causality in ("input", "output")
        ]
        if three
        else [
            (v.reference, 1)
            for v in table.listed
            if v.kind in kinds and v.causality in ("input", "output")
        ]
        for kinds in (("output", "account"), ("input",))
    }
    outputs, inputs = groups["output", "account"], groups[("input",)]
    return Unit(unpacked, description, [r for r, _ in outputs], [n for _, n in outputs],
                [r for r, _ in inputs], run.period,
                run.fed[:, : sum(n for _, n in inputs)])  # fmt: skip


def differences(found: np.ndarray, wanted: np.ndarray, left_out: list[int]) -> np.ndarray:
    """The largest difference of each column as a part of its range.

    A column that rests but for rounding, 1e-9 of its value, counts by its value.
    """
    if not wanted.size:
        return np.zeros(1)
    size = np.abs(wanted).max(axis=0)
    span = np.ptp(wanted, axis=0)
    span = np.where(span < 1e-9 * size, size, span)
    found = np.abs(found - wanted).max(axis=0) / np.maximum(span, 1e-300)
    return found[[k for k in range(len(found)) if k not in left_out] or slice(None)]


def model_exchange(unit: Unit, times: np.ndarray, wanted: np.ndarray, left_out: list[int]) -> str:
    """CVode at 1e-8 against rows; FMPy takes its inputs from a table, so devices are left out."""
    import fmpy

    if unit.period:
        return "-"
    names = {v.valueReference: v.name for v in unit.description.modelVariables}
    found = fmpy.simulate_fmu(
        unit.folder,
        fmi_type="ModelExchange",
        relative_tolerance=1e-8,
        stop_time=float(times[-1]),
        output_interval=float(times[1] - times[0]),
        output=[names[r] for r in unit.outputs],
        record_events=False,
        timeout=ME_SECONDS,
    )
    if len(found) < len(times):
        return f"{found['time'][-1] / times[-1]:.0%} in {ME_SECONDS} s"
    columns = [found[names[r]].reshape(len(found), -1) for r in unit.outputs]
    rows = np.hstack(columns)[: len(times)]
    return f"{np.median(differences(rows, wanted, left_out)):.0e}"


def compiled(unit: Unit) -> None:
    """Build the sources by CMake as `fmpy compile` does, in place of the binary."""
    import fmpy.build

    with tempfile.TemporaryDirectory() as work:
        real = subprocess.check_call
        subprocess.check_call = _quietly  # type: ignore[assignment]
        try:
            for binary in Path(unit.folder).glob("binaries/*/*"):
                binary.unlink()
            fmpy.build.build_platform_binary(unit.folder, work)
        finally:
            subprocess.check_call = real


def _quietly(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = (done.stdout + done.stderr).splitlines()
        raise RuntimeError(" ".join([f"{command[0]} ended with {done.returncode}:", *lines[-4:]]))


def measure(
    path: Path, scene: str, work: Path, versions: tuple[int, ...], build: bool
) -> Iterator[dict[str, str]]:
    """The rows of one scene."""
    from fmpy.validation import validate_fmu

    run = native(path, scene)
    times = run.times
    for version in versions:
        begun = time.process_time()
        fmu, table, columns, residual = exported(path, scene, version, work / f"fmi{version}")
        unit = unit_of(fmu, table, work / f"unpacked{version}", run)
        found = unit.rows(times)
        parts = np.minimum(
            differences(found, run.rows[:, columns], residual),
            differences(found, run.late[:, columns], residual),
        )
        least = min(len(times), 21)
        same = all(np.array_equal(unit.rows(times[:least], n), found[:least]) for n in (3, 7))
        row = {
            "scene": f"{path.stem}.{scene}",
            "version": str(version),
            "problems": str(len(validate_fmu(str(fmu)))),
            "cs": f"{parts.max():.0e}",
            "cs median": f"{np.median(parts):.0e}",
            "steps": "-" if run.period else "equal" if same else "DIFFER",
            "rollback": "equal" if unit.rolls_back(times) else "DIFFERS",
            "me": guarded(lambda: model_exchange(unit, times, found, residual)),  # noqa: B023
        }

        def again() -> str:
            compiled(unit)  # noqa: B023
            return f"{differences(unit.rows(times), found, residual).max():.0e}"  # noqa: B023

        size = sum(f.stat().st_size for f in Path(unit.folder).glob("sources/*.c"))
        wants = (version == 3 and size < 1_000_000) or build
        yield row | {
            "built": guarded(again) if wants else "-",
            "seconds": f"{time.process_time() - begun:.0f}",
        }


def guarded(call: Callable[[], str]) -> str:
    """A cell, or the reason that it is missing."""
    try:
        return call()
    except Exception as problem:
        return f"FAILED {type(problem).__name__}: {str(problem)[:200]}"


# --- all scenes -------------------------------------------------------------------------------


def main() -> None:
    """Print a table of all scenes, or of those whose names contain one of NAMES."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--csv", type=Path, help="append the rows to a file; scenes in it are done")
    parser.add_argument("--version", type=int, choices=(2, 3), help="of FMI; by default both")
    parser.add_argument("--build", action="store_true", help="build the sources of FMI 2 too")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds that a scene may take")
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    versions = (given.version,) if given.version else (2, 3)
    if given.one:
        path, scene = Path(given.one[0]), given.one[1]
        with tempfile.TemporaryDirectory() as work:
            for row in measure(path, scene, Path(work), versions, given.build):
                write_row(sys.stdout, row)
        return
    write_row(sys.stdout, dict(zip(FIELDS, FIELDS, strict=True)))
    done_before = given.csv.read_text() if given.csv and given.csv.exists() else ""
    for path, scene in scenes():
        name = f"{path.stem}.{scene}"
        if given.names and not any(part in name for part in given.names):
            continue
        if f"{name}," in done_before:
            continue
        command = [sys.executable, __file__, "--one", str(path), scene]
        command += ["--build"] * given.build
        command += ["--version", str(given.version)] if given.version else []
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=given.limit)
            text, failed = done.stdout, done.returncode != 0
            reason = done.stderr.strip().splitlines()[-1:] if failed else []
        except subprocess.TimeoutExpired as late:
            text, reason = (late.stdout or b"").decode(), [f"more than {given.limit:g} s"]
        if reason:
            text += f"{name},,FAILED: {' '.join(reason)}\n"
        sys.stdout.write(text)
        sys.stdout.flush()
        if given.csv:
            with given.csv.open("a") as file:
                file.write(text)


def write_row(file: Any, row: dict[str, str]) -> None:
    """Write one row as CSV."""
    csv.DictWriter(file, FIELDS, lineterminator="\n").writerow(row)
    file.flush()


if __name__ == "__main__":
    main()
