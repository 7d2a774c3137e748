"""Oscillations that no method resolved.

An L-stable method damps a mode faster than its steps at once, whether the mode is damped or not,
and two such methods agree on a wrong solution. The eigenvalues at the start show which modes last,
and how much they add to the observed quantities.
"""

from __future__ import annotations

import math

import numpy as np

from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.linear.fast_modes import balancing
from bgc.runtime.linear.state_space import without_algebraic
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.structures import Status

_MOST_STATES = 400  # states: with more, eigenvalues take too long


@dataclass(frozen=True, slots=True, eq=False)
class Ringing:
    """A mode excited at the start.

    `frequency` is in Hz. It oscillates for so many `periods` or `seconds` until it has decayed or
    the run ends; `amplitude` is that of each observed quantity, in its unit.
    """

    frequency: float
    periods: float
    seconds: float
    amplitude: Array


def ringing_at_start(model: LoadedModel, duration: float) -> tuple[Ringing, ...]:
    """Find the modes that oscillate at the start of a run.

    The start deviates from the equilibrium of a mode by the component of A^-1 f along its
    eigenvector, with the Jacobian A. Empty if this cannot be computed.
    """
    try:
        with model.started(Solver("rodas5p"), accounts=False) as instance:
            return _modes(instance, duration) if len(instance.state) <= _MOST_STATES else ()
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
            periods = seconds * value.imag / math.tau
            amplitude = _observed(instance, away)
            found.append(Ringing(value.imag / math.tau, periods, seconds, amplitude))
    return tuple(found)


def _observed(instance: Instance, away: Array) -> Array:
    """Compute the amplitude of the outputs from the complex amplitude of a mode in the states."""
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
