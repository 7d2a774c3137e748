"""Ringing that no method followed.

An L-stable method takes a mode that rings faster than its steps to rest at once, whether the mode
is damped or not; two such methods agree on what is not so. From the eigenvalues at the start it can
be told which modes last, and what they would add to what is observed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.linear.fast_modes import balancing
from bgc.runtime.linear.state_space import without_algebraic
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Status
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.run import Method

_MOST = 400  # states: beyond, eigenvalues take too long


@dataclass(frozen=True, slots=True, eq=False)
class Ringing:
    """A mode excited at the start.

    `frequency` in Hz; `swings` by which it turns and `seconds` until it has died away, or the run
    is over; `amplitude` in each observed quantity, in its unit.
    """

    frequency: float
    swings: float
    seconds: float
    amplitude: Array


def ringing_at_start(model: LoadedModel, duration: float) -> tuple[Ringing, ...]:
    """The modes that ring at the start of a run, as far as they can be told.

    By the eigenvectors v of the Jacobian A, the start is off the rest of a mode by its part of
    A^-1 f.
    """
    try:
        with model.started(Method("rodas5p", fixed=False), accounts=False) as instance:
            return _modes(instance, duration) if len(instance.state) <= _MOST else ()
    except (BgError, np.linalg.LinAlgError):
        return ()


def _modes(instance: Instance, duration: float) -> tuple[Ringing, ...]:
    (good, mass), (fine, rates), (well, jacobian, _) = (
        instance.mass(),
        instance.rhs(),
        instance.jacobian(),
    )
    n = len(rates)
    if {good, fine, well} != {Status.OK} or not n or not np.isfinite(jacobian).all():
        return ()
    slope, rate, follow, _, left_mass, _ = without_algebraic(
        jacobian, rates[:, None], np.eye(n), np.zeros((n, 1)), mass
    )
    if not np.array_equal(left_mass, np.eye(len(slope))):
        return ()
    scale = balancing(slope)
    values, vectors = np.linalg.eig(slope * scale / scale[:, None])
    parts = np.linalg.solve(vectors, rate[:, 0] / scale)
    found = []
    for value, vector, part in zip(values, vectors.T, parts, strict=True):
        if value.imag > 0:
            away = follow @ (scale * vector) * (2 * part / value)
            seconds = min(duration, -1 / value.real) if value.real < 0 else duration
            swings = seconds * value.imag / math.tau
            amplitude = _seen(instance, away)
            found.append(Ringing(value.imag / math.tau, swings, seconds, amplitude))
    return tuple(found)


def _seen(instance: Instance, away: Array) -> Array:
    """What moving the state by the complex amplitude of a mode makes of the outputs."""
    start = instance.state.copy()
    _, before = instance.outputs()
    moved = []
    for part in (away.real, away.imag):
        instance.state[:] = start + part
        _, after = instance.outputs()
        moved.append(after - before)
    instance.state[:] = start
    with np.errstate(all="ignore"):
        size: Array = np.hypot(*moved)
    return np.where(np.isfinite(size), size, 0.0)
