"""A whole run of a model, from the choice of its method to its named columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.accuracy import moves_below, rounding_decides
from bgc.diagnostics.catalogue.arguments import no_duration
from bgc.diagnostics.catalogue.trade import nothing_measured
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.methods import GAUSS, METHODS
from bgc.language.scene_tables import AUTO
from bgc.language.solver import Solver
from bgc.record_class import dataclass, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.error_estimate import NOT_ASKED, judged, largest_between, unknown
from bgc.runtime.results.recorded_shapes import shapes_of
from bgc.runtime.results.requirements import missed
from bgc.runtime.results.rest_report import AtRest
from bgc.runtime.results.result import Result
from bgc.runtime.results.slopes import Slopes
from bgc.runtime.running.advice import faster_method
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.device_drivers import NO_CHOICES, Choices
from bgc.runtime.running.failures import RunInterrupted, SimulationError, explain, require
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import NOTHING, ParameterValue
from bgc.runtime.running.recommendation import recommended_method
from bgc.runtime.running.requirements import requirements_of
from bgc.runtime.running.rows import RowTimes, fits, lazy_times, row_times, with_instants
from bgc.runtime.running.run import choose_method, run_watched, with_capped_step
from bgc.runtime.running.run_warnings import run_warnings, start_warnings
from bgc.runtime.running.sensitivities import Direction, begin
from bgc.runtime.running.structures import Status
from bgc.runtime.running.subtolerance import Undecided, subtolerance_states, undecided

TOO_MANY_ROWS: Final = "not estimated: the rows are too many for memory"

_NOT_GIVEN = Solver()
_ROWS = 201  # of a run whose end alone is asked for, to see whether rounding decides it


def simulate(
    model: LoadedModel,
    method: Solver,
    times: Array,
    parameters: Mapping[str, ParameterValue] = NOTHING,
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
    devices: Choices = NO_CHOICES,
    errors: bool = False,
    directions: Sequence[Direction] = (),
) -> Result:
    """Run from the initial state to all times, s, and name the columns.

    `notices` are warnings about the method, to be shown with the result. `devices` override
    drivers of the scene. With `errors`, those of the columns are estimated. With `directions`, of a
    model with tangents, the columns are differentiated.

    Raises
    ------
    SimulationError, RunInterrupted
        The run ended early; `result` holds the rows up to there.
    BgError
        A parameter is at fault, or there is no initial state.
    """
    unserved = errors_not_estimated(model, method, len(times)) if errors else NOT_ASKED
    followed = not unserved
    columns = model.row_width + len(model.measured) * followed
    # The rows are the same bits with other instants between them, at which limits are judged.
    instants, between = with_instants(times) if model.facts.criteria else (times, 1)
    found = np.full((len(instants), columns), np.nan)
    slopes = np.full((len(instants), len(directions), len(model.measured)), np.nan)
    capped = with_capped_step(method, times, model.facts.timed)
    at_rest: list[AtRest] = []
    begun = model.started(
        capped, bool(model.accounts), parameters, at_rest.append, devices, followed
    )
    with begun as instance:
        notices = (*notices, *start_warnings(model, instance, capped))
        if directions:
            begin(model, instance, capped, parameters, directions).follow(slopes)
        status, done, interrupted = run_watched(instance, instants, found, progress)
    rows, reached = found[::between, : model.row_width], -(-done // between)
    result = named_result(model, times[:reached], rows[:reached], method, instance, notices)
    result = replace(result, at_rest=at_rest[0]) if at_rest else result
    if directions:
        result = with_slopes(model, result, directions, slopes[::between][:reached])
    off: dict[str, Array] = {}
    if followed:
        largest = largest_between(found[:done, model.row_width :], between)
        doubtful = instance.counts["doubtful_errors"] > 0
        off, unserved = estimated(model, rows[:reached], largest, doubtful)
    result = with_errors(result, off, unserved)
    raise_where_ended(model, instance, Status.INTERRUPTED if interrupted else status, result)
    rounded = undecided(model, capped, instance, times, rows, parameters)
    if rounded is not None:
        off = unknown(off)
        reason = "unknown: rounding decides a state below its tolerance" if off else unserved
        result = with_errors(result, off, reason).noted(undecided_state(rounded))
    return with_requirements(model, result, instants, found, off, between)


def with_slopes(
    model: LoadedModel, result: Result, directions: Sequence[Direction], slopes: Array
) -> Result:
    """Add derivatives, (rows, directions, outputs), to a result."""
    places = {v.name: k for k, v in enumerate(model.measured) if v.name in result.columns}
    found = {
        direction.name: Slopes(
            direction.unit, {name: slopes[:, number, k] for name, k in places.items()}
        )
        for number, direction in enumerate(directions)
    }
    return replace(result, sensitivities=found)


def errors_not_estimated(model: LoadedModel, method: Solver, rows: int) -> str:
    """Say why the errors of a run with so many rows cannot be estimated; empty where they can."""
    if model.library.is_sampled:
        return "not estimated: the errors of values that sampled parts hold are not followed"
    if method.name in BACKENDS:
        return f"not estimated: `{method.name}` is a solver of another package"
    if METHODS[method.name].family is GAUSS:
        return f"not estimated: the steps of `{method.name}` are not followed"
    if not fits(rows, model.row_width + len(model.measured)):
        return TOO_MANY_ROWS
    return ""


def estimated(
    model: LoadedModel, rows: Array, off: Array, doubtful: bool
) -> tuple[dict[str, Array], str]:
    """Judge the errors of outputs, (rows, outputs), that a scene observes or requires.

    Returns them by name, and in words how they were made.
    """
    wanted = {*model.facts.columns, *dict(model.facts.requirements)}
    places = {v.name: k for k, v in enumerate(model.measured) if v.name in wanted}
    values = {name: rows[:, k] for name, k in places.items()}
    return judged(values, {name: off[:, k] for name, k in places.items()}, doubtful)


def with_errors(result: Result, errors: Mapping[str, Array], made: str) -> Result:
    """Add the estimated errors of its columns to a result, and how they were made."""
    own = {name: error for name, error in errors.items() if name in result.columns}
    return replace(result, errors=own, error_estimate=made)


def with_requirements(
    model: LoadedModel,
    result: Result,
    instants: Array,
    rows: Array,
    errors: Mapping[str, Array],
    between: int = 1,
) -> Result:
    """Add to a result how the requirements of its scene are met, with warnings where not.

    The arguments are those of `requirements_of`.
    """
    if not (model.facts.criteria or model.facts.requirements):
        return result
    found = tuple(requirements_of(model, instants, rows, errors, between))
    return replace(result, requirements=found, notices=(*result.notices, *missed(found)))


def raise_where_ended(
    model: LoadedModel, instance: Instance, status: Status, result: Result
) -> None:
    """Raise the error of a run that ended early, with the rows up to there."""
    if status is Status.INTERRUPTED:
        diagnostic = explain(instance, status)
        raise RunInterrupted(diagnostic, result.ended("interrupted", diagnostic.message))
    if status is not Status.OK:
        diagnostic = model.explain(instance, status)
        raise SimulationError(diagnostic, result.ended("failed", diagnostic.message))


def method_of(
    model: LoadedModel,
    given: Solver = _NOT_GIVEN,
    parameters: Mapping[str, ParameterValue] = NOTHING,
) -> tuple[Solver, tuple[Diagnostic, ...]]:
    """Choose the method of a run: the caller's, else the scene's, else the default.

    `solver auto` takes the method that `bgc trade` recommended; where there is no recommendation,
    the default with a notice (BG090). A recommendation was measured without options of the caller,
    which go first.
    """
    method = choose_method(model.library, model.facts, given, BACKENDS)
    if (given.name or model.facts.solver.name) != AUTO or given.given:
        return method, ()
    recommended = recommended_method(model, parameters)
    if recommended is not None:
        return replace(recommended, start=given.start), ()
    return method, (nothing_measured(model.facts.name, method.name),)


def times_of(
    model: LoadedModel,
    method: Solver,
    duration: float | None = None,
    every: float | None = None,
    instances: int = 1,
) -> Array:
    """Times of the rows of a run, s: the caller's, else the scene's.

    Raises BgError where there is no duration or where the rows of all instances would not fit in
    memory.
    """
    return row_times(*_rows_wanted(model, method, duration, every), model.row_width * instances)


def lazy_times_of(
    model: LoadedModel, method: Solver, duration: float | None, every: float | None, room: float
) -> RowTimes:
    """Times of the rows of a run, computed where they are needed; `room` bounds them, bytes."""
    return lazy_times(*_rows_wanted(model, method, duration, every), model.row_width, room)


def _rows_wanted(
    model: LoadedModel, method: Solver, duration: float | None, every: float | None
) -> tuple[float, float | None, float | None]:
    """The duration, the interval between rows, and the step of a fixed-step method, s."""
    facts = model.facts
    end = facts.duration if duration is None else duration
    if end is None:
        raise BgError([no_duration(facts.name)])
    return end, facts.every if every is None else every, method.step if method.fixed else None


@dataclass(frozen=True, slots=True)
class Reached:
    """The state and the device inputs at the end of a run, with the warnings about the run."""

    state: Array
    inputs: Array
    warnings: tuple[Diagnostic, ...]


def state_after(model: LoadedModel, time: float, state: Array | None = None) -> Reached:
    """Run to a time, s, with the scene's method.

    The run starts at `state`, or else at the scene's start. Its energies are not integrated.
    """
    method, notices = method_of(model)
    times = row_times(time, time, None, len(model.measured))
    rows = np.full((len(times), len(model.measured)), np.nan)
    with model.started(method, accounts=False) as instance:
        if state is not None:
            instance.state[:] = state
            require(instance, instance.restart())
        status, _, _ = run_watched(instance, times, rows, progress=False)
    require(instance, status)
    # The last step may end behind the time: its dense output has the state there.
    at_end = instance.time <= time
    reached = instance.state.copy() if at_end else instance.state_at(time)
    inputs = instance.input.copy()
    warned = (*notices, *run_warnings(model, instance, method))
    if state is None and subtolerance_states(instance):
        warned += tuple(rounding_warnings(model, method, np.linspace(0.0, time, _ROWS)))
    return Reached(reached, inputs, warned)


def rounding_warnings(
    model: LoadedModel,
    method: Solver,
    times: Array,
    parameters: Mapping[str, ParameterValue] = NOTHING,
    *,
    cure: bool = True,
) -> Iterator[Diagnostic]:
    """Run to all times, s, and warn of the state that rounding decides (BG726, BG733).

    With `cure`, a tolerance with which it does not is looked for. A run that fails says nothing.
    """
    rows = np.full((len(times), model.row_width), np.nan)
    with model.started(method, bool(model.accounts), parameters) as instance:
        status, _, _ = run_watched(instance, times, rows, progress=False)
        if status is Status.OK:
            found = undecided(model, method, instance, times, rows, parameters, cure=cure)
            if found is not None:
                yield undecided_state(found)


def named_result(
    model: LoadedModel,
    times: Array,
    rows: Array,
    method: Solver,
    instance: Instance,
    notices: Sequence[Diagnostic],
) -> Result:
    """Name the columns of the rows, with the counts and the warnings of their run."""
    counts = instance.counts
    return replace(
        bare_result(model, times, rows, method),
        counts=counts,
        notices=(*notices, *run_warnings(model, instance, method)),
        faster=faster_method(model, method, counts),
    )


def bare_result(model: LoadedModel, times: Array, rows: Array, method: Solver) -> Result:
    """Name the columns of rows, in the scene's order."""
    chosen = model.selection()
    return Result(
        scene=model.facts.name,
        time=times,
        columns={v.name: chosen.column(rows, k) for k, v in enumerate(model.outputs)},
        units={v.name: v.unit for v in model.outputs},
        shown={v.name: v.shown for v in model.outputs},
        shapes=shapes_of(
            model.facts.shapes, {v.name: k for k, v in enumerate(model.measured)}, rows
        ),
        solver=method.name,
        counts={},
        panels=model.facts.plots,
        accounts=model.accounts,
    )


def undecided_state(found: Undecided) -> Diagnostic:
    """Warn of a state that rounding decides (BG726), or that moves below its tolerance (BG733)."""
    subtolerance = found.subtolerance
    cure = None if found.atol is None or found.right is None else (found.atol, found.right)
    if subtolerance.stays_below:
        return moves_below(found.name, subtolerance.tolerance, cure)
    times = subtolerance.fell, subtolerance.grown
    return rounding_decides(found.name, subtolerance.tolerance, times, found.end, cure)
