"""The runs of an ensemble: batches of instances in threads, and the instances that run alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack
from threading import Lock
from time import thread_time

import numpy as np

from bgc.building.recall import processors
from bgc.diagnostics.catalogue.run import no_memory
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field, fields
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import Reducer
from bgc.runtime.results.runs import DONE, FAILED, INTERRUPTED
from bgc.runtime.running.binding import Instance, Library
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.device_drivers import open_devices
from bgc.runtime.running.failures import require
from bgc.runtime.running.lane_interface import LaneLibrary
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import Parameters
from bgc.runtime.running.port_bounds import require_ports
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.running.run import set_method, start
from bgc.runtime.running.run_warnings import energy_warnings, step_warnings
from bgc.runtime.running.structures import Status
from bgc.runtime.running.subtolerance import subtolerance_states

_WATCH_SECONDS = 0.05
_WIDEST = 8  # instances of a batch: doubles of the widest vector register


@dataclass(slots=True, kw_only=True)
class Outcome:
    """What runs have left, those of a whole ensemble or of a chunk of it from `first` on.

    Sets and mappings have the numbers of the runs within the chunk.
    """

    first: int = 0
    values: Array  # (instances, varied parameters)
    rows: Array | None = None  # (instances, rows, outputs, accounts); None where they are reduced
    reduced: Array  # (instances, observables)
    failures: dict[int, Diagnostic] = field(default_factory=dict)
    completed: set[int] = field(default_factory=set)
    together: set[int] = field(default_factory=set)
    warned: dict[int, tuple[Diagnostic, ...]] = field(default_factory=dict)  # as single runs are
    seconds: float = 0.0  # processor time of all threads
    stopping: bool = False

    def add(self, part: Outcome) -> None:
        """Put the results of a chunk where they belong."""
        first, places = part.first, slice(part.first, part.first + len(part.values))
        self.values[places] = part.values
        if self.rows is not None and part.rows is not None:
            self.rows[places] = part.rows
        else:
            self.reduced[places] = part.reduced
        self.completed |= {first + k for k in part.completed}
        self.together |= {first + k for k in part.together}
        self.failures |= {first + k: why for k, why in part.failures.items()}
        self.warned |= {first + k: some for k, some in part.warned.items()}


@dataclass(slots=True, kw_only=True)
class Work(Outcome):
    """Data shared by the threads. Each writes only the entries of its own instances.

    With a `reducer`, the rows of a batch live in the thread that runs it, and each instance leaves
    its observables. Then memory grows with instances times observables, not with rows.
    """

    model: LoadedModel
    library: Library
    parameters: Parameters
    method: Solver
    cases: Cases
    varied: Sequence[str]
    times: Array
    reducer: Reducer | None = None
    subtolerance: set[int] = field(default_factory=set)  # in which a state fell and grew again
    running: dict[int, list[Instance]] = field(default_factory=dict)  # by the number of the first

    @property
    def results(self) -> Array:
        """What the runs leave, along their numbers: all rows, or the reduced ones."""
        return self.reduced if self.rows is None else self.rows

    def outcome(self, first: int) -> Outcome:
        """What the runs have left, as a chunk from `first` on: data alone."""
        found = {each.name: getattr(self, each.name) for each in fields(Outcome)}
        return Outcome(**{**found, "first": first})

    @property
    def width(self) -> int:
        """Instances in a batch."""
        return self.library.width if isinstance(self.library, LaneLibrary) else 1

    def run_batch(self, start: int) -> None:
        """Run a batch of instances from `start` on together, and those that fail again alone.

        A batch that an earlier call completed is not run; a part of one is, so that its
        instances take the same steps as in a call that was not interrupted.
        """
        numbers = range(start, min(start + self.width, len(self.cases)))
        if self.stopping:
            return
        if self.completed.issuperset(numbers):
            for k in numbers:
                self._instance(k)  # its values
            return
        self.completed.difference_update(numbers)
        rows = self._rows_of(numbers)
        batch = {k: self._instance(k) for k in numbers}
        self.running[start] = list(batch.values())
        try:
            if isinstance(self.library, LaneLibrary):
                self._run_together(self.library, batch, rows)
            for k in numbers:
                if not (self.stopping or k in self.completed):
                    self._run_alone(k, batch[k], rows[k])
        finally:
            del self.running[start]
        for k in self.completed.intersection(numbers):
            self._warn(k, batch[k], rows[k])
        if self.reducer is not None:
            for k in self.completed.intersection(numbers):
                self.reduced[k] = self.reducer(self.times, rows[k])

    def _rows_of(self, numbers: range) -> dict[int, Array]:
        """The rows of a batch: their part of the array, or places of their own."""
        if self.rows is not None:
            return {k: self.rows[k] for k in numbers}
        width = self.model.row_width
        return {k: np.full((len(self.times), width), np.nan) for k in numbers}

    def _instance(self, number: int) -> Instance:
        instance = self.parameters.instance(self.cases[number])
        index = {name: k for k, name in enumerate(self.parameters)}
        self.values[number] = [instance.parameter(index[name]) for name in self.varied]
        accounts = self.model.row_width > self.library.model.n_output
        require(instance, set_method(instance, self.method, accounts))
        return instance

    def _run_together(
        self, library: LaneLibrary, batch: Mapping[int, Instance], places: Mapping[int, Array]
    ) -> None:
        """Run a batch in lockstep, without the instances that have no initial state."""
        with ExitStack() as devices:
            for instance in batch.values():
                devices.enter_context(open_devices(instance, self.model.folder))
            ready = [k for k, instance in batch.items() if self._start(instance) is None]
            if not ready:
                return
            rows = [places[k] for k in ready]
            status, finished = library.run([batch[k] for k in ready], self.times, rows)
        if status is Status.NO_MEMORY:
            raise BgError([no_memory()])
        done = {k for k, good in zip(ready, finished, strict=True) if good}
        if status is Status.OK:
            self.completed |= done
            self.together |= done

    def _run_alone(self, number: int, instance: Instance, rows: Array) -> None:
        rows[:] = np.nan  # erase rows from before it left its batch
        with open_devices(instance, self.model.folder):
            if problem := self._start(instance):
                self.failures[number] = problem
                return
            status, _ = instance.run(self.times, rows)
        if status is Status.OK:
            self.completed.add(number)
        elif status is not Status.INTERRUPTED:
            self.failures[number] = self.model.explain(instance, status)

    def _warn(self, number: int, instance: Instance, rows: Array) -> None:
        """Note what a single run with these steps and rows would warn of."""
        counts = instance.counts
        found = (
            *step_warnings(self.model, counts, self.method),
            *energy_warnings(self.model, self.times, rows, counts["exchanged"]),
        )
        if found:
            self.warned[number] = found
        if subtolerance_states(instance):
            self.subtolerance.add(number)

    def _start(self, instance: Instance) -> Diagnostic | None:
        """Put an instance at its initial state; return the error if there is none."""
        try:
            status, _ = start(instance, self.method, self.model.facts)
            if status is not Status.OK:
                return self.model.explain(instance, status)
            require_ports(instance, self.model.facts, self.model.places)
        except BgError as problem:  # its fast modes do not come to rest, or a port is too stiff
            return problem.diagnostics[0]
        return None

    def status_of(self, number: int) -> str:
        """Return `done`, `failed` or `interrupted` for an instance."""
        if number in self.completed:
            return DONE
        return FAILED if number in self.failures else INTERRUPTED

    def reached(self) -> float:
        """Count finished instances, with the finished parts of running ones."""
        end = float(self.times[-1])
        parts = (
            len(batch) * min(1.0, batch[0].time / end) for batch in list(self.running.values())
        )
        return min(float(len(self.cases)), len(self.completed) + len(self.failures) + sum(parts))

    def stop(self) -> None:
        """Make all threads return after their present steps."""
        self.stopping = True
        for batch in list(self.running.values()):
            for instance in batch:
                instance.stop()


def rows_at_once(instances: int) -> int:
    """The number of instances whose rows are in memory at once where they are reduced."""
    return min(instances, _WIDEST * processors())


def run_all(work: Work, progress: bool, threads: int = 0) -> None:
    """Run all batches on so many threads, by default one for each processor; Ctrl-C stops them."""
    starts = iter(range(0, len(work.cases), work.width))
    lock = Lock()

    def run_batches() -> None:
        while not work.stopping:
            with lock:
                start = next(starts, None)
            if start is None:
                return
            begin = thread_time()
            work.run_batch(start)
            with lock:
                work.seconds += thread_time() - begin

    count = threads or processors()
    with (
        ProgressBar(float(len(work.cases)), progress, unit=" instances") as bar,
        ThreadPoolExecutor(max_workers=count) as pool,
    ):
        pending = {pool.submit(run_batches) for _ in range(count)}
        futures = tuple(pending)
        while pending:
            try:
                pending = wait(pending, timeout=_WATCH_SECONDS).not_done
                bar.show(work.reached())
            except KeyboardInterrupt:
                work.stopping = True
            if work.stopping:
                work.stop()
    for future in futures:
        future.result()
