"""The peak, the crossovers and the margins of a frequency response, refined between its points."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Literal, TypeAlias

import numpy as np

from bgc.record_class import dataclass
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.results.arrays import Array, Complex

_UNDAMPED = 1e-8  # damping ratio below which a peak is not bounded
_MOST_CROSSINGS = 6  # of each kind
_REAL = 1e-6  # a response is real where its imaginary part is a smaller share of it


Kind: TypeAlias = Literal["peak", "unbounded peak", "phase margin", "gain margin"]


@dataclass(frozen=True, slots=True)
class Landmark:
    """A frequency (rad/s) of interest with the response there, its kind, and its margin.

    A phase margin, deg, is that where |G| = 1; a gain margin, dB, that where the phase is
    -180 deg, modulo 360. Both hold for unit negative feedback around G. `amount` is 0 at a peak.
    """

    omega: float
    value: complex
    kind: Kind
    amount: float = 0.0

    @property
    def meaning(self) -> str:
        """The kind with the margin: `phase margin 40.2 deg`."""
        unit = {"phase margin": "deg", "gain margin": "dB"}.get(self.kind)
        return f"{self.kind} {self.amount:.4g} {unit}" if unit else self.kind


def landmarks(linear: Linearisation, omega: Array, value: Complex) -> list[Landmark]:
    """Find the landmarks of `value = G(i omega)`, all finite, by rising frequency.

    Their frequencies are refined to 1e-13 of themselves. A maximum at an end of the range is no
    peak.
    """

    def response(log_omega: float) -> complex:
        return complex(linear.response(np.array([math.exp(log_omega)]))[0, 0, 0])

    at = np.log(omega)
    found = [*_peak(linear, at, value), *_crossings(response, at, value)]
    return sorted(found, key=lambda landmark: landmark.omega)


def _peak(linear: Linearisation, at: Array, value: Complex) -> Iterator[Landmark]:
    """Find the largest response: where the slope of |G| over log omega changes its sign."""
    top = int(np.argmax(np.abs(value)))
    if not 0 < top < len(at) - 1:
        return
    low, high = float(at[top - 1]), float(at[top + 1])
    for mode in linear.modes():
        centre = mode.eigenvalue.imag
        if centre > 0 and abs(mode.damping) < _UNDAMPED and low <= math.log(centre) <= high:
            yield Landmark(centre, complex(math.inf), "unbounded peak")
            return
    slopes = np.array([_slope(linear, x) for x in (low, high)])
    for x in _roots(lambda x: _slope(linear, x), np.array([low, high]), slopes):
        omega = math.exp(x)
        yield Landmark(omega, complex(linear.response(np.array([omega]))[0, 0, 0]), "peak")


def _slope(linear: Linearisation, log_omega: float) -> float:
    """Compute d log|G| / d log omega, from G' = -C (sE - A)^-1 E (sE - A)^-1 B."""
    s = 1j * math.exp(log_omega)
    pencil = s * linear.E - linear.A
    inner = np.linalg.solve(pencil, linear.B[:, 0])
    value = linear.C[0] @ inner + linear.D[0, 0]
    derivative = -linear.C[0] @ np.linalg.solve(pencil, linear.E @ inner)
    return float((s * derivative / value).real)


def _crossings(
    response: Callable[[float], complex], at: Array, value: Complex
) -> Iterator[Landmark]:
    """Find where |G| = 1, with the phase margin, and where G is real and negative."""
    size = np.abs(value)
    for x in _roots(
        lambda x: math.log(abs(response(x)) or 1e-300), at, np.log(np.maximum(size, 1e-300))
    ):
        point = response(x)
        margin = math.remainder(math.degrees(math.atan2(point.imag, point.real)) + 180, 360)
        yield Landmark(math.exp(x), point, "phase margin", margin)
    behind = np.where(value.real < 0, value.imag, np.nan)
    for x in _roots(lambda x: response(x).imag, at, behind):
        point = response(x)
        if abs(point.imag) < _REAL * abs(point):  # else a pole on the axis lies between
            margin = -20 * math.log10(abs(point))
            yield Landmark(math.exp(x), point, "gain margin", margin)


def _roots(function: Callable[[float], float], at: Array, values: Array) -> Iterator[float]:
    """The places where a function that has `values` at `at` changes its sign, the first few."""
    from scipy.optimize import brentq  # SciPy loads slowly; other commands do without it

    signs = np.sign(values)
    for k in np.flatnonzero(signs[:-1] * signs[1:] < 0)[:_MOST_CROSSINGS]:
        if np.sign(function(at[k])) * np.sign(function(at[k + 1])) < 0:
            yield brentq(function, at[k], at[k + 1], xtol=1e-14, rtol=1e-13)
