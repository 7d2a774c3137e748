"""The limits of sampled ports at the values that a run has, where these are not the defaults."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bgc.building.build_result import Places, RunFacts
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity
from bgc.ir.port_facts import PortFacts
from bgc.language.port_limits import NUMBERS, SHORT, PortNumbers, is_in_step, judged, largest
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.structures import Status


def require_ports(instance: Instance, facts: RunFacts, places: Places) -> tuple[Diagnostic, ...]:
    """Check the sampled ports of an instance at its start; return the warnings.

    The compiler has checked them with the defaults of all parameters and the step of the scene:
    with those nothing is done.

    Raises BgError BG471, BG472, BG474 for a port that cannot be stable.
    """
    found = port_diagnostics(instance, facts, places)
    errors = [d for d in found if d.severity is Severity.ERROR]
    if errors:
        raise BgError(errors)
    return found


def port_diagnostics(instance: Instance, facts: RunFacts, places: Places) -> tuple[Diagnostic, ...]:
    """The diagnostics of the sampled ports of an instance, without those that were compiled."""
    if not facts.ports:
        return ()
    index = parameter_places(instance)
    folded = dict(facts.folded)
    step = instance.sample_period or None  # 0: the model samples no devices
    changed = _is_changed(instance)
    found: list[Diagnostic] = []
    for port, place in zip(facts.ports, places.ports, strict=True):
        values = (number_of(instance, index, folded, f"{port.name}.{n}") for n in NUMBERS)
        numbers = PortNumbers(*values)
        # The step of a run may differ from that of the scene, and devices are read at it.
        if changed or not is_in_step(numbers, step):
            found += judged(place.span, port.name, numbers, step, _response(instance, port))
    return tuple(found)


def parameter_places(instance: Instance) -> dict[str, int]:
    """The places of the parameters by name."""
    model = instance.library.model
    return {text(model.param[k].name): k for k in range(model.n_param)}


def number_of(
    instance: Instance, index: Mapping[str, int], folded: Mapping[str, float], path: str
) -> float:
    """The present value of a parameter, also of one that was compiled in; 0 where there is none."""
    place = index.get(path)
    return folded.get(path, 0.0) if place is None else instance.parameter(place)


def _is_changed(instance: Instance) -> bool:
    model = instance.library.model
    return any(instance.parameter(k) != model.param[k].value for k in range(model.n_param))


def _response(instance: Instance, port: PortFacts) -> tuple[float, float] | None:
    """The largest flow and acceleration of the bond for a unit of effort; see `judged`."""
    if not port.moved:
        return None
    state, inputs = instance.state, instance.input
    start = state.copy()
    answer, mass = instance.mass()
    moved = list(port.moved)
    steps, pushes = [], []
    begin = _rates(instance)
    if begin is None or answer is not Status.OK:
        return None
    for effort in port.efforts:
        inputs[effort] += 1.0
        pushed = _rates(instance)
        inputs[effort] -= 1.0
        if pushed is None:
            return None
        change = np.linalg.lstsq(mass, pushed - begin, rcond=None)[0]
        state += SHORT * change
        later = _rates(instance)
        state[:] = start
        if later is None:
            return None
        steps.append([float(change[k]) for k in moved])
        pushes.append([float(later[k] - begin[k]) / SHORT for k in moved])
    return largest(steps), largest(pushes)


def _rates(instance: Instance) -> Array | None:
    status, rates = instance.rhs()
    return np.array(rates) if status is Status.OK else None
