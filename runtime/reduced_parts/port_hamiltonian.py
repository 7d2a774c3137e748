"""Linear passive systems in port-Hamiltonian form, with the stored energy as norm of the states.

    x' = (J - R) x + (G - P) u + c      y = (G + P)' x + (S + N) u + d

with H = x'x/2 the stored energy, u'y the power into the system, J and N skew, and
[[R, P], [P', S]] positive semidefinite; c and d are constant. Source: van der Schaft and Jeltsema,
Port-Hamiltonian Systems Theory (2014), section 4.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import schur

from bgc.record_class import dataclass, replace
from bgc.runtime.results.arrays import Array, Complex

_ROUNDING = 1e-14  # of the largest entry


@dataclass(frozen=True, slots=True, eq=False)
class PortHamiltonian:
    """A system of n states with m scalar ports and k further outputs.

    Attributes
    ----------
    interconnection
        [[J, G], [-G', -N]], skew, (n + m, n + m).
    dissipation
        [[R, P], [P', S]], positive semidefinite, (n + m, n + m).
    constant
        c of the rates, (n,), and d of the ports, (m,), in one vector.
    outputs
        Further outputs by (x, u, 1), (k, n + m + 1).
    start
        The states at the start, (n,).
    """

    states: int
    interconnection: Array
    dissipation: Array
    constant: Array
    outputs: Array
    start: Array

    @property
    def ports(self) -> int:
        """The number of scalar ports."""
        return len(self.interconnection) - self.states

    @property
    def A(self) -> Array:
        """J - R."""
        n = self.states
        found: Array = (self.interconnection - self.dissipation)[:n, :n]
        return found

    @property
    def B(self) -> Array:
        """G - P."""
        n = self.states
        found: Array = (self.interconnection - self.dissipation)[:n, n:]
        return found

    @property
    def C(self) -> Array:
        """(G + P)'."""
        n = self.states
        found: Array = (self.dissipation - self.interconnection)[n:, :n]
        return found

    @property
    def D(self) -> Array:
        """S + N."""
        n = self.states
        found: Array = (self.dissipation - self.interconnection)[n:, n:]
        return found

    def projected(self, basis: Array) -> PortHamiltonian:
        """Restrict the states to the span of an orthonormal basis V, (n, r): x = V z.

        All parts are congruences by V, so that the result is passive whatever V is. It is the
        projection W = Q V (V'Q V)^-1 of Gugercin, Polyuga, Beattie and van der Schaft
        (Automatica 48, 2012) in the coordinates in which Q = 1.
        """
        n, m = self.states, self.ports
        r = basis.shape[1]
        wide = np.zeros((n + m, r + m))
        wide[:n, :r], wide[n:, r:] = basis, np.eye(m)
        further = np.zeros((n + m + 1, r + m + 1))
        further[: n + m, : r + m], further[-1, -1] = wide, 1.0
        return PortHamiltonian(
            r,
            wide.T @ self.interconnection @ wide,
            wide.T @ self.dissipation @ wide,
            self.constant @ wide,
            self.outputs @ further,
            basis.T @ self.start,
        )

    def sparse(self) -> PortHamiltonian:
        """The same system in states that make R diagonal, or J of 2 x 2 blocks where J is larger.

        The matrices are then exactly skew, and symmetric and positive semidefinite, but for the
        rounding of single entries; entries below rounding are zero.
        """
        n = self.states
        J, R = self.interconnection[:n, :n], self.dissipation[:n, :n]
        turn = schur(J)[1] if _size(J) > _size(R) else np.linalg.eigh(R)[1]
        turned, size = self.projected(turn), max(_size(J), _size(R))
        links, losses = turned.interconnection.copy(), turned.dissipation.copy()
        links[:n, :n] = _rounded(links[:n, :n], size)
        losses[:n, :n] = _rounded(losses[:n, :n], size)
        return replace(
            turned, interconnection=(links - links.T) / 2, dissipation=_positive(losses, n)
        )

    def response(self, s: complex) -> Complex:
        """The transfer matrix y by u at s, (m, m)."""
        states = np.linalg.solve(s * np.eye(self.states) - self.A + 0j, self.B + 0j)
        return np.asarray(self.C @ states + self.D, np.complex128)


def _size(matrix: Array) -> float:
    return float(np.abs(matrix).max(initial=0.0))


def _rounded(matrix: Array, size: float) -> Array:
    found: Array = np.where(np.abs(matrix) > _ROUNDING * size, matrix, 0.0)
    return found


def _positive(matrix: Array, n: int) -> Array:
    """A symmetric matrix without the negative eigenvalues that rounding left, in its own blocks."""
    if matrix[:n, n:].any():
        return _without_negative(matrix)
    found = matrix.copy()
    found[:n, :n], found[n:, n:] = map(_without_negative, (matrix[:n, :n], matrix[n:, n:]))
    return found


def _without_negative(matrix: Array) -> Array:
    symmetric: Array = (matrix + matrix.T) / 2
    off = symmetric - np.diag(np.diag(symmetric))
    if not off.any():
        return np.diag(np.maximum(np.diag(symmetric), 0.0))
    values, vectors = np.linalg.eigh(symmetric)
    if values[0] >= 0:
        return symmetric
    found: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return (found + found.T) / 2
