"""Sensitivities of a run: the derivatives of its rows by parameters and initial values.

Steps are differentiated in C (`runtime/c/tangents`). The derivative of a start at rest is found
here: by the implicit function where the equations of rest determine the state, and where they leave
it free, as a ship's heading, by differences of the search for rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np

from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.arguments import unknown_parameter
from bgc.diagnostics.catalogue.sensitivities import not_followed, start_not_followed
from bgc.diagnostics.diagnostic import BgError
from bgc.language.methods import METHODS
from bgc.language.scene import Rest
from bgc.language.solver import Solver
from bgc.record_class import dataclass, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.failures import require
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_as
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.rest import go_to_rest
from bgc.runtime.running.rest_algebra import rank_of, row_scales, svd
from bgc.runtime.running.rest_instance import Resting
from bgc.runtime.running.structures import Status
from bgc.runtime.running.tangent_interface import Tangents

# Of a parameter, for a difference of starts, which agree to the rounding of their states: with a
# part of 1e-4, 3e-4 was missing of the derivative of a crane's tip by the width of a stiff boom.
_PART = 2e-3
_USE = "use a Rosenbrock or an explicit method: `rodas5p`, `ros34prw`, `rk4`"

_Model = TypeVar("_Model", bound=LoadedModel)


@dataclass(frozen=True, slots=True)
class Direction:
    """A parameter, or a state by whose initial value a run is differentiated.

    `number` is that of the parameter or the state.
    """

    name: str
    unit: str
    number: int
    is_state: bool = False


def followed(
    model: _Model, method: Solver, names: Sequence[str]
) -> tuple[_Model, tuple[Direction, ...]]:
    """Find what a run is differentiated by, and the same model with its tangents.

    Without names, the model is unchanged. Raises BgError: BG060 for an unknown name, BG784 for a
    method, a start or a model that is not followed.
    """
    if not names:
        return model, ()
    directions = directions_of(model, names)
    require_followed(model, method, directions)
    return with_tangents(model), directions


def with_tangents(model: _Model) -> _Model:
    """Compile the same model with its tangents, or load it from the cache."""
    path, options = model.source_for("sensitivities")
    found = load_as(type(model), path, replace(options, tangents=True), {})
    found.parameters.take(model.parameters)
    return found


def directions_of(model: LoadedModel, names: Sequence[str]) -> tuple[Direction, ...]:
    """Find parameters, all components of a vector, or states by name.

    Raises BgError: BG060 for an unknown name; as for a value of a parameter that was compiled in.
    """
    numbers = {name: k for k, name in enumerate(model.parameters)}
    states = {state.name: (k, state.unit) for k, state in enumerate(model.states)}
    found: dict[str, Direction] = {}
    for name in [names] if isinstance(names, str) else names:
        own = [name] if name in numbers else [p for p in numbers if p.startswith(f"{name}[")]
        for each in own:
            found[each] = Direction(each, model.parameters.unit_of(each), numbers[each])
        if not own and name in states:
            number, unit = states[name]
            found[name] = Direction(name, unit, number, is_state=True)
        elif not own:
            folded = {known.partition("[")[0] for known in model.parameters.folded}
            if name in model.parameters.folded or name in folded:
                model.parameters.unit_of(name)  # raises
            raise BgError([unknown_parameter(name, [*numbers, *states])])
    return tuple(found.values())


def require_followed(model: LoadedModel, method: Solver, directions: Sequence[Direction]) -> None:
    """Raise BG784 for a method or a start that sensitivities do not follow."""
    name = method.name
    if model.facts.fmus:
        reason = f"the FMU of `{model.facts.fmus[0].name}` gives no derivatives"
        help = "run the model twice, with the parameter a little larger and a little smaller"
        raise BgError([not_followed(reason, help)])
    if name in BACKENDS:
        raise BgError([not_followed(f"`{name}` is a solver of another package", _USE)])
    if not METHODS[name].family.lanes:
        raise BgError([not_followed(f"the steps of `{name}` are not differentiated", _USE)])
    rest = model.facts.rest_for(method.start)
    if rest is None and (method.settle or model.facts.solver.settle):
        reason = "`settle` brings fast modes to rest at the start"
        raise BgError([not_followed(reason, "start at rest, or from given values")])
    states = [d.name for d in directions if d.is_state]
    if rest is not None and states:
        reason = f"a start at rest has no initial value of `{states[0]}`"
        raise BgError([not_followed(reason, "start from given values, or name a parameter")])


def begin(
    model: LoadedModel,
    instance: Instance,
    method: Solver,
    parameters: Mapping[str, ParameterValue],
    directions: Sequence[Direction],
) -> Tangents:
    """Find the derivatives at the start, of an instance of a model with tangents that is there."""
    tangents = Tangents(instance, len(directions))
    changes = np.zeros((len(directions), len(model.parameters)))
    states = np.zeros((len(directions), len(model.states)))
    for k, direction in enumerate(directions):
        (states if direction.is_state else changes)[k, direction.number] = 1.0
    rest = model.facts.rest_for(method.start)
    found = np.zeros((len(directions), len(model.states) + len(model.library.held_inputs)))
    names = list(model.parameters)
    varied = tangents.closing if rest is None else [names.index(name) for name in rest.vary]
    for k, direction in enumerate(directions):
        if (rest is not None or varied) and not direction.is_state:
            start = _moved_start(model, parameters, rest, direction, varied)
            found[k], changes[k, varied] = start
    require(instance, tangents.start(changes, states), model.places)
    if rest is not None:
        tangents.states = _at_rest(Resting(instance, rest.sampled), found, tangents.slopes())
    return tangents


def _moved_start(
    model: LoadedModel,
    parameters: Mapping[str, ParameterValue],
    rest: Rest | None,
    direction: Direction,
    varied: Sequence[int],
) -> tuple[Array, Array]:
    """Differences of the start, and of the parameters that are varied for it, by a parameter."""
    info = model.library.model.param[direction.number]
    given = model.parameters.instance(parameters).parameter(direction.number)
    size = len(model.states) + len(model.library.held_inputs)
    states, moved = np.zeros(size), np.zeros(len(varied))
    for value, weight in _difference(given, info.low, info.high):
        instance = model.parameters.instance(parameters)
        instance.set_parameter(direction.number, value)
        status = instance.reset(checked=False)
        try:
            if status is Status.OK and rest is not None:
                status, _ = go_to_rest(instance, rest)
            require(instance, status, model.places)
        except BgError as problem:
            reason = f"at {value:g} {problem.diagnostics[0].message}"
            raise BgError([start_not_followed(direction.name, reason)]) from problem
        states += weight * instance.start_values()
        moved += weight * np.array([instance.parameter(k) for k in varied])
    return states, moved


def _difference(value: float, low: float, high: float) -> list[tuple[float, float]]:
    """Points about a value and their weights in a derivative, of order 4 within the limits."""
    step = (abs(value) or 1.0) * _PART
    if low <= value - 2 * step and value + 2 * step <= high:
        weights = ((-2, 1), (-1, -8), (1, 8), (2, -1))
        return [(value + k * step, weight / (12 * step)) for k, weight in weights]
    first, last = max(low, value - step), min(high, value + step)
    return [(first, -1 / (last - first)), (last, 1 / (last - first))]


def _at_rest(resting: Resting, changes: Array, slopes: Array) -> Array:
    """Changes of a state of rest, corrected so that it remains one to the first order.

    Its rates, with those of sampled values, and the rows of closed chains remain zero. `changes`
    are near, (directions, states + held); `slopes` are those of `Tangents.slopes`. The correction
    is the least one in the scales of the states.
    """
    instance, states = resting.instance, resting.own
    status, by_state = resting.slope()
    require(instance, status)
    status, closing, rows_of_chains = resting.chain_rows()
    require(instance, status)
    _, _, periods = instance.next_held()
    jacobian = np.vstack([by_state, rows_of_chains])
    rates, rows, held = np.split(slopes, [states, states + len(closing)], axis=1)
    sampled = held[:, resting.numbers] / periods[resting.numbers]
    own = [*range(states), *(states + number for number in resting.numbers)]

    matrix = jacobian * resting.scale
    sizes = row_scales(matrix)
    left, values, right = svd(matrix / sizes[:, None], full=False)
    count = rank_of(values, 0.0)
    inverse = (right[:count].T / values[:count]) @ left[:, :count].T
    found = changes.copy()
    remaining = (found[:, own] @ jacobian.T + np.hstack([rates, sampled, rows])) / sizes
    found[:, own] -= (remaining @ inverse.T) * resting.scale
    return found
