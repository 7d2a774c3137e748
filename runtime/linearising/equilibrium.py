"""Roots of equations: a damped Newton method, and the way into an equilibrium.

Variables should be scaled to sizes about one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from bgc.runtime.results.arrays import Array

Function: TypeAlias = Callable[[Array], Array]

_ITERATIONS = 200
_HALVINGS = 30
_NO_STEP = 1e-12
_LONGEST = 1e12  # pseudo-time step, in the time that the first step of size one takes
_LONGER = 4.0
_SHORTER = 0.1
_WORSE = 10.0  # of the rates, from one step to the next, is too much


def find_zero(residuals: Function, slope: Function, start: Array) -> tuple[Array, Array]:
    """Solve `residuals(x) = 0` by Newton's method; returns x and what is left of the residuals.

    Steps are halved until the residuals shrink.
    """
    x, left = start, residuals(start)
    for _ in range(_ITERATIONS):
        step = np.linalg.lstsq(slope(x), -left, rcond=None)[0]
        fraction = 1.0
        for _ in range(_HALVINGS):
            tried = x + fraction * step
            after = residuals(tried)
            if np.linalg.norm(after) < np.linalg.norm(left):
                x, left = tried, after
                break
            fraction /= 2
        else:
            break
        if np.abs(step).max(initial=0.0) <= _NO_STEP:
            break
    return x, left


def find_rest(
    rates: Function, slope: Function, mass: Array, start: Array, project: Function
) -> tuple[Array, Array]:
    """Follow `M x' = rates(x)` until it rests; returns x and what is left of the rates.

    Implicit Euler steps `(M/h - slope) dx = rates` with h growing beyond all bounds, so that the
    first follow the system roughly and the last are Newton's (pseudo-transient continuation;
    Kelley and Keyes 1998). What the system conserves, a charge that only circulates or a place
    that nothing holds, therefore ends as the system itself would leave it. `project` is applied
    after each step.
    """
    x, left = start, rates(start)
    first = 1.0 / max(float(np.abs(left).max(initial=0.0)), 1e-9)
    time = first
    for _ in range(_ITERATIONS):
        try:
            step = np.linalg.solve(mass / time - slope(x), left)
            tried = project(x + step)
            after = rates(tried)
        except np.linalg.LinAlgError:
            time *= _SHORTER
            continue
        if not np.linalg.norm(after) <= _WORSE * np.linalg.norm(left):
            time *= _SHORTER
            continue
        x, left = tried, after
        if time >= _LONGEST * first and np.abs(step).max(initial=0.0) <= _NO_STEP:
            break
        time = min(time * _LONGER, _LONGEST * first)
    return x, left
