"""The subspace in which a reduced part moves: its static states, then what its ports answer most.

The first states are those of all steady states, so that the static gain is exact. Then a greedy
search adds the answer to the frequency, and the direction of the ports, at which the error is
largest (rational interpolation, the points chosen as by Feng, Antoulas and Benner, ESAIM: M2AN 51,
2017, with the error itself instead of a bound). Errors count by 1/(1 + i w/s), s the slowest rate
of the part: what steps excite counts most.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space

from bgc.runtime.reduced_parts.port_hamiltonian import PortHamiltonian
from bgc.runtime.reduced_parts.terminated import Terminals, terminated
from bgc.runtime.results.arrays import Array

_POINTS = 300  # frequencies, beside those of the part's own modes
_BEYOND = (1e-2, 3.0)  # the lowest and highest, over the slowest and the fastest rate
_NEAR_MODES = (0.99, 1.0, 1.01)
_SAME = 1e-9  # of a vector: what is left of it outside the span of others counts as rounding


def static_basis(whole: PortHamiltonian) -> Array:
    """An orthonormal basis of the states of all steady states, and of the states at the start.

    Steady states solve A x + B u + c = 0 with constant inputs u.
    """
    n = whole.states
    columns = [whole.A, whole.B]
    if whole.constant[:n].any():
        columns.append(whole.constant[:n, None])
    scaled = [each / max(np.abs(each).max(initial=0.0), 1e-300) for each in columns]
    found = null_space(np.hstack(scaled))[:n]
    return extended(np.zeros((n, 0)), np.column_stack([found, whole.start]), n)


def extended(basis: Array, vectors: Array, most: int) -> Array:
    """Add the directions of vectors to an orthonormal basis, up to `most` columns in all."""
    sizes = np.linalg.norm(vectors, axis=0)
    left = vectors[:, sizes > 0] / sizes[sizes > 0]
    for _ in range(2):  # once more, for the rounding of the first
        left = left - basis @ (basis.T @ left)
    directions, weights, _ = np.linalg.svd(left, full_matrices=False)
    count = min(most - basis.shape[1], int((weights > _SAME).sum()))
    found = np.hstack([basis, directions[:, :count]])
    return np.asarray(np.linalg.qr(found)[0])


def subspaces(whole: PortHamiltonian, terminals: Terminals, sizes: list[int]) -> dict[int, Array]:
    """An orthonormal basis, (n, r), for each size r that the static states leave room for."""
    basis = static_basis(whole)
    points = _frequencies(whole)
    weights = 1 / np.hypot(1, points / terminals.slowest)
    exact = terminated(whole, terminals).responses(points)
    root = np.sqrt(terminals.resistors)
    eye = np.eye(whole.states)
    found: dict[int, Array] = {}
    for size in sorted(size for size in sizes if size >= basis.shape[1]):
        while basis.shape[1] < size:
            reached = terminated(whole.projected(basis), terminals).responses(points)
            left = (exact - reached) * weights[:, None, None]
            worst = int(np.argmax(np.linalg.norm(left, 2, axis=(1, 2))))
            direction = np.linalg.svd(left[worst])[2][0].conj() / root
            answer = np.linalg.solve(1j * points[worst] * eye - whole.A, whole.B @ direction)
            answers = np.column_stack([answer.real, answer.imag])
            grown = extended(basis, answers, basis.shape[1] + 1)
            if grown.shape[1] == basis.shape[1]:
                return found
            basis = grown
        found[size] = basis
    return found


def _frequencies(whole: PortHamiltonian) -> Array:
    """Frequencies from far below the slowest rate of the part to beyond the fastest one."""
    rates = np.abs(np.linalg.eigvals(whole.A))
    rates = rates[rates > 1e-9 * rates.max(initial=0.0)]
    if not len(rates):
        return np.ones(1)
    low, high = (
        factor * rate for factor, rate in zip(_BEYOND, (min(rates), max(rates)), strict=True)
    )
    modes = np.concatenate([factor * rates for factor in _NEAR_MODES])
    return np.unique(np.concatenate([np.geomspace(low, high, _POINTS), modes]))
