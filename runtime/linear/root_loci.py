"""The root locus: poles of the closed loop over its gain."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.analysis import no_time_response
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.linear.feedback import close_loop
from bgc.runtime.linear.frequency import Response, frequency_response
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.results.arrays import Array, Complex

_A_DECADE = 24  # gains
_BEYOND = 1e3  # of the gains at which the response has magnitude 1
_WIDEST = 1e12  # of the lowest gain: the highest one
_FINE = 0.05  # of the distance to the origin: longest way of a pole from gain to gain
_CLOSEST = 1.0001  # ratio of gains between which none is inserted
_MOST_GAINS = 3000


@dataclass(frozen=True, slots=True)
class Crossing:
    """A gain at which poles of the closed loop pass the imaginary axis at i*omega, rad/s."""

    gain: float
    omega: float


@dataclass(frozen=True, slots=True, repr=False)
class Locus:
    """Poles of the closed loop over positive gains, (k, n), each column one branch.

    `gain` rises from 0, in SI units of the input for one of the output. `crossings` are by rising
    gain.
    """

    gain: Array
    poles: Complex
    crossings: tuple[Crossing, ...]

    def __repr__(self) -> str:
        branches, gains = self.poles.shape[1], counted(len(self.gain), "gain")
        at = ", ".join(f"{each.gain:.4g}" for each in self.crossings) or "none"
        return (
            f"<bgc root locus: {counted(branches, 'pole')} over {gains}; gains of crossings: {at}>"
        )


def root_locus(linear: Linearisation) -> Locus:
    """Follow the poles of the loop that `close_loop` closes, from the open loop's to its zeros.

    The gains extend a thousandfold beyond those at which the response has magnitude 1. Further
    ones are inserted where a pole moves far from one to the next. A branch goes on to the poles
    that make the total way of all branches shortest.

    Raises
    ------
    BgError
        BG796 where algebraic equations that cannot be eliminated remain in the model.
    """
    if not linear.is_explicit:
        raise BgError([no_time_response(linear.outputs[0])])
    response = frequency_response(linear)
    size = np.abs(response.value[response.value != 0])
    low, high = 1 / (_BEYOND * float(size.max())), _BEYOND / float(size.min())
    high = min(high, low * _WIDEST)
    count = max(2, math.ceil(_A_DECADE * math.log10(high / low)))
    gains = [0.0, *np.geomspace(low, high, count).tolist()]
    poles = [linear.eigenvalues(), *(_poles(linear, gain) for gain in gains[1:])]
    k = 1
    while k + 1 < len(gains) and len(gains) < _MOST_GAINS:
        if gains[k + 1] > _CLOSEST * gains[k] and _far(poles[k], poles[k + 1]):
            gains.insert(k + 1, math.sqrt(gains[k] * gains[k + 1]))
            poles.insert(k + 1, _poles(linear, gains[k + 1]))
        else:
            k += 1
    branches = [poles[0]]
    for found in poles[1:]:
        branches.append(found[_continued(branches[-1], found)])
    return Locus(np.array(gains), np.array(branches), _crossings(linear, response))


def _poles(linear: Linearisation, gain: float) -> Complex:
    return close_loop(linear, gain).eigenvalues()


def _far(before: Complex, after: Complex) -> bool:
    """Return whether a pole moves by more than a share of its distance from the origin."""
    way = np.abs(after[_continued(before, after)] - before)
    size = np.maximum(np.abs(before), 1e-3 * np.abs(before).max(initial=0.0))
    return bool((way > _FINE * size).any())


def _continued(before: Complex, after: Complex) -> NDArray[np.intp]:
    """Order `after` so that the total distance from `before` is least."""
    # Slow to load; only a locus needs it.
    from scipy.optimize import linear_sum_assignment

    return np.asarray(linear_sum_assignment(np.abs(before[:, None] - after[None, :]))[1])


def _crossings(linear: Linearisation, response: Response) -> tuple[Crossing, ...]:
    """The gains 1/|G| at which G is real and negative, at frequency 0 too."""
    found = [
        Crossing(float(1 / abs(mark.value)), mark.omega)
        for mark in response.landmarks
        if mark.kind == "gain margin"
    ]
    at_rest = float(linear.response(np.zeros(1))[0, 0, 0].real)
    if at_rest < 0:  # NaN where a pole lies at 0
        found.append(Crossing(-1 / at_rest, 0.0))
    return tuple(sorted(found, key=lambda crossing: crossing.gain))
