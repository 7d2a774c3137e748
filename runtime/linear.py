"""A model linearised about a state: eigenvalues and modes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]

_ROUNDING = 1e-14


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
    """`M dy' = A dy` about a state; `matrix` is A, `mass` is M, (n, n), in the order of `states`.

    Rows of zeros in M are algebraic equations.
    """

    matrix: Real
    mass: Real
    states: tuple[str, ...]

    def eigenvalues(self) -> Complex:
        """Eigenvalues in 1/s, by rising real part, then rising imaginary part.

        As many as M has rank: what only algebraic equations determine has none.
        """
        if np.array_equal(self.mass, np.eye(len(self.mass))):
            found = np.linalg.eigvals(self.matrix)
        else:
            found = _generalised(*_without_algebraic(self.matrix, self.mass))
        order = np.lexsort((found.imag, found.real))
        return np.asarray(found, dtype=np.complex128)[order]

    def modes(self) -> tuple[Mode, ...]:
        """Modes by rising frequency, one of each conjugate pair."""
        upper = [value for value in self.eigenvalues().tolist() if value.imag >= 0]
        modes = [Mode(value, _period(value), _damping(value)) for value in upper]
        return tuple(sorted(modes, key=lambda mode: (mode.frequency, abs(mode.eigenvalue))))


def _period(value: complex) -> float:
    return 2 * math.pi / value.imag if value.imag > 0 else math.inf


def _damping(value: complex) -> float:
    return 0.0 if value.real == 0 else -value.real / abs(value)


def _without_algebraic(matrix: Real, mass: Real) -> tuple[Real, Real]:
    """Solve states that have neither row nor column in M for the others."""
    algebraic = ~(mass.any(axis=0) | mass.any(axis=1))
    if not algebraic.any():
        return matrix, mass
    rest = ~algebraic
    inner = matrix[np.ix_(algebraic, algebraic)]
    follow = np.linalg.lstsq(inner, matrix[np.ix_(algebraic, rest)], rcond=None)[0]
    reduced = matrix[np.ix_(rest, rest)] - matrix[np.ix_(rest, algebraic)] @ follow
    return reduced, mass[np.ix_(rest, rest)]


def _generalised(matrix: Real, mass: Real) -> Complex:
    """Finite eigenvalues of `mass dy' = matrix dy`."""
    from scipy.linalg import eigvals

    above, below = eigvals(matrix, mass, homogeneous_eigvals=True)
    finite = np.abs(below) > _ROUNDING * np.abs(mass).max(initial=0.0)
    found: Complex = above[finite] / below[finite]
    return found
