"""Compare the operations of an explicit step with those of an implicit one.

The runtime's method `switching` takes explicit steps where nothing is stiff. Whether these cost
less depends on the model alone: an implicit step evaluates and factorises the Jacobian besides.
"""

from __future__ import annotations

from collections.abc import Mapping

from bgc.emission.factorisation import factor_share
from bgc.ir.lowered import Lowered

# Stages of a step of rodas5p, and evaluations of f in a step of dopri5, whose last is the first of
# the next step.
_IMPLICIT, _EXPLICIT = 8, 6
_STAGE, _SUM = 40.0, 8.0  # operations that a stage costs besides f; the latter per state
# Calls of other functions in either step, most of them at points within it.
_CALLS = {"energy": 5, "switches": 5, "watched": 5, "divisors": 5, "asserts": 1, "project": 8}
_STEP, _POINT = 500.0, 6.0  # operations of a step besides; of its state at a point, per state
_WORTHWHILE = 0.6  # explicit steps are shorter: by up to 1.7 at loose tolerances


def explicit_cost(lowered: Lowered, operations: Mapping[str, int]) -> float | None:
    """Divide the cost of a step of dopri5 by that of a step of rodas5p.

    `operations` are those of one call of each function, as `EmittedModel` has them. Returns None
    where explicit steps are not worth while, or impossible: M is not the identity.
    """
    program = lowered.program
    if program.mass is not None or not program.states:
        return None
    stage, beside = (count(lowered, operations) for count in (stage_operations, attempt_operations))
    matrix = factor_share(lowered) * (operations["factor"] + _IMPLICIT * operations["solve"])
    implicit = beside + _IMPLICIT * stage + operations["jacobian"] + matrix
    ratio = round((beside + _EXPLICIT * stage) / implicit, 2)
    return ratio if ratio <= _WORTHWHILE else None


def stage_operations(lowered: Lowered, operations: Mapping[str, int]) -> float:
    """Operations of a stage of either method, but for its linear system."""
    return operations["rhs"] + _STAGE + _SUM * len(lowered.program.states)


def attempt_operations(lowered: Lowered, operations: Mapping[str, int]) -> float:
    """Operations of an attempt at a step beside its stages, J and LU."""
    states = len(lowered.program.states)
    return _STEP + sum(
        calls * (operations[name] + _POINT * states)
        for name, calls in _CALLS.items()
        if operations.get(name)
    )
