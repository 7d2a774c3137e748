"""A consistent start: fast modes at rest on their slow manifold.

Stiff springs start unloaded, and without damping ring for ever; a step then has to follow them.
Settled, they start with the deflections that the slow motion gives them.
"""

from __future__ import annotations

import math

import numpy as np

from bgc.diagnostics.catalogue.run import not_separable, not_settled
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.linear.fast_modes import balancing, fast_projector
from bgc.runtime.linear.state_space import without_algebraic
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Status

_ITERATIONS = 50
_AT_REST = 1e-10  # of the state or the first change, whichever is the larger, both balanced
_ROUNDING = 1e-6  # changes below this that shrink no more are rounding


def settle(instance: Instance, frequency: float) -> Status:
    """Bring the modes faster than a frequency in Hz to rest, the slow ones unchanged.

    With the spectral projector P of the fast modes (eigenvalues beyond 2 pi times the frequency)
    of the Jacobian A, `x <- x - A^-1 P f(x)` until P f vanishes: Newton's method for the leading
    term of the slow manifold (N. Fenichel, J. Differential Equations 31, 1979). States without a
    rate follow their equations.

    Returns the status of an evaluation that failed.

    Raises
    ------
    BgError
        BG717 where the modes do not come to rest nearby or change their number, BG718 where
        rates cannot be solved for.
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
    """The change of all states that takes the fast modes to their rest, what balances the states
    (infinite for those without a rate), and how many modes are fast.
    """
    n = len(rates)
    every, none = np.eye(n), np.zeros((n, 1))
    slope, rate, follow, direct, left_mass, left = without_algebraic(
        jacobian, rates[:, None], every, none, mass
    )
    if not np.array_equal(left_mass, np.eye(len(slope))):
        raise BgError([not_separable()])
    step, scale, fast = _fast_newton(slope, rate[:, 0], limit)
    everywhere = np.full(n, np.inf)
    everywhere[left] = scale
    return follow @ step + direct[:, 0], everywhere, fast


def _fast_newton(slope: Array, rate: Array, limit: float) -> tuple[Array, Array, int]:
    """`-A^-1 P f` with the projector P on the modes of A beyond the limit, what balances A, and
    the number of these modes; not a number where P cannot be told.
    """
    scale = balancing(slope)
    balanced = slope * scale / scale[:, None]
    try:
        projector, fast, between = fast_projector(balanced, limit)
        # P f on the fast modes; what P leaves out stays zero, whatever A makes of it.
        others = between * (np.eye(len(rate)) - projector)
        step = np.linalg.solve(balanced @ projector + others, projector @ (-rate / scale))
    except np.linalg.LinAlgError:
        return np.full(len(rate), np.nan), scale, 0
    return scale * step, scale, fast
