"""One run of a model: its method, its devices, and its supervision from Python."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from threading import Event, Thread
from typing import Any, TypeVar

from bgc.building.backends import BACKENDS, build_backend
from bgc.building.build_result import RunFacts
from bgc.building.cache import open_cache
from bgc.diagnostics.catalogue.arguments import (
    bad_option,
    option_not_served,
    step_needed,
    unknown_solver,
)
from bgc.diagnostics.catalogue.backends import solver_does_not_serve
from bgc.diagnostics.catalogue.fmu_parts import fmu_left_out
from bgc.diagnostics.diagnostic import BgError
from bgc.language.methods import METHODS, default_method
from bgc.language.records import Where
from bgc.language.scene_tables import AUTO
from bgc.language.solver import SOLVER_OPTIONS, Solver
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest_report import AtRest
from bgc.runtime.running.binding import Instance, Library, backend_run
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.running.rest import go_to_rest
from bgc.runtime.running.rows import RowTimes
from bgc.runtime.running.settle import settle
from bgc.runtime.running.structures import C_OPTIONS, OptionsStruct, Status

_ROWS_IN_A_STEP = 5
_WATCH_SECONDS = 0.05  # between two checks of a run: bounds the wait after Ctrl-C

_NOT_GIVEN = Solver()

_Outcome = TypeVar("_Outcome")


def with_capped_step(method: Solver, times: Array | RowTimes, timed: bool) -> Solver:
    """Cap the step of an adaptive method at a few row intervals where a model is `timed`.

    Error control cannot see a source that acts between two stages of a long step.
    """
    if not timed or method.fixed or method.max_step or len(times) < 2:
        return method
    duration = times.duration if isinstance(times, RowTimes) else float(times[-1] - times[0])
    interval = duration / (len(times) - 1)
    return replace(method, max_step=_ROWS_IN_A_STEP * interval)


def option_values(method: Solver, accounts: bool) -> dict[str, float]:
    """The numbers of `bgc_options` by its fields, but for the errors, which are not estimated."""
    return {**{name: getattr(method, name) for name in C_OPTIONS}, "accounts": int(accounts)}


def options_struct(method: Solver, accounts: bool, errors: bool = False) -> OptionsStruct:
    """Make the options structure of C."""
    values = option_values(method, accounts)
    return OptionsStruct(name=method.name.encode(), **values, errors=int(errors))


def choose_method(
    library: Library,
    facts: RunFacts,
    given: Solver = _NOT_GIVEN,
    backends: Iterable[str] = (),
) -> Solver:
    """Choose the method of a run: the caller's options go before those of the scene.

    Without a solver, and for `auto` without a recommendation, the method is the default of the
    runtime: with fixed steps where a step is given, else with error control. The scene's options
    are those of its own method: another one takes those that it has, but no tolerance or step of a
    method of the other kind. `backends` are external solvers that may be chosen too.

    Raises BgError: BG044 for an option that the method does not have, BG071 for an unknown solver,
    BG072 for a fixed-step method without a step, BG066 for a least step above the longest.
    """
    own = facts.solver
    name = given.name or own.name
    wanted: dict[str, Any] = {**own.given, **given.given}
    intended = wanted if own.name == name else given.given
    if name in ("", AUTO):
        is_fixed = bool(wanted.get("step") or facts.step)
        name = default_method(is_fixed, library.explicit_cost > 0)
    known = (*METHODS, *backends)
    if name not in known:
        raise BgError([unknown_solver(name, known)])
    method = Solver(name, start=given.start, **wanted)
    for option in intended:
        if option not in method.served:
            by_caller = [o for o in method.served if Where.COMMAND in SOLVER_OPTIONS[o].where]
            in_scenes = [o for o in method.served if o not in by_caller]
            raise BgError([option_not_served(name, option, method.fixed, by_caller, in_scenes)])
    if 0.0 < (longest := method.max_step) < method.min_step:
        raise BgError(
            [bad_option("min_step", method.min_step, f"at most `max_step`, {longest:g}", "1e-9")]
        )
    lost = _options_of_other_kind(own, method.fixed) - given.given.keys()
    kept = {o: value for o, value in wanted.items() if o in method.served and o not in lost}
    method = Solver(name, start=given.start, **kept)
    if method.fixed and not method.step:
        if facts.step is None:
            raise BgError([step_needed(name)])
        method = replace(method, step=facts.step)
    return method


def _options_of_other_kind(own: Solver, fixed: bool) -> set[str]:
    """The options of the scene's own method that have no meaning for one of the other kind."""
    if own.name not in METHODS:  # none, `auto`, or one of a backend
        return {"rtol", "atol"} if fixed else set()
    return {"rtol", "atol", "step"} if own.fixed != fixed else set()


