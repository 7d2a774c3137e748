"""The limits of a sampled port: judged before a run, with its numbers then.

A held spring K with a lag of d periods T, between a device of mass m and a load of mass M, is
stable up to K = m_red/(2 T^2 (d + 1)(d + 1/2)), m_red = m M/(m + M), with the damping
K T (d + 1): a fit to simulations with d from 0 to 20, right to a factor of 2. Half is allowed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from bgc.diagnostics.catalogue import ports as messages
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.record_class import astuple, dataclass

NUMBERS = ("stiffness", "damping", "mass", "resolution", "lag", "period")
"""Parameters of a port that its limits depend on, in the order of `PortNumbers`."""
SHORT = 1e-3
"""s, in which a unit of effort changes the states where the acceleration is computed."""
_MOST_NOISE = 0.1  # N: of the damping, by the resolution of the position


@dataclass(frozen=True, slots=True)
class PortNumbers:
    """The numbers of a port: N/m, N s/m, kg, m, periods, s."""

    stiffness: float
    damping: float
    mass: float
    resolution: float
    lag: float
    period: float

    @property
    def is_known(self) -> bool:
        """True where all are finite; others are refused at each reset."""
        return all(map(math.isfinite, astuple(self))) and self.period > 0


def is_in_step(port: PortNumbers, step: float | None) -> bool:
    """True where a port has the period of the scene's devices, s, or there are none."""
    return step is None or math.isclose(step, port.period, rel_tol=1e-9)


def judged(
    span: Span | None,
    name: str,
    port: PortNumbers,
    step: float | None,
    response: tuple[float, float] | None,
) -> Iterator[Diagnostic]:
    """The diagnostics of a port.

    Parameters
    ----------
    step
        The period of the scene's devices, s; None without devices.
    response
        Flow and acceleration of the bond for a unit of effort, the largest of all components;
        None where nothing reads the bond.
    """
    if not port.is_known:
        return
    if not is_in_step(port, step):
        assert step is not None
        yield messages.other_samples(span, name, port.period, step)
        return
    noise = port.damping * port.resolution / port.period
    if noise > _MOST_NOISE:
        yield messages.noisy(span, name, noise, port.damping, port.resolution, port.period)
    if response is None:
        return
    rate, acceleration = response
    if not math.isfinite(rate + acceleration) or acceleration < 0:
        why = "a flow source moves the bond, whatever the effort of the port is"
        yield messages.nothing_behind(span, name, why)
        return
    if rate * (port.stiffness * port.period + 2 * port.damping) > 1:
        why = "its effort moves the bond at once: nothing with a mass is between"
        yield messages.nothing_behind(span, name, why)
        return
    mass, lag = port.mass, port.lag
    behind = math.inf if acceleration == 0 else 1 / acceleration
    reduced = mass if math.isinf(behind) else mass * behind / (mass + behind)
    most = reduced / (4 * port.period**2 * (lag + 1) * (lag + 0.5))
    if port.stiffness > most:
        yield messages.too_stiff(span, name, port.stiffness, most, mass, behind, lag, port.period)


def largest(matrix: list[list[float]]) -> float:
    """The largest eigenvalue of the symmetric part of a matrix; NaN where it has no finite one."""
    if not all(math.isfinite(x) for row in matrix for x in row):
        return math.nan
    if len(matrix) == 1:
        return matrix[0][0]
    import numpy as np  # heavy, and needed by few models

    whole = np.array(matrix)
    return float(np.linalg.eigvalsh(0.5 * (whole + whole.T))[-1])
