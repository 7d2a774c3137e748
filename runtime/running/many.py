"""Many parameter sets at once: in the lanes of vector registers, on all processors.

Instances of a model go in batches of as many as a vector register holds. A batch takes one step
for all its instances (`runtime/c/lanes`). Each has devices of its own, sampled at the same times;
where a law of one may switch in a step, or a fixed step is to be subdivided (`substeps`), that
instance takes the step by itself, in the same parts as alone. An instance leaves
the batch where a law is undefined, an assertion does not hold, or static pivots lose digits; it is
then run alone, as by `simulate`, which also explains its errors.

All instances are run one by one, on all processors, where batches are not supported: algebraic
equations, sampled parts, jumps of states, closed chains of rigid connections, methods other than
Rosenbrock and explicit ones, such as `radau5`, and models so large that their iteration matrices
are factorised in loops. `Ensemble.alone` has the reason.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import TypeAlias, TypeGuard

import numpy as np

from bgc.building.recall import processors
from bgc.diagnostics.catalogue.accuracy import samples_over_budget
from bgc.diagnostics.catalogue.ensembles import no_instances, source_changed, uneven_values
from bgc.diagnostics.catalogue.run import no_memory
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.ensemble import DONE, FAILED, INTERRUPTED, Ensemble, EnsembleInterrupted
from bgc.runtime.running.binding import Instance, Library, text
from bgc.runtime.running.compiling import load_or_compile
from bgc.runtime.running.devices import open_devices
from bgc.runtime.running.failures import require
from bgc.runtime.running.lanes import LaneLibrary
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.parameters import Parameters, ParameterValue
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.running.run import Method, set_method, start
from bgc.runtime.running.structures import Status
from bgc.runtime.running.unfinished import find_unfinished
from bgc.values.shown import shown_by

Sets: TypeAlias = Mapping[str, ParameterValue] | Sequence[Mapping[str, ParameterValue]]
"""Values by parameter, one for each instance; or a set of parameters for each instance."""

_FEWEST = 4  # instances from which on compiling for batches pays
_WATCH_SECONDS = 0.05


def parameter_sets(given: Sets) -> list[Mapping[str, ParameterValue]]:
    """Make one mapping for each instance; in a mapping of lists, other values are for all.

    Raises BgError: BG740 if lists differ in length, BG741 if there is no instance.
    """
    if not isinstance(given, Mapping):
        sets = list(given)
    else:
        lists = {name: list(value) for name, value in given.items() if _is_list(value)}
        shared = {name: value for name, value in given.items() if name not in lists}
        first = next(iter(lists), "")
        count = len(lists[first]) if lists else 1
        for name, values in lists.items():
            if len(values) != count:
                raise BgError([uneven_values(name, len(values), first, count)])
        sets = [
            {**shared, **{name: values[k] for name, values in lists.items()}} for k in range(count)
        ]
    if not sets:
        raise BgError([no_instances()])
    return sets


def _is_list(value: ParameterValue) -> TypeGuard[Sequence[ParameterValue]]:
    return not isinstance(value, str) and np.ndim(np.asarray(value, dtype=object)) > 0


@dataclass(slots=True)
class _Work:
    """Data shared by the threads. Each writes only the entries of its own instances."""

    model: LoadedModel
    library: Library
    parameters: Parameters
    method: Method
    sets: Sequence[Mapping[str, float]]
    varied: Sequence[str]
    times: Array
    rows: Array  # (instances, rows, outputs and accounts)
    values: Array  # (instances, varied parameters)
    failures: dict[int, Diagnostic] = field(default_factory=dict)
    completed: set[int] = field(default_factory=set)
    together: set[int] = field(default_factory=set)
    over_budget: list[Mapping[str, float]] = field(default_factory=list)  # counts of instances
    running: dict[int, list[Instance]] = field(default_factory=dict)  # by the number of the first
    stopping: bool = False

    @property
    def width(self) -> int:
        """Instances in a batch."""
        return self.library.width if isinstance(self.library, LaneLibrary) else 1

    def run_batch(self, start: int) -> None:
        """Run a batch of instances from `start` on together, and those that fail again alone.

        A batch that an earlier call completed is not run; a part of one is, so that its
        instances take the same steps as in a call that was not interrupted.
        """
        numbers = range(start, min(start + self.width, len(self.sets)))
        if self.stopping:
            return
        if self.completed.issuperset(numbers):
            for k in numbers:
                self._instance(k)  # its values
            return
        self.completed.difference_update(numbers)
        batch = {k: self._instance(k) for k in numbers}
        self.running[start] = list(batch.values())
        try:
            if isinstance(self.library, LaneLibrary):
                self._run_together(self.library, batch)
            for k in numbers:
                if not (self.stopping or k in self.completed):
                    self._run_alone(k, batch[k])
        finally:
            del self.running[start]

    def _instance(self, number: int) -> Instance:
        instance = self.parameters.instance(self.sets[number])
        index = {name: k for k, name in enumerate(self.parameters)}
        self.values[number] = [instance.parameter(index[name]) for name in self.varied]
        accounts = self.rows.shape[2] > self.library.model.n_output
        require(instance, set_method(instance, self.method, accounts))
        return instance

    def _run_together(self, library: LaneLibrary, batch: Mapping[int, Instance]) -> None:
        """Run a batch in lockstep, without the instances that have no initial state."""
        with ExitStack() as devices:
            for instance in batch.values():
                devices.enter_context(open_devices(instance, self.model.folder))
            ready = [k for k, instance in batch.items() if self._start(instance) is None]
            if not ready:
                return
            rows = [self.rows[k] for k in ready]
            status, finished = library.run([batch[k] for k in ready], self.times, rows)
        if status is Status.NO_MEMORY:
            raise BgError([no_memory()])
        done = {k for k, good in zip(ready, finished, strict=True) if good}
        if status is Status.OK:
            self.completed |= done
            self.together |= done
            for number in done:
                self._note_counts(batch[number])

    def _run_alone(self, number: int, instance: Instance) -> None:
        rows = self.rows[number]
        rows[:] = np.nan  # erase rows from before it left its batch
        with open_devices(instance, self.model.folder):
            if problem := self._start(instance):
                self.failures[number] = problem
                return
            status, _ = instance.run(self.times, rows)
        self._note_counts(instance)
        if status is Status.OK:
            self.completed.add(number)
        elif status is not Status.INTERRUPTED:
            self.failures[number] = self.model.explain(instance, status)

    def _note_counts(self, instance: Instance) -> None:
        counts = instance.counts
        if counts["over_budget"]:
            self.over_budget.append(counts)

    def _start(self, instance: Instance) -> Diagnostic | None:
        """Put an instance at its initial state; return the error if there is none."""
        try:
            status, _ = start(instance, self.method, self.method.rest_of(self.model.facts))
        except BgError as problem:  # its fast modes do not come to rest
            return problem.diagnostics[0]
        return None if status is Status.OK else self.model.explain(instance, status)

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
        return min(float(len(self.sets)), len(self.completed) + len(self.failures) + sum(parts))

    def stop(self) -> None:
        """Make all threads return after their present steps."""
        self.stopping = True
        for batch in list(self.running.values()):
            for instance in batch:
                instance.stop()


def simulate_many(
    model: LoadedModel,
    method: Method,
    sets: Sequence[Mapping[str, ParameterValue]],
    times: Array,
    progress: bool,
    vectorised: bool,
    notices: Sequence[Diagnostic] = (),
    resume: bool = False,
) -> Ensemble:
    """Run a model with all parameter sets, each to all times; see `Model.simulate_many`.

    With `resume`, what is done is kept if Ctrl-C ends the call, and the next equal call goes on
    from there.
    """
    method = method.with_capped_step(times, model.facts.timed)
    numbers = [model.parameters.given(each) for each in sets]
    alone = _why_alone(model, method, len(sets), vectorised)
    library = model.library if alone else _lane_library(model)
    preset = model.parameters.given({})
    given = dict.fromkeys(name for each in numbers for name in each)
    varied = [n for n in given if n not in preset or len({each[n] for each in numbers}) > 1]
    work = _Work(
        model=model,
        library=library,
        parameters=Parameters(library, model.facts.folded, shown_by(model.facts.shown_parameters)),
        method=method,
        sets=numbers,
        varied=varied,
        times=times,
        rows=np.full((len(sets), len(times), model.row_width), np.nan),
        values=np.full((len(sets), len(varied)), np.nan),
    )
    unfinished = find_unfinished(model, method, numbers, times, alone) if resume else None
    if unfinished is not None:
        work.completed |= unfinished.recall(work.rows)
    recalled = len(work.completed)
    _run_all(work, progress)
    ensemble = _labelled(work, alone, notices, recalled)
    if work.stopping:
        kept = unfinished is not None and unfinished.keep(work.rows, work.completed)
        raise EnsembleInterrupted(ensemble, kept)
    if unfinished is not None:
        unfinished.clear()
    return ensemble


def _run_all(work: _Work, progress: bool) -> None:
    """Run all batches on all processors; Ctrl-C stops them."""
    starts = range(0, len(work.sets), work.width)
    with (
        ProgressBar(float(len(work.sets)), progress, unit=" instances") as bar,
        ThreadPoolExecutor(max_workers=processors()) as pool,
    ):
        futures = [pool.submit(work.run_batch, start) for start in starts]
        pending = set(futures)
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


def _why_alone(model: LoadedModel, method: Method, count: int, vectorised: bool) -> str:
    """Return the reason for running instances one by one; empty where batches are supported.

    A small number of instances is the reason only where more of them would run in batches.
    """
    info = model.library.model
    rates = set(info.mass_row[: info.n_mass]) if info.n_mass else set(range(info.n_state))
    solver = model.library.methods.get(method.name)  # None: one of a backend
    reasons = {
        "vector registers are not wanted": not vectorised,
        "the model's source is not at hand": model.origin is None,
        "the model has no states": info.n_state == 0,
        "the model has algebraic equations": len(rates) < info.n_state,
        "a divisor of the equations is watched": info.n_divisor > 0,
        "the model has sampled parts": model.library.is_sampled,
        "the states of the model jump": model.library.has_jumps,
        "the model has closed chains of rigid connections": model.library.has_chains,
        f"`{method.name}` is not a Rosenbrock or explicit method": not (solver and solver.lanes),
        "the model is so large that its matrix is factorised in loops": not (
            model.library.has_lane_factors or (solver and solver.explicit)
        ),
        f"{count} instances are too few to compile for": count < _FEWEST,
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


def _lane_library(model: LoadedModel) -> LaneLibrary:
    """Compile a model for batches, or load it from the cache; BG742 if its source changed."""
    assert model.origin is not None
    path, options = model.origin
    library = LaneLibrary(load_or_compile(path, replace(options, lanes=True)).library)
    if text(library.model.hash) != text(model.library.model.hash):
        raise BgError([source_changed(str(path))])
    return library


def _labelled(work: _Work, alone: str, notices: Sequence[Diagnostic], recalled: int) -> Ensemble:
    """Name the computed values, with outputs in the scene's order."""
    model = work.model
    order = model.row_places()
    in_order = order == list(range(work.rows.shape[2]))
    return Ensemble(
        scene=model.facts.scene,
        solver=work.method.name,
        time=work.times,
        values=work.rows if in_order else work.rows[:, :, order],
        names=tuple(variable.name for variable in model.outputs),
        units={variable.name: variable.unit for variable in model.outputs},
        shown={variable.name: variable.shown for variable in model.outputs},
        parameters={name: work.values[:, k] for k, name in enumerate(work.varied)},
        status=tuple(work.status_of(k) for k in range(len(work.sets))),
        failures=dict(sorted(work.failures.items())),
        together=len(work.together),
        alone=alone,
        recalled=recalled,
        warnings=(*notices, *_warnings(work)),
    )


def _warnings(work: _Work) -> Iterator[Diagnostic]:
    """Warn of fixed steps with an error above the tolerance, of all instances together (BG730)."""
    if work.over_budget:
        worst = max(work.over_budget, key=lambda counts: counts["largest_excess"])
        yield samples_over_budget(
            int(sum(counts["over_budget"] for counts in work.over_budget)),
            work.method.step,
            work.method.substeps or work.model.library.methods[work.method.name].substeps,
            worst["excess_time"],
            worst["largest_excess"],
        )
