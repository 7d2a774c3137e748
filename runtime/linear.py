"""A model linearised about a state: eigenvalues and modes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Complex: TypeAlias = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Mode:
    """One mode: its eigenvalue, 1/s; `period` is that of the damped oscillation, s.

    `damping` is the damping ratio, 1 where the mode does not oscillate (and infinite period).
    """

    eigenvalue: complex
    period: float
    damping: float

    @property
    def frequency(self) -> float:
        """Frequency of the damped oscillation, Hz; 0 where it does not oscillate."""
        return 1.0 / self.period


@dataclass(frozen=True, slots=True)
class Linearisation:
    """`dy' = A dy` about a state; `matrix` is A, (n, n), in the order of `states`."""

    matrix: NDArray[np.float64]
    states: tuple[str, ...]

    def eigenvalues(self) -> Complex:
        """Eigenvalues in 1/s, by rising real part, then rising imaginary part."""
        found: Complex = np.linalg.eigvals(self.matrix).astype(np.complex128)
        return found[np.lexsort((found.imag, found.real))]

    def modes(self) -> tuple[Mode, ...]:
        """Modes by rising frequency, one of each conjugate pair."""
        upper = [value for value in self.eigenvalues().tolist() if value.imag >= 0]
        modes = [Mode(value, _period(value), _damping(value)) for value in upper]
        return tuple(sorted(modes, key=lambda mode: (mode.frequency, abs(mode.eigenvalue))))


def _period(value: complex) -> float:
    return 2 * math.pi / value.imag if value.imag > 0 else math.inf


def _damping(value: complex) -> float:
    return 0.0 if value.real == 0 else -value.real / abs(value)
