"""Step and impulse responses of a linear model, exact at their rows."""

from __future__ import annotations

import math
from typing import TextIO

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.analysis import no_time_response, out_of_range
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.linear.fast_modes import balancing
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.results.files import WrittenAsCsv, append_rows
from bgc.values.units import quotient_unit

_ROWS = 2000
_SETTLED = 0.02  # of the change from the first to the last value
_DECAYED = 6.0  # time constants of the slowest mode that are shown
_PERIODS = 12.0  # of the slowest oscillation, where nothing decays
_ZERO = 1e-9  # of the largest eigenvalue: an integrator
_NOT_REACHED = 1e-9  # share of a mode in the response below which it does not set the duration


@dataclass(frozen=True, slots=True)
class StepFacts:
    """The figures of a step response that ends in a steady value.

    Times in s from the step on, interpolated between rows: `rise` from 10 % to 90 % of the
    change, `settling` to within 2 % of it. `overshoot` is a share of the change, 0 where the
    response does not pass its last value.
    """

    steady: float
    rise: float
    settling: float
    overshoot: float
    peak_time: float


@dataclass(frozen=True, slots=True, repr=False)
class TimeResponse(WrittenAsCsv):
    """The outputs after a unit step or a unit impulse of one input, (k, p), SI units.

    Attributes
    ----------
    time
        Times of the rows, s, (k,), equally spaced from 0 on.
    value
        Deviations of the outputs from the operating point, (k, p).
    input, outputs, units
        Names, and the SI units of each output by input (times s for an impulse).
    steady
        The values at infinity, (p,); NaN where the model is not asymptotically stable.
    """

    time: Array
    value: Array
    input: str
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    steady: Array

    def __repr__(self) -> str:
        rows = f"{counted(len(self.time), 'row')} to {self.time[-1]:g} s"
        return f"<bgc response of {', '.join(self.outputs)} to {self.input}: {rows}>"

    def facts(self, output: int = 0) -> StepFacts | None:
        """Compute rise time, settling time and overshoot; None without a steady value.

        `output` is the place of an output, from 0.
        """
        last = float(self.steady[output])
        change = last - float(self.value[0, output])
        if not math.isfinite(last) or change == 0:
            return None
        share = (self.value[:, output] - self.value[0, output]) / change
        outside = np.flatnonzero(np.abs(share - 1) > _SETTLED)
        settling = 0.0 if not len(outside) else self._passing(share, int(outside[-1]))
        if settling is None:
            return None
        top, peak_time = self._peak(share)
        over = max(top - 1, 0.0)
        low, high = (self._first(share, level) for level in (0.1, 0.9))
        return StepFacts(last, high - low, settling, over, peak_time if over else 0.0)

    def _peak(self, share: Array) -> tuple[float, float]:
        """The largest value and its time, by the parabola through three rows."""
        k = int(np.argmax(share))
        if not 0 < k < len(share) - 1:
            return float(share[k]), float(self.time[k])
        before, at, after = (float(x) for x in share[k - 1 : k + 2])
        offset = 0.5 * (before - after) / (before - 2 * at + after)
        peak = at - 0.25 * (before - after) * offset
        return peak, float(self.time[k] + offset * (self.time[1] - self.time[0]))

    def _first(self, share: Array, level: float) -> float:
        k = int(np.argmax(share >= level))
        if k == 0:
            return 0.0
        return float(np.interp(level, share[k - 1 : k + 1], self.time[k - 1 : k + 1]))

    def _passing(self, share: Array, k: int) -> float | None:
        """The time after row `k` at which the band is entered for good; None after the last."""
        if k + 1 >= len(share):
            return None
        away = np.abs(share[k : k + 2] - 1)
        fraction = (away[0] - _SETTLED) / (away[0] - away[1])
        return float(self.time[k] + fraction * (self.time[k + 1] - self.time[k]))

    def write_csv(self, file: TextIO) -> None:
        """Write a line for each time, in full precision."""
        rows = np.column_stack((self.time, self.value)).tolist()
        append_rows(file, ("time", *self.outputs), rows)


def step_response(linear: Linearisation, duration: float | None = None) -> TimeResponse:
    """Compute the outputs after a unit step of the only input.

    Each row follows from the one before by the matrix exponential, so that no step size limits
    the accuracy (C. F. Van Loan, IEEE Trans. Automatic Control 23(3), 1978). By default the
    duration is six time constants of the slowest mode.

    Raises
    ------
    BgError
        BG796 where algebraic equations that cannot be eliminated remain in the model, BG798 where
        values leave the range of double precision.
    """
    return _response(linear, duration, impulse=False)


