"""A whole run of a model, from the choice of its method to its named columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.accuracy import (
    limited_by_rounding,
    rounding_decides,
    samples_over_budget,
    step_too_long,
)
from bgc.diagnostics.catalogue.arguments import no_duration
from bgc.diagnostics.catalogue.physics import negative_value
from bgc.diagnostics.catalogue.trade import nothing_measured
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest import AtRest
from bgc.runtime.results.result import Result
from bgc.runtime.results.shapes import shapes_of
from bgc.runtime.running.advice import faster_method
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.devices import NO_CHOICES, Choices
from bgc.runtime.running.failures import RunInterrupted, SimulationError, explain, require
from bgc.runtime.running.faint import Undecided, undecided
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.ports import port_diagnostics
from bgc.runtime.running.recommended import recommended_method
from bgc.runtime.running.rows import row_times
from bgc.runtime.running.run import Method, choose_method, run_watched
from bgc.runtime.running.structures import Status

_NONE: Mapping[str, ParameterValue] = MappingProxyType({})
_ROUNDED = 0.25  # of the steps examined: rounding limits them in a large part of the run
_NO_OPTIONS: Mapping[str, float | None] = MappingProxyType({})


def simulate(
    model: LoadedModel,
    method: Method,
    times: Array,
    parameters: Mapping[str, ParameterValue] = _NONE,
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
    devices: Choices = NO_CHOICES,
) -> Result:
    """Run from the initial state to all times, s, and name the columns.

    `notices` are warnings about the method, to be shown with the result. `devices` override
    drivers of the scene.

    Raises
    ------
    SimulationError, RunInterrupted
        The run ended early; `result` holds the rows up to there.
    BgError
        A parameter is at fault, or there is no initial state.
    """
    rows = np.full((len(times), model.row_width), np.nan)
    capped = method.with_capped_step(times, model.facts.timed)
    at_rest: list[AtRest] = []
    begun = model.started(capped, bool(model.accounts), parameters, at_rest.append, devices)
    with begun as instance:
        notices = (*notices, *port_diagnostics(instance, model.facts, model.places))
        status, done, interrupted = run_watched(instance, times, rows, progress)
    result = named_result(model, times[:done], rows[:done], method, instance, notices)
    result = replace(result, at_rest=at_rest[0]) if at_rest else result
    if interrupted or status is Status.INTERRUPTED:
        diagnostic = explain(instance, Status.INTERRUPTED)
        raise RunInterrupted(diagnostic, result.ended("interrupted", diagnostic.message))
    if status is not Status.OK:
        diagnostic = model.explain(instance, status)
        raise SimulationError(diagnostic, result.ended("failed", diagnostic.message))
    rounded = undecided(model, capped, instance, times, rows, parameters)
    return result if rounded is None else result.noted(_undecided(rounded))


def method_of(
    model: LoadedModel,
    solver: str | None = None,
    options: Mapping[str, float | None] = _NO_OPTIONS,
    parameters: Mapping[str, ParameterValue] = _NONE,
) -> tuple[Method, tuple[Diagnostic, ...]]:
    """Choose the method of a run: the caller's, else the scene's, else the default.

    `options` are those of a `solver` statement by name, SI; None for one that is not given.
    `solver auto` takes the method that `bgc trade` recommended; where there is no recommendation,
    the default with a notice (BG090).
    """
    method = choose_method(model.library, model.facts, solver, options, BACKENDS)
    if not method.auto:
        return method, ()
    recommended = recommended_method(model, parameters)
    if recommended is not None:
        return recommended, ()
    return method, (nothing_measured(model.facts.scene, method.name),)


def times_of(
    model: LoadedModel,
    method: Method,
    duration: float | None = None,
    every: float | None = None,
    instances: int = 1,
) -> Array:
    """Times of the rows of a run, s: the caller's, else the scene's.

    Raises BgError where there is no duration or where the rows of all instances would not fit in
    memory.
    """
    facts = model.facts
    end = facts.duration if duration is None else duration
    if end is None:
        raise BgError([no_duration(facts.scene)])
    interval = facts.every if every is None else every
    step = method.step if method.fixed else None
    return row_times(end, interval, step, model.row_width * instances)


def state_after(model: LoadedModel, time: float, state: Array | None = None) -> tuple[Array, Array]:
    """Run to a time, s, with the scene's method; return the state and the device inputs then.

    The run starts at `state`, or else at the scene's start.
    """
    method, _ = method_of(model)
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
    return reached, instance.input.copy()


def named_result(
    model: LoadedModel,
    times: Array,
    rows: Array,
    method: Method,
    instance: Instance,
    notices: Sequence[Diagnostic],
) -> Result:
    """Name the columns of the rows, in the scene's order."""
    counts = instance.counts
    chosen = model.selection()
    return Result(
        scene=model.facts.scene,
        time=times,
        columns={v.name: chosen.column(rows, k) for k, v in enumerate(model.outputs)},
        units={v.name: v.unit for v in model.outputs},
        shown={v.name: v.shown for v in model.outputs},
        shapes=shapes_of(
            model.facts.shapes, {v.name: k for k, v in enumerate(model.measured)}, rows
        ),
        solver=method.name,
        counts=counts,
        panels=model.facts.panels,
        accounts=model.accounts,
        notices=(*notices, *_warnings(model, instance, counts, method)),
        faster=faster_method(model, method, counts),
    )


def _undecided(found: Undecided) -> Diagnostic:
    """Warn of a state that rounding decides (BG726)."""
    faint = found.faint
    cure = None if found.atol is None or found.right is None else (found.atol, found.right)
    times = faint.fell, faint.grown
    return rounding_decides(found.name, faint.tolerance, times, found.end, cure)


def _warnings(
    model: LoadedModel, instance: Instance, counts: Mapping[str, float], method: Method
) -> Iterator[Diagnostic]:
    """Warn of parameters set to negative values, of steps too long, and of rounding.

    The codes are BG460; BG719 and BG730; BG731.
    """
    for name, what, element in model.facts.passive:
        value = model.parameters.turned_negative(instance, name)
        if value is not None:
            yield negative_value(None, element, what, value, f", as `{name}` is given")
    if counts["largest_correction"] > 0:
        state = model.states[int(counts["correction_state"])].name
        yield step_too_long(
            counts["correction_time"], state, counts["largest_correction"], method.step
        )
    if counts["rounding"] >= max(2, _ROUNDED * counts["rounding_samples"]):
        yield limited_by_rounding(int(counts["rounding"]), int(counts["rounding_samples"]))
    if counts["over_budget"]:
        yield samples_over_budget(
            int(counts["over_budget"]),
            method.step,
            method.substeps or model.library.methods[method.name].substeps,
            counts["excess_time"],
            counts["largest_excess"],
        )
