"""Many parameter sets at once: in the lanes of vector registers, on all processors.

Instances of a model go in batches of as many as a vector register holds. A batch takes one step
for all its instances (`runtime/c/lanes`). Each has devices of its own, sampled at the same times;
where a law of one may switch in a step, or a fixed step is to be subdivided, that
instance takes the step by itself, in the same parts as alone. An instance leaves
the batch where a law is undefined, an assertion does not hold, or static pivots lose digits; it is
then run alone, as by `simulate`, which also explains its errors.

All instances are run one by one, on all processors, where batches are not supported: algebraic
equations, sampled parts, jumps of states, closed chains of rigid connections, methods other than
Rosenbrock and explicit ones, such as `radau5`, and models so large that their iteration matrices
are factorised in loops. `Ensemble.alone` has the reason.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from bgc.building.cache import digest_of, digest_of_bytes
from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.ensembles import source_changed
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.methods import METHODS
from bgc.language.solver import Solver
from bgc.options import RUN_NUMBER, Options
from bgc.record_class import astuple, dataclass, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.ensemble import Ensemble
from bgc.runtime.results.observables import EXTREMES, Observable, Reducer, check_parts
from bgc.runtime.results.runs import gathered
from bgc.runtime.results.study import Study
from bgc.runtime.running.batches import Work, run_all
from bgc.runtime.running.binding import text
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.examination import examine
from bgc.runtime.running.identity import scene_identity
from bgc.runtime.running.lane_interface import LaneLibrary
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_or_compile
from bgc.runtime.running.parameters import Parameters
from bgc.runtime.running.partial_ensemble import find_unfinished
from bgc.runtime.running.rows import with_instants
from bgc.runtime.running.run import with_capped_step
from bgc.runtime.running.run_warnings import negative_among
from bgc.values.shown_units import shown_by

_FEWEST_INSTANCES = 4  # instances from which on compiling for batches pays


@dataclass(frozen=True, slots=True)
class Plan:
    """The runs of an ensemble: everything that decides their rows.

    `alone` is the reason for running them one by one, empty where batches are supported. `varied`
    names the varied parameters.
    `observables` are computed from the rows of each run, which are kept where there are none. Every
    `between`-th of the `times` is that of a row; extremes are looked for at the others too.
    """

    model: LoadedModel
    method: Solver
    cases: Cases
    times: Array
    alone: str
    varied: tuple[str, ...]
    observables: tuple[Observable, ...] = ()
    between: int = 1

    @property
    def identity(self) -> str:
        """The hash of everything but the machine that decides the rows."""
        arrays = (digest_of_bytes(each.tobytes()) for each in (self.times, self.cases.values))
        observables, columns = tuple(self.observables), self.model.facts.columns
        method = astuple(self.method)
        state = repr((method, self.alone, self.cases.names, observables, columns))
        return digest_of((*scene_identity(self.model, {}), state, *arrays))

    def work(self, library: LaneLibrary | None, cases: Cases | None = None) -> Work:
        """Reserve the arrays for all runs, or for some `cases` of them."""
        model, count = self.model, len(self.cases if cases is None else cases)
        chosen = library or model.library
        observed = self.observables
        return Work(
            model=model,
            library=chosen,
            parameters=Parameters(
                chosen, model.facts.folded, shown_by(model.facts.shown.parameters)
            ),
            method=self.method,
            cases=self.cases if cases is None else cases,
            varied=self.varied,
            times=self.times,
            values=np.full((count, len(self.varied)), np.nan),
            rows=None if observed else np.full((count, len(self.times), model.row_width), np.nan),
            reducer=self.reducer() if observed else None,
            reduced=np.full((count, len(observed)), np.nan),
        )

    def reducer(self) -> Reducer:
        """Compute the observables from rows."""
        names = [variable.name for variable in self.model.outputs]
        outputs = tuple(names.index(each.column) for each in self.observables)
        return Reducer(self.observables, outputs, self.model.selection().column, self.between)


def plan_many(
    model: LoadedModel,
    method: Solver,
    cases: Cases,
    times: Array,
    vectorised: bool = True,
    observables: tuple[Observable, ...] = (),
) -> Plan:
    """Decide how the runs of an ensemble are computed; BG787 for an observable without a row."""
    check_parts(observables, times)
    method = with_capped_step(method, times, model.facts.timed)
    alone = why_alone(model, method, len(cases), vectorised)
    varied = cases.varied(model.parameters.given({}))
    varied = [name for name in varied if name != RUN_NUMBER]
    between = 1
    if any(each.function in EXTREMES for each in observables):
        times, between = with_instants(times)
    return Plan(model, method, cases, times, alone, tuple(varied), observables, between)


def run_many(
    plan: Plan,
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
    resume: bool = False,
    design: str = "cases",
    library: LaneLibrary | None = None,
    examined: bool = True,
) -> Ensemble | Study:
    """Run a model with all parameter sets, each to all times; see `Model.simulate_many`.

    With observables each run leaves them alone, and the result is a study. With `resume`, what is
    done is kept if Ctrl-C ends the call, and the next equal call goes on from there. `library` is
    that of the batches, where the caller has loaded it. Unless `examined`, runs that rounding may
    decide are not.
    """
    work = plan.work(None if plan.alone else library or lane_library(plan.model))
    unfinished = find_unfinished(plan.identity) if resume else None
    recalled = unfinished.load(work) if unfinished is not None else 0
    run_all(work, progress)
    if examined:
        examine(work)
    kept = unfinished is not None and unfinished.keep(work)
    return outcome(plan, work, notices, design, recalled, kept)


def outcome(
    plan: Plan,
    work: Work,
    notices: Sequence[Diagnostic] = (),
    design: str = "cases",
    recalled: int = 0,
    kept: bool = False,
) -> Ensemble | Study:
    """Name the computed values, with outputs in the scene's order, or the observables.

    Raises Interrupted if Ctrl-C ended the work; `kept` says that the next call goes on from there.
    """
    model, outputs = plan.model, plan.observables or plan.model.outputs
    given = {name: model.parameters[name] for name in work.varied}
    shared: dict[str, Any] = {
        "scene": model.facts.name,
        "solver": work.method.name,
        "parameters": {name: work.values[:, k] for k, name in enumerate(work.varied)},
        "names": tuple(each.name for each in outputs),
        "units": {each.name: each.unit for each in (*given.values(), *outputs)},
        "shown": {each.name: each.shown for each in (*given.values(), *outputs)},
        "status": tuple(work.status_of(k) for k in range(len(work.cases))),
        "failures": dict(sorted(work.failures.items())),
        "together": len(work.together),
        "alone": plan.alone,
        "warnings": (*notices, *_warnings(work)),
        "recalled": recalled,
        "run_warnings": dict(sorted(work.warned.items())),
    }
    found: Ensemble | Study
    if work.rows is None:
        found = Study(values=work.reduced, design=design, **shared)
    else:
        found = Ensemble(time=work.times, values=model.selection().of(work.rows), **shared)
    if work.stopping:
        raise found.interrupted(kept)
    return found


def why_alone(model: LoadedModel, method: Solver, count: int, vectorised: bool) -> str:
    """Return the reason for running instances one by one; empty where batches are supported.

    A small number of instances is the reason only where more of them would run in batches.
    """
    info = model.library.model
    rates = set(info.mass_row[: info.n_mass]) if info.n_mass else set(range(info.n_state))
    solver = METHODS.get(method.name)  # None: one of a backend
    verb = "is" if count == 1 else "are"
    reasons = {
        "vector registers are not wanted": not vectorised,
        "the model's source is not at hand": model.origin is None,
        "the model has no states": info.n_state == 0,
        "the model has algebraic equations": len(rates) < info.n_state,
        "a divisor of the equations is watched": info.n_divisor > 0,
        "the model has sampled parts": model.library.is_sampled,
        "the states of the model jump": model.library.has_jumps,
        "the model has closed chains of rigid connections": model.library.has_chains,
        f"`{method.name}` is not a Rosenbrock or explicit method": not (
            solver and solver.family.lanes
        ),
        "the model is so large that its matrix is factorised in loops": not (
            model.library.has_lane_factors or (solver and not solver.family.jacobian)
        ),
        f"{counted(count, 'instance')} {verb} too few to compile for": count < _FEWEST_INSTANCES,
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


def lane_options(options: Options) -> Options:
    """The options of a compilation with the functions that run batches."""
    return replace(options, lanes=True)


def lane_library(model: LoadedModel) -> LaneLibrary:
    """Compile a model for batches, or load it from the cache; BG742 if its source changed."""
    path, options = model.source_for("batches")
    library = LaneLibrary(load_or_compile(path, lane_options(options)).library)
    if text(library.model.hash) != text(model.library.model.hash):
        raise BgError([source_changed(str(path))])
    return library


def _warnings(work: Work) -> Iterator[Diagnostic]:
    """Warn of all instances together: of negative parameters (BG460), and of runs, by code."""
    yield from negative_among(work.model, work.varied, work.values)
    parameters = {name: work.values[:, k] for k, name in enumerate(work.varied)}
    yield from gathered(work.warned, parameters)
