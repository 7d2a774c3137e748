"""A consistent start: fast modes at rest on the slow manifold.

Stiff springs that start unloaded oscillate, without damping for ever, and steps have to resolve
that. A settled start gives them the deflections that the slow motion causes.
"""

from __future__ import annotations

import math

import numpy as np

from bgc.diagnostics.catalogue.starts import not_separable, not_settled
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.linear.fast_modes import balancing, fast_projector
from bgc.runtime.linear.state_space import without_algebraic
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.structures import Status

_ITERATIONS = 50
_AT_REST = 1e-10  # of the larger of the state and the first change, both balanced
_ROUNDING = 1e-6  # changes below this that no longer shrink are rounding


def settle(instance: Instance, frequency: float) -> Status:
    """Bring modes faster than a frequency, Hz, to rest; slow modes are unchanged.

    With the spectral projector P of the fast modes (eigenvalues beyond 2 pi times the frequency)
    of the Jacobian A, `x <- x - A^-1 P f(x)` until P f vanishes: Newton's method for the leading
    term of the slow manifold (N. Fenichel, J. Differential Equations 31, 1979). States without a
    rate follow from their algebraic equations.

    Returns OK, or the status of an evaluation that failed.

    Raises
    ------
    BgError
        BG717 if the modes do not come to rest nearby or change their number, BG718 if the equations
        cannot be solved for the rates.
    """
    status, mass = instance.mass()
    first, before, modes = 0.0, math.inf, -1
    for _ in range(_ITERATIONS):
        if status is not Status.OK:
            return status
        status, rates = instance.rhs()
        if status is not Status.OK:
            return status
        status, jacobian, _ = instance.jacobian()
        if status is not Status.OK:
            return status
        change, scale, fast = _correction(jacobian, rates, mass, 2 * math.pi * frequency)
        if not np.isfinite(change).all() or modes not in (-1, fast):
            break
        modes = fast
        instance.state[:] += change
        size = float(np.linalg.norm(change / scale))
        first = max(first, size)
        whole = max(first, float(np.linalg.norm(instance.state / scale)))
        shrinks = size < 0.5 * before
        if size <= _AT_REST * whole or (size <= _ROUNDING * whole and not shrinks):
            return instance.restart()
        before = size
    raise BgError([not_settled(frequency)])


def _correction(
    jacobian: Array, rates: Array, mass: Array, limit: float
) -> tuple[Array, Array, int]:
    """Compute one Newton step of all states towards rest of the fast modes.

    Returns the step, the scales that balance the states (infinite for those without a rate), and
    the number of fast modes.
    """
    n = len(rates)
    identity, zero = np.eye(n), np.zeros((n, 1))
    slope, rate, follow, direct, kept_mass, kept = without_algebraic(
        jacobian, rates[:, None], identity, zero, mass
    )
    if not np.array_equal(kept_mass, np.eye(len(slope))):
        raise BgError([not_separable()])
    step, scale, fast = _fast_newton(slope, rate[:, 0], limit)
    all_scales = np.full(n, np.inf)
    all_scales[kept] = scale
    return follow @ step + direct[:, 0], all_scales, fast


def _fast_newton(slope: Array, rate: Array, limit: float) -> tuple[Array, Array, int]:
    """Compute `-A^-1 P f` with the projector P on the modes of A beyond the limit.

    Returns also the scales that balance A and the number of these modes. The step is NaN if fast
    and slow modes cannot be separated.
    """
    scale = balancing(slope)
    balanced = slope * scale / scale[:, None]
    try:
        projector, fast, between = fast_projector(balanced, limit)
        # Solve A x = P f on the fast modes; on the others, x stays zero whatever A is.
        others = between * (np.eye(len(rate)) - projector)
        step = np.linalg.solve(balanced @ projector + others, projector @ (-rate / scale))
    except np.linalg.LinAlgError:
        return np.full(len(rate), np.nan), scale, 0
    return scale * step, scale, fast
