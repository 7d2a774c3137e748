"""A part with a resistor at each of its ports, in which lossless parts are stable too.

The resistor of a port is its own driving-point value at the part's slowest rate s, a real number:
z = H_jj(s) > 0 for a passive part. Inputs and outputs are scaled by its root, so that ports of
different kinds compare. The transfer matrix T = H (H + 1)^-1 of the scaled H leads from the sources
behind the resistors to the outputs.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm, schur, solve_continuous_lyapunov

from bgc.record_class import dataclass
from bgc.runtime.reduced_parts.port_hamiltonian import PortHamiltonian
from bgc.runtime.results.arrays import Array, Complex

_AT_REST = 1e-9  # of the fastest rate: the rates that count as zero
_HORIZON = 20.0  # time of step responses, over the slowest time constant
_STEPS = 2000
_LEAST_DAMPED = 0.01  # of the slowest rate: limits the time of step responses
_SHIFT = 1e-7  # of that rate, by which all modes are damped more
_TIGHT = 1e-4  # of the norm: the accuracy of the H-infinity norm


@dataclass(frozen=True, slots=True, eq=False)
class Terminals:
    """The slowest rate of a part, 1/s, and the resistor of each of its ports."""

    slowest: float
    resistors: Array

    @staticmethod
    def of(whole: PortHamiltonian) -> Terminals:
        """The terminals of a part."""
        rates = np.sort(np.abs(np.linalg.eigvals(whole.A)))
        moving = rates[rates > _AT_REST * rates[-1]]
        slowest = float(moving[0]) if len(moving) else 1.0
        found = np.real(np.diag(whole.response(slowest)))
        return Terminals(slowest, np.where(found > 0, found, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class StateSpace:
    """x' = A x + B u, y = C x + D u."""

    A: Array
    B: Array
    C: Array
    D: Array

    def __sub__(self, other: StateSpace) -> StateSpace:
        n, r = len(self.A), len(other.A)
        A = np.block([[self.A, np.zeros((n, r))], [np.zeros((r, n)), other.A]])
        B, C = np.vstack([self.B, other.B]), np.hstack([self.C, -other.C])
        return StateSpace(A, B, C, self.D - other.D)

    def responses(self, frequencies: Array) -> Complex:
        """The transfer matrices at i w, (frequencies, outputs, inputs), from one Schur form."""
        points = 1j * frequencies
        upper, vectors = schur(self.A, output="complex")
        entering, leaving = vectors.conj().T @ self.B, self.C @ vectors
        n, m = entering.shape
        states = np.zeros((n, len(points) * m), dtype=complex)
        for k in reversed(range(n)):  # back substitution, at all points at once
            later = (upper[k, k + 1 :] @ states[k + 1 :]).reshape(-1, m)
            states[k] = ((entering[k] + later) / (points - upper[k, k])[:, None]).ravel()
        found: Complex = (leaving @ states).reshape(-1, len(points), m).swapaxes(0, 1)
        return found + self.D

    def h2(self) -> float:
        """The H2 norm; the system has to be stable, and D zero."""
        gramian = solve_continuous_lyapunov(self.A, -self.B @ self.B.T)
        return float(np.sqrt(max(np.trace(self.C @ gramian @ self.C.T), 0.0)))

    def h_infinity(self) -> float:
        """The H-infinity norm; the system has to be stable, and D zero.

        The method of level sets of Bruinsma and Steinbuch (Systems & Control Letters 14, 1990): a
        level is exceeded between those frequencies at which a Hamiltonian matrix has imaginary
        eigenvalues.
        """
        rates = np.abs(np.linalg.eigvals(self.A))
        level, points = 0.0, np.unique(np.concatenate([[0.0], rates]))
        while len(points):
            gains = np.linalg.norm(self.responses(points), 2, axis=(1, 2))
            reached = float(gains.max())
            if reached <= level * (1 + _TIGHT):
                break
            level = reached
            crossed = self._crossings(level * (1 + 2 * _TIGHT))
            points = (crossed[1:] + crossed[:-1]) / 2
        return level

    def steps(self, duration: float) -> Array:
        """The answers to unit steps, at equal times up to a duration: (times, outputs, inputs)."""
        n, m = self.B.shape
        rates = np.block([[self.A, self.B], [np.zeros((m, n + m))]])
        onward = expm(rates * (duration / _STEPS))
        state = np.vstack([np.zeros((n, m)), np.eye(m)])
        found = []
        for _ in range(_STEPS):
            state = onward @ state
            found.append(self.C @ state[:n] + self.D)
        return np.array(found)

    def _crossings(self, level: float) -> Array:
        B, C = self.B / np.sqrt(level), self.C / np.sqrt(level)
        found = np.linalg.eigvals(np.block([[self.A, B @ B.T], [-C.T @ C, -self.A.T]]))
        size = np.abs(found).max(initial=0.0)
        imaginary = found.imag[np.abs(found.real) <= 1e-9 * size]
        return np.sort(imaginary[imaginary >= 0])


def terminated(system: PortHamiltonian, terminals: Terminals) -> StateSpace:
    """The scaled transfer T from the sources behind the resistors to the outputs."""
    root = np.sqrt(terminals.resistors)
    B, C = system.B / root, system.C / root[:, None]
    D = system.D / np.outer(root, root)
    inverse = np.linalg.inv(np.eye(len(D)) + D)
    return StateSpace(system.A - B @ inverse @ C, B @ inverse, inverse @ C, D @ inverse)


def smoothed(system: StateSpace, rate: float) -> StateSpace:
    """The system behind filters 1/(1 + s/rate) of its inputs; it has no direct part.

    All modes are damped by a hair more, so that those that no port reaches have norms too.
    """
    n, m = system.B.shape
    A = np.block([[system.A, system.B], [np.zeros((m, n)), -rate * np.eye(m)]])
    B = np.vstack([np.zeros((n, m)), rate * np.eye(m)])
    A = A - _SHIFT * rate * np.eye(n + m)
    return StateSpace(A, B, np.hstack([system.C, system.D]), np.zeros_like(system.D))


@dataclass(frozen=True, slots=True)
class PartError:
    """The difference between a reduced part and the whole one, computed from both.

    Each port has a resistor, and the sources u behind the resistors change no faster than the part:
    by a time constant that is that of its slowest mode.

    Attributes
    ----------
    h2, h_infinity
        Norms of the difference of the transfer matrices over those of the whole part. The L2 norm
        of the outputs' difference is at most `h_infinity` times the whole part's gain times the L2
        norm of u, for every u.
    step
        The largest difference of an answer to a step of u, over the largest value of that answer.
    """

    h2: float
    h_infinity: float
    step: float


def part_error(whole: PortHamiltonian, reduced: PortHamiltonian, terminals: Terminals) -> PartError:
    """Compute the norms and step responses of the difference between two parts."""
    one, two = (
        smoothed(terminated(each, terminals), terminals.slowest) for each in (whole, reduced)
    )
    slowest = max(-np.linalg.eigvals(one.A).real.max(), _LEAST_DAMPED * terminals.slowest)
    duration = _HORIZON / slowest
    answers = one.steps(duration)
    off = np.abs(answers - two.steps(duration)).max(axis=0)
    peaks = np.abs(answers).max(axis=0)
    difference = one - two
    return PartError(
        h2=_over(difference.h2(), one.h2()),
        h_infinity=_over(difference.h_infinity(), one.h_infinity()),
        step=float((off / np.where(peaks > 0, peaks, 1.0)).max(initial=0.0)),
    )


def _over(value: float, size: float) -> float:
    return value / size if size > 0 else 0.0
