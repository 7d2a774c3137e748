"""Roots of equations by a damped Newton method, and equilibria by pseudo-transient continuation.

Variables should be scaled to magnitudes about one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from bgc.runtime.results.arrays import Array

Function: TypeAlias = Callable[[Array], Array]
Tangent: TypeAlias = tuple[Array, NDArray[np.intp]]
"""Changes of all variables by the independent ones, and the numbers of these."""

_ITERATIONS = 200
_HALVINGS = 30
_NO_STEP = 1e-12
_LONGEST_STEP = 1e12  # largest pseudo-time step, in units of the first one
_LONGER = 4.0
_SHORTER = 0.1
_WORSE = 10.0  # growth of the rates for which a step is rejected


def find_zero(residuals: Function, slope: Function, start: Array) -> tuple[Array, Array]:
    """Solve `residuals(x) = 0` by Newton's method; return x and the remaining residuals.

    Steps are halved until the norm of the residuals decreases.
    """
    x, remaining = start, residuals(start)
    for _ in range(_ITERATIONS):
        step = np.linalg.lstsq(slope(x), -remaining, rcond=None)[0]
        fraction = 1.0
        for _ in range(_HALVINGS):
            tried = x + fraction * step
            after = residuals(tried)
            if np.linalg.norm(after) < np.linalg.norm(remaining):
                x, remaining = tried, after
                break
            fraction /= 2
        else:
            break
        if np.abs(step).max(initial=0.0) <= _NO_STEP:
            break
    return x, remaining


def find_equilibrium(
    rates: Function,
    slope: Function,
    mass: Array,
    start: Array,
    project: Function,
    tangent: Callable[[Array], Tangent],
    worse: float = _WORSE,
) -> tuple[Array, Array]:
    """Follow `M x' = rates(x)` into an equilibrium; return x and the remaining rates.

    Pseudo-transient continuation (C. T. Kelley and D. E. Keyes 1998): implicit Euler steps
    `(M/h - slope) dx = rates` with growing h, so that the first steps follow the system roughly
    and the last are Newton steps. Conserved quantities, such as a charge that only circulates or
    the position of a free body, therefore take the values to which the system itself would move.
    `project` is applied after each step. Steps lie in the `tangent` of what it projects onto, where
    the slope across has no meaning. A step for which the rates grow by more than `worse` is tried
    again, shorter: a small bound keeps to one side of a valve that opens.
    """
    x, remaining = start, rates(start)
    first = 1.0 / max(float(np.abs(remaining).max(initial=0.0)), 1e-9)
    time = first
    for _ in range(_ITERATIONS):
        try:
            along, rows = tangent(x)
            matrix = (mass / time - slope(x))[rows] @ along
            step = along @ np.linalg.solve(matrix, remaining[rows])
            tried = project(x + step)
            after = rates(tried)
        except np.linalg.LinAlgError:
            time *= _SHORTER
            continue
        if not np.linalg.norm(after) <= worse * np.linalg.norm(remaining):
            time *= _SHORTER
            continue
        x, remaining = tried, after
        if time >= _LONGEST_STEP * first and np.abs(step).max(initial=0.0) <= _NO_STEP:
            break
        time = min(time * _LONGER, _LONGEST_STEP * first)
    return x, remaining
