"""Motion by Lagrange's equations, from the mass matrix and the potential alone.

Both are functions of coordinates that may be complex: derivatives are complex steps, exact to
rounding, and written by nobody.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

Array = npt.NDArray[np.float64]
STEP = 1e-30


def motion(
    mass: Callable[[Array], Array],
    potential: Callable[[Array], float],
    start: Array,
    rates: Array,
    times: Array,
) -> tuple[Array, Array]:
    """Coordinates and their rates, a row each time, of `d/dt(M q') = q'(dM/dq)q'/2 - dV/dq`."""
    size = len(start)
    steps = 1j * STEP * np.eye(size)

    def slope(_: float, state: Array) -> Array:
        q, v = state[:size], state[size:]
        changes = [mass(q + step).imag / STEP for step in steps]
        forces = [
            v @ change @ v / 2 - potential(q + step).imag / STEP
            for change, step in zip(changes, steps, strict=True)
        ]
        turning = sum(change * rate for change, rate in zip(changes, v, strict=True)) @ v
        return np.concatenate([v, np.linalg.solve(mass(q), np.array(forces) - turning)])

    state = np.concatenate([start, rates])
    span = (times[0], times[-1])
    exact = solve_ivp(slope, span, state, "DOP853", times, rtol=1e-12, atol=1e-12)
    assert exact.success
    return exact.y[:size].T, exact.y[size:].T


def of_points(
    *points: tuple[float, Callable[[Array], Array]],
) -> Callable[[Array], Array]:
    """The mass matrix of point masses at positions that are linear in what `jacobian` gives."""

    def mass(q: Array) -> Array:
        return sum(m * jacobian(q).T @ jacobian(q) for m, jacobian in points)

    return mass
