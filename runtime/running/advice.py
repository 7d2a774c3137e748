"""Advice on the method, from the counts of a run: whether an explicit method would be faster.

A run of a Rosenbrock method has a bound on the spectral radius of its Jacobian, from which follow
the steps that an explicit method needs for its stability. It also knows how many steps its own
error control would have taken where nothing else (rows, samples) shortened them. With the
operations of the model's functions these give the cost of both methods.
`tests/bench/explicit.py` compares the advice with runs of the library and of the published
problems.
"""

from __future__ import annotations

from collections.abc import Mapping

from bgc.language.methods import METHODS, ROSENBROCK, SWITCHING, SWITCHING_FIXED, Method
from bgc.language.solver import Solver
from bgc.runtime.running.loaded_model import LoadedModel

_WORTHWHILE = 0.6  # predicted time of the explicit method over that of the run
_FEWEST_STEPS = 100  # of a run that is long enough for its time to matter
_MORE_STEPS = 2.0  # of dopri5 to those of rodas5p at the same tolerance
_STABLE = 2.5  # length of an explicit step times the spectral radius, at most
_RESOLVED = 0.5  # the same of a fixed step that resolves every motion
_STAGE = 30.0  # operations that a stage costs besides f, and per state:
_SUM = 8.0


def faster_method(model: LoadedModel, method: Solver, counts: Mapping[str, float]) -> str:
    """Name an explicit method that would take at most 60 % of the time; empty where none would.

    `counts` are those of a run of `model` by `method`.
    """
    info = METHODS.get(method.name)
    steps = counts["steps"] + counts["rejected"]
    if (
        info is None
        or info.name in (SWITCHING, SWITCHING_FIXED)
        or info.family is not ROSENBROCK
        or counts["steps"] < _FEWEST_STEPS
        or not model.facts.operations
        or not counts["fastest"] > 0
    ):
        return ""
    operations = dict(model.facts.operations)
    if info.fixed:
        if counts["fastest"] * method.step > _RESOLVED or counts["subdivided"]:
            return ""
        name, predicted = "rk4", steps
    else:
        name = "dopri5"
        needed = _MORE_STEPS * counts["controlled_steps"]
        predicted = max(steps, needed, counts["stiffness"] / _STABLE)
    explicit = _cost(model, METHODS[name], operations, 0.0)
    jacobians = counts["jacobians"] / steps
    ratio = predicted * explicit / (steps * _cost(model, info, operations, jacobians))
    return name if ratio <= _WORTHWHILE else ""


def _cost(
    model: LoadedModel, info: Method, operations: Mapping[str, int], jacobians: float
) -> float:
    """Operations of a step; `jacobians` are evaluated and factorised in one, on average."""
    stage = operations["rhs"] + _STAGE + _SUM * len(model.states)
    if not info.family.jacobian:
        return info.stages * stage
    matrix = operations["jacobian"] + operations["factor"]
    return info.stages * (stage + operations["solve"]) + jacobians * matrix
