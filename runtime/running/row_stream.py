"""A run whose rows go to a file while it goes on, in constant memory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from shutil import disk_usage
from time import monotonic
from typing import Final, TextIO

import numpy as np

from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.machine import cannot_write, rows_not_written, unknown_file_kind
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.kept_rows import MOST_VALUES, KeptRows
from bgc.runtime.results.npz_rows import NpzRows
from bgc.runtime.results.recorded_shapes import shape_arrays
from bgc.runtime.results.rest_report import AtRest
from bgc.runtime.results.result import Result
from bgc.runtime.results.row_files import MOST_ROWS, CsvRows, RowArray, RowFile
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.device_drivers import NO_CHOICES, Choices
from bgc.runtime.running.failures import RunInterrupted, SimulationError
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.running.rows import RowTimes
from bgc.runtime.running.run import watched, with_capped_step
from bgc.runtime.running.run_warnings import start_warnings
from bgc.runtime.running.sensitivities import Direction
from bgc.runtime.running.simulate import (
    TOO_MANY_ROWS,
    bare_result,
    lazy_times_of,
    named_result,
    raise_where_ended,
    simulate,
    times_of,
    undecided_state,
    with_requirements,
)
from bgc.runtime.running.structures import Status
from bgc.runtime.running.subtolerance import undecided

FILES: Final = (".csv", ".npz", ".zarr")

_FIRST = 1 << 10  # rows of the first block
_BLOCK_VALUES = 1 << 19  # numbers of a block
_QUICK = 0.25  # s; a block that takes less is followed by one of twice its rows
_ENDLESS = 2.0**60  # bytes


def simulate_to(
    target: Path | TextIO,
    model: LoadedModel,
    method: Solver,
    duration: float | None,
    every: float | None,
    parameters: Mapping[str, ParameterValue],
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
    devices: Choices = NO_CHOICES,
    errors: bool = False,
    directions: Sequence[Direction] = (),
) -> Result:
    """Run a model as `simulate` does, and write all rows to a file.

    Rows that fit in memory are written after the run, whole or not at all, and the result has all
    of them. Others are written while the run goes on, by the thread that computes them; the result
    then has a selection of them. External solvers cannot pause, so all of their rows are held in
    memory; so are those of a run that is differentiated. Their errors are not estimated, nor
    written.

    Raises what `simulate` raises; BgError BG055 where the file cannot be written; SimulationError
    BG590 where that happens during the run. An OSError of a stream passes.
    """
    columns = model.row_width
    times = lazy_times_of(model, method, duration, every, _room(target))
    few = len(times) * (columns + 1) <= MOST_VALUES
    if few or directions or not _can_grow(target):
        in_memory = times_of(model, method, duration, every, 1 + len(directions))
        common = (parameters, progress, notices, devices, errors, directions)
        return _write_after(target, partial(simulate, model, method, in_memory, *common))
    capped = with_capped_step(method, times, model.facts.timed)
    kept = KeptRows(len(times), columns)
    at_rest: list[AtRest] = []
    begun = model.started(capped, bool(model.accounts), parameters, at_rest.append, devices)
    with begun as instance:
        notices = (*notices, *start_warnings(model, instance, capped))
        try:
            file = open_rows(target, model, method, len(times))
        except OSError as problem:
            raise _unwritten(target, problem) from problem
        blocks = _Blocks(file, kept, times, whole=method.name in BACKENDS)
        with ProgressBar(times.duration, progress) as bar:
            (status, refused), interrupted = watched(
                instance, lambda: blocks.run(instance), lambda: bar.show(instance.time)
            )
    kept_times, rows = kept.selection()
    result = named_result(model, kept_times, rows, method, instance, notices)
    result = replace(result, rows=file.rows, at_rest=at_rest[0] if at_rest else None)
    try:
        if refused is not None:
            raise _refused(target, refused, times, result) from refused
        status = Status.INTERRUPTED if interrupted else status
        raise_where_ended(model, instance, status, result)
    except (SimulationError, RunInterrupted) as problem:
        with suppress(OSError):  # of a full disk: the rows can be read all the same
            file.end(problem.result.about())
        raise
    rounded = undecided(model, capped, instance, kept_times, rows, parameters)
    result = result if rounded is None else result.noted(undecided_state(rounded))
    result = with_requirements(model, result, kept_times, rows, {})
    result = replace(result, error_estimate=TOO_MANY_ROWS) if errors else result
    try:
        file.end(result.about())
    except OSError as problem:
        raise _refused(target, problem, times, result) from problem
    return result


@dataclass(frozen=True, slots=True, eq=False)
class _Blocks:
    """A run by blocks of rows, which go to a file; `whole` for a run that cannot pause."""

    file: RowFile
    kept: KeptRows
    times: RowTimes
    whole: bool

    def run(self, instance: Instance) -> tuple[Status, OSError | None]:
        """Run to all times; return the status, and the error that ended the writing."""
        width, count = self.kept.width, len(self.times)
        most = count if self.whole else min(MOST_ROWS, max(1, _BLOCK_VALUES // (width + 1)))
        size = count if self.whole else min(most, _FIRST)
        block = np.empty((most, width))
        first = 0
        while first < count:
            # Blocks end where chunks of a Zarr group do.
            last = min(first + size, count, first - first % most + most)
            times, rows = self.times.between(first, last), block[: last - first]
            begun = monotonic()
            status, done = instance.run(times, rows)
            try:
                self._take(times[:done], rows[:done])
            except OSError as problem:
                return status, problem
            if status is not Status.OK:
                return status, None
            if monotonic() - begun < _QUICK:
                size = min(most, 2 * size)
            first = last
        return Status.OK, None

    def _take(self, times: Array, rows: Array) -> None:
        """Write rows, and select among those that were written."""
        before = self.file.rows
        try:
            if len(times):
                self.file.append(times, rows)
        finally:
            written = self.file.rows - before
            if written:
                self.kept.add(times[:written], rows[:written])


def write_result(result: Result, target: Path | TextIO) -> None:
    """Write a result to a file of the kind that its ending names, or as CSV to a stream.

    Derivatives are columns of the file.
    """
    result = result.with_sensitivities()
    if not isinstance(target, Path):
        result.write_csv(target)
    elif target.suffix.lower() == ".npz":
        result.to_npz(target)
    elif target.suffix.lower() == ".zarr":
        result.to_zarr(target)
    else:
        result.to_csv(target)


def _write_after(target: Path | TextIO, run: Callable[[], Result]) -> Result:
    """Run in memory, then write the rows, also where the run ended early."""
    try:
        result = run()
    except (SimulationError, RunInterrupted) as problem:
        try:
            write_result(problem.result, target)
        except BgError as unwritten:
            problem.result = problem.result.noted(unwritten.diagnostics[0])
        raise
    write_result(result, target)
    return result


def open_rows(target: Path | TextIO, model: LoadedModel, method: Solver, count: int) -> RowFile:
    """Open a file for at most `count` rows of a model; its ending decides on its kind."""
    chosen = model.selection()
    columns = [
        RowArray(v.name, v.unit, (), (chosen.places[k],), chosen.factors[k])
        for k, v in enumerate(model.outputs)
    ]
    kind = target.suffix.lower() if isinstance(target, Path) else ""
    if not isinstance(target, Path) or kind not in (".npz", ".zarr"):
        return CsvRows(target, columns)
    about = bare_result(model, np.empty(0), np.empty((0, model.row_width)), method).about()
    arrays = [column for column in columns if column.name not in ("time", "about")]
    arrays += shape_arrays(model.facts.shapes, {v.name: k for k, v in enumerate(model.measured)})
    if kind == ".npz":
        return NpzRows(target, arrays, count, about)
    # Only this file needs Zarr.
    from bgc.runtime.results.zarr_rows import ZarrRows

    return ZarrRows(target, arrays, about)


def _can_grow(target: Path | TextIO) -> bool:
    """Return whether rows can be appended: a named pipe takes lines, but no archive."""
    if not isinstance(target, Path) or target.suffix.lower() != ".npz":
        return True
    return target.is_file() or not target.exists()


def _room(target: Path | TextIO) -> float:
    """The bytes of the disk that a file is on; Zarr compresses, so its rows may need few."""
    if not isinstance(target, Path) or target.suffix.lower() == ".zarr":
        return _ENDLESS
    try:
        return float(disk_usage(target.absolute().parent).total)
    except OSError:
        return _ENDLESS


def _refused(
    target: Path | TextIO, problem: OSError, times: RowTimes, result: Result
) -> SimulationError | OSError:
    """The error of a run whose rows cannot be written; that of a stream is its own."""
    if not isinstance(target, Path):
        return problem
    count = result.rows
    reached = float(times.between(count - 1, count)[0]) if count else 0.0
    why = rows_not_written(str(target), problem.strerror or str(problem), reached, count)
    return SimulationError(why, result.ended("failed", why.message))


def _unwritten(target: Path | TextIO, problem: OSError) -> BgError | OSError:
    if not isinstance(target, Path):
        return problem
    return BgError([cannot_write(str(target), problem.strerror or str(problem))])


def target_of(out: str | Path | TextIO) -> Path | TextIO:
    """The path of a file of rows, or the stream itself.

    Raises BgError: BG070 for a file of an unknown kind, BG055 in a missing directory.
    """
    if not isinstance(out, (str, Path)):
        return out
    path = Path(out)
    special = path.exists() and not path.is_file() and not path.is_dir()
    if path.suffix.lower() not in FILES and not special:
        raise BgError([unknown_file_kind(str(path), FILES)])
    if not path.absolute().parent.is_dir():
        raise BgError([cannot_write(str(path), "there is no such directory")])
    return path