def impulse_response(linear: Linearisation, duration: float | None = None) -> TimeResponse:
    """Compute the outputs after a unit impulse of the only input, as `step_response` does.

    An impulse in the outputs themselves at time 0, by D, has no value in a row and is left out.
    """
    return _response(linear, duration, impulse=True)


def usual_duration(linear: Linearisation) -> float:
    """Choose a duration, s: six time constants, or twelve periods where nothing decays.

    Modes that the input does not excite or the output does not show are left out.
    """
    values = _reached(linear)
    size = float(np.abs(values).max(initial=0.0))
    moving = values[np.abs(values) > _ZERO * size]
    if not len(moving):
        return 10.0
    decaying = -moving.real[moving.real < -_ZERO * size]
    oscillating = np.abs(moving.imag[np.abs(moving.imag) > _ZERO * size])
    growing = moving.real[moving.real > _ZERO * size]
    longest = _DECAYED / float(decaying.min()) if len(decaying) else 0.0
    if len(growing):
        longest = min(longest or math.inf, _DECAYED / float(growing.max()))
    elif not longest and len(oscillating):
        longest = _PERIODS * 2 * math.pi / float(oscillating.min())
    return _rounded(longest or _DECAYED / size)


def _reached(linear: Linearisation) -> Complex:
    """The eigenvalues whose modes stand in the response, by their residues."""
    if not len(linear.A):
        return np.empty(0, dtype=np.complex128)
    # Slow to load; NumPy has no left eigenvectors.
    from scipy.linalg import eig

    values, left, right = eig(linear.A, left=True, right=True)
    inner = np.abs((left.conj() * right).sum(axis=0))
    inner = np.maximum(inner, np.finfo(float).tiny)  # a double eigenvalue counts as reached
    residues = np.abs(linear.C @ right) * np.abs(left.conj().T @ linear.B)[:, 0] / inner
    largest = residues.max(axis=1, initial=0.0, keepdims=True)
    return np.asarray(values[(residues > _NOT_REACHED * largest).any(axis=0)])


def _rounded(duration: float) -> float:
    """Round up to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(duration))
    return next(f * power for f in (1.0, 2.0, 5.0, 10.0) if f * power >= duration * (1 - 1e-12))


def _response(linear: Linearisation, duration: float | None, *, impulse: bool) -> TimeResponse:
    # Slow to load; most commands do without it.
    from scipy.linalg import expm

    if not linear.is_explicit:
        raise BgError([no_time_response(linear.outputs[0])])
    duration = usual_duration(linear) if duration is None else duration
    n = len(linear.A)
    # The input is a state of its own, constant after the step.
    extended = np.zeros((n + 1, n + 1))
    extended[:n, :n], extended[:n, n:] = linear.A, linear.B
    scale = balancing(extended)
    with np.errstate(over="ignore", invalid="ignore"):
        forward = expm(extended / scale[:, None] * scale * (duration / _ROWS))
    state = np.zeros((_ROWS + 1, n + 1))
    state[0, :n] = linear.B[:, 0] / scale[:n] if impulse else 0.0
    state[0, n] = 0.0 if impulse else 1.0 / scale[n]
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(_ROWS):
            state[k + 1] = forward @ state[k]
        value = (state * scale) @ np.hstack((linear.C, linear.D)).T
    if not np.isfinite(value).all():
        raise BgError([out_of_range(linear.outputs[0])])
    units = [quotient_unit(linear.units[y], linear.units[linear.inputs[0]]) for y in linear.outputs]
    if impulse:
        units = [quotient_unit(unit, "s") for unit in units]
    return TimeResponse(
        time=np.linspace(0.0, duration, _ROWS + 1),
        value=value,
        input=linear.inputs[0],
        outputs=linear.outputs,
        units=tuple(units),
        steady=_steady(linear, impulse),
    )


def _steady(linear: Linearisation, impulse: bool) -> Array:
    """The values at infinity; NaN where a mode that is reached does not decay."""
    reached = _reached(linear)
    size = np.abs(linear.eigenvalues()).max(initial=0.0)
    if (reached.real >= -1e-12 * size).any():
        return np.full(len(linear.outputs), np.nan)
    if impulse:
        return np.zeros(len(linear.outputs))
    # Just above zero, since an integrator that is not reached makes A singular.
    slowest = np.abs(reached).min(initial=1.0)
    return np.asarray(linear.response(np.array([1e-9 * slowest]))[0, :, 0].real)
