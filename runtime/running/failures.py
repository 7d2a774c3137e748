"""Errors of a run: from a status of the C runtime to a diagnostic."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, assert_never

from bgc.building.build_result import Place, Places
from bgc.diagnostics.catalogue import closures, jumps, physics, run, samples, sensitivities, starts
from bgc.diagnostics.catalogue.arguments import parameter_out_of_range
from bgc.diagnostics.catalogue.fmu_parts import fmu_failed
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.elements import INITIAL_VALUE
from bgc.runtime.results.result import Result
from bgc.runtime.results.runs import Interrupted
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.structures import Status

_NOWHERE = Places()
_MESSAGE_LENGTH = 300  # characters of a driver's message


class SimulationError(BgError):
    """A run that ended early; `result` holds the rows up to there."""

    def __init__(self, diagnostic: Diagnostic, result: Result) -> None:
        super().__init__([diagnostic])
        self.result = result


class RunInterrupted(Interrupted):
    """Ctrl-C during a run; `result` holds the rows up to there, `diagnostic` is its message."""

    def __init__(self, diagnostic: Diagnostic, result: Result) -> None:
        super().__init__(diagnostic.message, result)
        self.diagnostic = diagnostic


def explain(instance: Instance, status: Status, places: Places = _NOWHERE) -> Diagnostic:
    """Make the diagnostic of a failed instance, with its model's names and source positions."""
    model = instance.library.model
    time = instance.time
    match status:
        case Status.STEP_TOO_SMALL:
            return run.step_too_small(time, _state_at_fault(instance))
        case Status.TOO_MANY_STEPS:
            return run.too_many_steps(time, _state_at_fault(instance))
        case Status.NOT_FINITE:
            return run.not_finite(time, _state_at_fault(instance))
        case Status.SINGULAR:
            return run.singular(time, _state_at_fault(instance))
        case Status.ASSERTION:
            place = _at(places.assertions, instance.failed("assertion"))
            message = text(model.assertion[instance.failed("assertion")])
            return run.assertion_failed(time, message, place.span)
        case Status.DEVICE:
            names = [text(model.device[k].name) for k in range(model.n_device)]
            index = instance.failed("device")
            at_fault = names[index : index + 1]
            return run.device_failed(time, at_fault or names, quotable(instance.device_reason))
        case Status.BAD_PARAMETER:
            return _bad_parameter(instance, places)
        case Status.INTERRUPTED:
            return run.interrupted(time)
        case Status.NO_MEMORY:
            return run.no_memory()
        case Status.NOT_EXPLICIT:
            return run.not_explicit()
        case Status.INCONSISTENT:
            state = _state_at_fault(instance)
            through = next((through for torn, through in places.loops if state in torn), ())
            return run.inconsistent(time, state, through)
        case Status.NOT_CONVERGED:
            return run.not_converged(time)
        case Status.CHATTERING:
            place = _at(places.switches, instance.failed("switch"))
            return run.chattering(time, place.states, place.span)
        case Status.VANISHING:
            place = _at(places.divisors, instance.failed("divisor"))
            what = text(model.divisor[instance.failed("divisor")])
            return run.divisor_vanishes(instance.failed_time, what, place.states, place.span)
        case Status.SINGULAR_CHAIN:
            parts, position = instance.failed_chain, instance.chain_position
            return closures.singular_chain(time, parts, list(position.items()))
        case Status.OPEN_CHAIN:
            return closures.open_chain(instance.failed_condition)
        case Status.ENDLESS_JUMPS:
            return jumps.endless_jumps(time, _at(places.jumps, instance.failed("jump")).span)
        case Status.BAD_SAMPLE:
            place = _at(places.held, instance.failed("held"))
            return samples.bad_sample(time, place.states, place.span)
        case Status.FMU:
            index = instance.failed("fmu")
            fmu = instance.library.fmus[index]
            reason = quotable(instance.fmu_reason)
            return fmu_failed(time, fmu.file, fmu.name, reason, _at(places.fmus, index).span)
        case Status.GRAZING | Status.SIMULTANEOUS:
            place = _at(places.switches, instance.failed("switch"))
            grazes = status is Status.GRAZING
            made = sensitivities.grazing if grazes else sensitivities.simultaneous
            return made(time, place.states, place.span)
        case Status.OK | Status.BAD_ARGUMENT:
            raise AssertionError(f"the runtime returned {status.name}")
        case _:
            assert_never(status)


def require(instance: Instance, status: Status, places: Places = _NOWHERE) -> None:
    """Raise a BgError unless the status is OK."""
    if status is not Status.OK:
        raise BgError([explain(instance, status, places)])


def quotable(message: str) -> str:
    """Make a driver's message, which may quote its file, safe for a terminal."""
    shown = "".join(c if c.isprintable() else repr(c)[1:-1] for c in message)
    return shown if len(shown) <= _MESSAGE_LENGTH else f"{shown[:_MESSAGE_LENGTH]}..."


def _at(places: Sequence[Place], index: int) -> Place:
    return places[index] if 0 <= index < len(places) else Place(None)


def _state_at_fault(instance: Instance) -> str | None:
    index = instance.failed("state")
    return text(instance.library.model.state[index].name) if index >= 0 else None


def _bad_parameter(instance: Instance, places: Places) -> Diagnostic:
    model = instance.library.model
    index = instance.failed("parameter")
    if index == model.n_param + model.n_check:
        return starts.no_start(places.start)
    if index > model.n_param + model.n_check:
        place = places.given[index - model.n_param - model.n_check - 1]
        variable, name = place.states
        if variable == INITIAL_VALUE:
            return starts.projected_start(place.span, name)
        return starts.missed_start(place.span, variable, name)
    if index >= model.n_param:
        message = text(model.param_check[index - model.n_param])
        element = _at(places.checks, index - model.n_param).span
        if element is not None:
            return physics.turned_asymmetric(element, message)
        return run.parameters_refused(message, _refused_alone(instance, index))
    info = model.param[index]
    value = instance.parameter(index)
    numbers = value, info.low, info.high
    origins = origins_of(
        model, places, index, lambda k: bool(instance.parameter(k) != model.param[k].value)
    )
    names = [text(model.param[k].name) for k in origins]
    spans = [places.parameters[k].span for k in (*origins[:1], index)] if origins else []
    return parameter_out_of_range(text(info.name), text(info.unit), *numbers, names, *spans)


def _refused_alone(instance: Instance, check: int) -> list[str]:
    """Names of the parameters that were set each of which fails a check alone."""
    found = []
    for k, given in instance.given.items():
        alone = Instance(instance.library)
        alone.set_parameter(k, given)
        refused = alone.reset(instance.time) is Status.BAD_PARAMETER
        if refused and alone.failed("parameter") == check:
            found.append(text(instance.library.model.param[k].name))
    return found


def origins_of(
    model: Any, places: Places, index: int, is_changed: Callable[[int], bool]
) -> list[int]:
    """The parameters of a C model that a parameter's value follows from: those that a run changes,
    else all.

    Only the outermost are named, those whose own values follow from no others of them; none where
    the value of the parameter is its own.
    """
    if index >= len(places.parameters):
        return []
    numbers = {text(model.param[k].name): k for k in range(model.n_param)}

    @cache
    def outermost(index: int) -> list[int]:
        read = [numbers[name] for name in places.parameters[index].states]
        found = list(dict.fromkeys(origin for each in read for origin in outermost(each)))
        changed = [k for k in found if is_changed(k)]
        return changed or ([index] if is_changed(index) or not found else found)

    return [k for k in outermost(index) if k != index]