def start(instance: Instance, method: Solver, facts: RunFacts) -> tuple[Status, AtRest | None]:
    """Put an instance at its initial state, or at rest near to it.

    Without a start at rest, modes faster than `settle` of the method, or of the scene, are brought
    to rest.
    """
    rest = facts.rest_for(method.start)
    if rest is not None and facts.fmus:
        way = "leave out `start rest`: an FMU starts by its own rules"
        raise BgError([fmu_left_out("a start at rest", facts.fmus[0].name, way)])
    status = instance.reset(checked=rest is None)
    if status is Status.OK and rest is not None:
        return go_to_rest(instance, rest)
    if status is Status.OK and (frequency := method.settle or facts.solver.settle):
        return settle(instance, frequency), None
    return status, None


def set_method(instance: Instance, method: Solver, accounts: bool, errors: bool = False) -> Status:
    """Set the method of an instance; an external solver is compiled first if necessary.

    `errors` says whether the errors of the outputs are estimated, which no external solver does.

    Raises BgError: BG046 if the solver is not installed, BG047 if it does not support the model.
    """
    if method.name not in BACKENDS:
        return instance.set_options(options_struct(method, accounts, errors))
    model = instance.library.model
    unsupported = (
        (model.n_device > 0, "it reads a device"),
        (instance.library.is_sampled, "it has sampled parts"),
        (model.n_input > 0, "its inputs are written while it runs"),
        (model.n_mass > 0, "its rates are coupled, or it has algebraic equations"),
        (model.n_state == 0, "it has no states"),
        (instance.library.has_jumps, "its states jump"),
        (instance.library.has_chains, "it has closed chains of rigid connections"),
    )
    for applies, reason in unsupported:
        if applies:
            raise BgError([solver_does_not_serve(method.name, reason)])
    path = build_backend(BACKENDS[method.name], open_cache())
    instance.backend = backend_run(path, method.name)
    adaptive = replace(method, name=default_method(fixed=False))
    return instance.set_options(options_struct(adaptive, accounts))


def run_watched(
    instance: Instance, times: Array, rows: Array, progress: bool
) -> tuple[Status, int, bool]:
    """Run to all times, with a progress bar if requested; Ctrl-C stops the run within 0.2 s.

    Returns the status, the number of finished rows, and whether Ctrl-C was pressed.
    """
    with ProgressBar(float(times[-1]), progress) as bar:
        (status, done), interrupted = watched(
            instance, lambda: instance.run(times, rows), lambda: bar.show(instance.time)
        )
    return status, done, interrupted


def watched(
    instance: Instance, run: Callable[[], _Outcome], watch: Callable[[], None]
) -> tuple[_Outcome, bool]:
    """Run an instance in a thread, calling `watch` every 0.05 s; Ctrl-C stops the run.

    The C code runs uninterrupted, so that watching cannot change the result.

    Returns the result of `run`, and whether Ctrl-C was pressed.
    """
    interrupted = False

    def look(finished: Event) -> None:
        nonlocal interrupted
        try:
            finished.wait(_WATCH_SECONDS)
            watch()
        except KeyboardInterrupt:
            interrupted = True
        if interrupted:
            instance.stop()

    found = _in_thread(run, look)
    return found, interrupted


def interruptible(work: Callable[[], _Outcome]) -> _Outcome:
    """Do work of C in a thread, so that signals are handled meanwhile; they abandon it.

    A file system that does not answer stops the thread, which keeps what it works on alive.
    """
    return _in_thread(work, lambda finished: finished.wait(_WATCH_SECONDS))


def _in_thread(work: Callable[[], _Outcome], look: Callable[[Event], object]) -> _Outcome:
    """Do work in a thread, and `look` again and again until it has finished."""
    outcome: list[_Outcome] = []
    # An event: after Ctrl-C in Thread.join, Python would consider the thread ended.
    finished = Event()

    def do() -> None:
        try:
            outcome.append(work())
        finally:
            finished.set()

    Thread(target=do, daemon=True).start()
    while not finished.is_set():
        look(finished)
    (found,) = outcome
    return found
