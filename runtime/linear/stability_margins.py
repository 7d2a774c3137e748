"""Stability margins of a loop with unit negative feedback."""

from __future__ import annotations

import math

import numpy as np

from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.linear.feedback import close_loop
from bgc.runtime.linear.frequency import Response, frequency_response
from bgc.runtime.linear.landmarks import Landmark
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.results.html import Tabled

_DECADES = 12  # beyond the modes, in which a crossover is looked for
_RIGHT = 1e-9  # of the largest eigenvalue: real parts below it are rounding


@dataclass(frozen=True, slots=True, repr=False)
class Margins(Tabled):
    """Margins of `L(i omega)`, an open loop, and the poles of the loops right of the axis.

    Attributes
    ----------
    gain, phase
        The crossovers, by rising frequency, as landmarks with their margins in dB and degrees.
    delay
        The dead time, s, at which the closed loop reaches the limit of stability; infinite where
        the magnitude nowhere crosses 1, NaN where the closed loop is not stable without it.
    modulus
        The least distance of L from -1, the inverse of the largest sensitivity.
    modulus_omega
        The frequency of that, rad/s.
    open_right, closed_right
        Numbers of poles with a positive real part of the open and the closed loop.
    """

    gain: tuple[Landmark, ...]
    phase: tuple[Landmark, ...]
    delay: float
    modulus: float
    modulus_omega: float
    open_right: int
    closed_right: int

    @property
    def encirclements(self) -> int:
        """Clockwise encirclements of -1 by the Nyquist curve: `closed_right - open_right`."""
        return self.closed_right - self.open_right

    def tables(self) -> list[Table]:
        """The one of `table`."""
        return [self.table()]

    def table(self) -> Table:
        """The margins of the loop, and whether it is stable."""
        rows: list[tuple[str, str, str]] = [
            (mark.kind, f"{mark.amount:.5g} {unit}", f"{mark.omega:.6g}")
            for marks, unit in ((self.gain, "dB"), (self.phase, "deg"))
            for mark in marks
        ]
        if math.isfinite(self.delay):
            rows.append(("delay margin", f"{self.delay:.5g} s", ""))
        peak = 1 / self.modulus if self.modulus else math.inf
        rows += [
            ("least distance from -1", f"{self.modulus:.5g}", f"{self.modulus_omega:.6g}"),
            ("largest sensitivity", f"{peak:.5g}", f"{self.modulus_omega:.6g}"),
            ("unstable poles, open loop", str(self.open_right), ""),
            ("unstable poles, closed loop", str(self.closed_right), ""),
        ]
        verdict = "unstable" if self.closed_right else "stable"
        return Table(f"the closed loop is {verdict}", ("", "value", "at rad/s"), tuple(rows))


def margins(linear: Linearisation, response: Response | None = None) -> Margins:
    """Compute the margins of an open loop with one input and one output.

    The crossovers are those in the range of `response`, by default that of `loop_response`.
    """
    response = response or loop_response(linear)
    phase = tuple(mark for mark in response.landmarks if mark.kind == "phase margin")
    gain = tuple(mark for mark in response.landmarks if mark.kind == "gain margin")
    closed_right = _right(close_loop(linear))
    delay = math.nan if closed_right else min((_delay(mark) for mark in phase), default=math.inf)
    omega, modulus = _nearest(linear, response)
    return Margins(gain, phase, delay, modulus, omega, _right(linear), closed_right)


def loop_response(
    linear: Linearisation, low: float | None = None, high: float | None = None
) -> Response:
    """Compute the response of an open loop from `low` to `high`, rad/s, with all its crossovers.

    By default the range is that of `frequency_response`, and as many decades more on both sides as
    the magnitude takes to cross 1: a loop of high gain crosses far beyond its fastest mode.
    """
    found = frequency_response(linear, low, high)

    def size(omega: float) -> float:
        return float(abs(linear.response(np.array([omega]))[0, 0, 0]))

    def beyond(end: float, step: float) -> float | None:
        """The first decade from `end` on beyond 1; None if the magnitude stays on its side."""
        begins = size(end) > 1
        for k in range(1, _DECADES + 1):
            if (size(end * step**k) > 1) != begins:
                return end * step**k
        return None

    bottom, top = float(found.omega[0]), float(found.omega[-1])
    below = beyond(bottom, 0.1) if low is None else None
    above = beyond(top, 10.0) if high is None else None
    if below is None and above is None:
        return found
    return frequency_response(
        linear, low if below is None else below, high if above is None else above
    )


def _delay(crossover: Landmark) -> float:
    """The dead time that turns the response at a crossover to -1."""
    return math.radians(crossover.amount % 360.0) / crossover.omega


def _nearest(linear: Linearisation, response: Response) -> tuple[float, float]:
    """Find where the curve passes nearest to -1, between the points beside the nearest one."""
    # Slow to load; most commands do without it.
    from scipy.optimize import minimize_scalar

    distance = np.abs(1 + response.value)
    k = int(np.argmin(distance))
    ends = np.log(response.omega[[max(k - 1, 0), min(k + 1, len(distance) - 1)]])

    def away(log_omega: float) -> float:
        return abs(1 + complex(linear.response(np.array([math.exp(log_omega)]))[0, 0, 0]))

    found = minimize_scalar(away, bounds=tuple(ends), method="bounded", options={"xatol": 1e-10})
    if found.fun < distance[k]:
        return math.exp(found.x), float(found.fun)
    return float(response.omega[k]), float(distance[k])


def _right(linear: Linearisation) -> int:
    values = linear.eigenvalues()
    return int((values.real > _RIGHT * np.abs(values).max(initial=0.0)).sum())
