"""Frequency response of one output to one input, its grid of frequencies, and its files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TextIO

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.analysis import no_range, no_response
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.linear.landmarks import Landmark, landmarks
from bgc.runtime.linear.state_space import Linearisation, Mode
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.results.files import WrittenAsCsv, append_rows
from bgc.values.units import quotient_unit

_POINTS_A_DECADE = 60
_NEAR_A_MODE = 15  # points on either side of a resonance, spaced logarithmically
_ANGLES = np.deg2rad(np.arange(4.0, 88.0, 4.0))  # of the response, on either side of a resonance
_MOST_DECADES = 12.0
_ALMOST_ZERO = 1e-9  # of the largest eigenvalue
_NEGLIGIBLE = 1e-9  # of the largest response: its last digits are rounding
_RESONANT = 0.7  # damping ratio below which a mode has a resonance

HEADER = ("omega", "magnitude_db", "phase_deg", "real", "imag")


@dataclass(frozen=True, slots=True, repr=False)
class Response(WrittenAsCsv):
    """`value[k] = G(i omega[k])`, omega in rad/s; `unit` is that of output per input.

    All values are finite: the frequency of an undamped mode is left out. The frequencies of
    `landmarks` are among `omega`, but for those of unbounded peaks.
    """

    input: str
    output: str
    unit: str
    omega: Array
    value: Complex
    landmarks: tuple[Landmark, ...] = ()

    def __repr__(self) -> str:
        ends = f"{self.omega[0]:g} to {self.omega[-1]:g} rad/s" if len(self.omega) else "none"
        count = counted(len(self.omega), "point")
        return f"<bgc response of {self.output} to {self.input}: {count}, {ends}>"

    @property
    def magnitude(self) -> Array:
        """20 log10 |G|, dB; minus infinity where the response is zero."""
        with np.errstate(divide="ignore"):
            return np.asarray(20 * np.log10(np.abs(self.value)), dtype=np.float64)

    @property
    def phase(self) -> Array:
        """The phase in degrees, without jumps of 360 from point to point."""
        return np.asarray(np.rad2deg(np.unwrap(np.angle(self.value))), dtype=np.float64)

    def rows(self) -> Array:
        """Columns as `HEADER` names them, (k, 5)."""
        parts = (self.omega, self.magnitude, self.phase, self.value.real, self.value.imag)
        return np.column_stack(parts)

    def write_csv(self, file: TextIO) -> None:
        """Write a line for each frequency, in full precision."""
        append_rows(file, HEADER, self.rows().tolist())


def frequency_response(
    linear: Linearisation, low: float | None = None, high: float | None = None
) -> Response:
    """Compute the response of a linear model with one input and one output.

    Frequencies run from `low` to `high` in rad/s, more closely around resonances. By default they
    extend a decade beyond the slowest and the fastest mode, but end where the response has fallen
    to 1e-9 of its largest value (-180 dB).

    Raises
    ------
    BgError
        BG085 if the range is empty, BG086 if the response is zero throughout.
    """
    modes = linear.modes()
    first, last = _range(modes)
    start, end = first if low is None else low, last if high is None else high
    if not (0 < start < end and math.isfinite(end)):
        raise BgError([no_range(start, end)])
    omega = _frequencies(modes, start, end)
    above, below = (linear.units[name] for name in (linear.outputs[0], linear.inputs[0]))
    value = linear.response(omega)[:, 0, 0]
    bounded = np.isfinite(value)  # all but the frequencies of undamped modes
    omega, value = omega[bounded], value[bounded]
    if not value.any():
        raise BgError([no_response(linear.inputs[0], linear.outputs[0])])
    if high is None:  # beyond all modes the response falls, until only rounding is left
        kept = np.flatnonzero(np.abs(value) > _NEGLIGIBLE * np.abs(value).max())[-1] + 1
        omega, value = omega[:kept], value[:kept]
    found = tuple(landmarks(linear, omega, value)) if len(omega) > 1 else ()
    finite = [mark for mark in found if np.isfinite(mark.value)]
    every = np.concatenate([omega, [mark.omega for mark in finite]])
    omega, order = np.unique(every, return_index=True)
    value = np.concatenate([value, [mark.value for mark in finite]])[order]
    unit = quotient_unit(above, below)
    return Response(linear.inputs[0], linear.outputs[0], unit, omega, value, found)


def _range(modes: Sequence[Mode]) -> tuple[float, float]:
    """Extend the range of the modes by a decade on each side, to whole decades."""
    sizes = [abs(mode.eigenvalue) for mode in modes]
    largest = max(sizes, default=0.0)
    sizes = [size for size in sizes if size > _ALMOST_ZERO * largest]
    if not sizes:
        return 1e-2, 1e2
    last = math.ceil(math.log10(max(sizes))) + 1
    first = math.floor(math.log10(min(sizes))) - 1
    return 10.0 ** max(first, last - _MOST_DECADES), 10.0**last


def _frequencies(modes: Sequence[Mode], low: float, high: float) -> Array:
    """Space frequencies logarithmically, with further ones around lightly damped modes."""
    decades = math.log10(high) - math.log10(low)
    count = max(2, math.ceil(_POINTS_A_DECADE * decades) + 1)
    grids = [np.geomspace(low, high, count)]
    for mode in modes:
        centre = mode.eigenvalue.imag
        if centre > 0 and abs(mode.damping) < _RESONANT:
            width = max(abs(mode.eigenvalue.real), 1e-6 * centre)
            ends = max(1.0, math.log10(centre / width))
            # Near a resonance the response is a circle; equal angles make it a smooth curve.
            tail = np.logspace(-1, ends - 0.5, _NEAR_A_MODE)
            offsets = width * np.append(np.tan(_ANGLES), tail)
            grids += [centre - offsets, centre + offsets]
    every = np.unique(np.concatenate(grids))
    return np.asarray(every[(every >= low) & (every <= high)], dtype=np.float64)
