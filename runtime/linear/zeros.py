"""Transmission zeros of a linear model, by reduction to a regular pencil."""

from __future__ import annotations

import math

import numpy as np

from bgc.record_class import dataclass
from bgc.runtime.linear.fast_modes import balancing
from bgc.runtime.linear.state_space import Linearisation, by_real_part, pencil_eigenvalues
from bgc.runtime.results.arrays import Array, Complex

_RANKS = (1e-10, 1e-8, 1e-12, 1e-14)  # of the norm of A: smaller singular values count as zero
_PROBES = 12  # frequencies at which the factors are compared with the response
_AGREEMENT = 1e-4  # of the response, at each of them


@dataclass(frozen=True, slots=True)
class Factors:
    """`G(s) = gain * prod(s - zeros) / prod(s - poles)` of one output by one input, SI units.

    `accurate` is false where the product does not agree with the response of the model to 1e-4:
    zeros of such a model are too sensitive for double precision. The gain is NaN then.
    """

    zeros: Complex
    poles: Complex
    gain: float
    accurate: bool


def factors(linear: Linearisation) -> Factors:
    """Compute zeros, poles and gain of a model with one input and one output.

    Poles are all eigenvalues of the model; those that do not reach the output are zeros, too.
    The zeros are computed with several tolerances of the rank decisions. Of the products that
    agree with the response over the range of poles and zeros, the one with the fewest zeros is
    taken: a further zero lies so far out that it does not show.
    """
    poles = linear.eigenvalues()
    found: list[Factors] = []
    for rank in _RANKS:
        zeros = transmission_zeros(linear, rank)
        gain = _common_gain(linear, zeros, poles)
        found.append(Factors(zeros, poles, gain, math.isfinite(gain)))
    return min(found, key=lambda each: (not each.accurate, len(each.zeros)))


def _common_gain(linear: Linearisation, zeros: Complex, poles: Complex) -> float:
    """Return the gain by which the product of the factors is the response; NaN if there is none."""
    sizes = np.abs(np.concatenate((zeros, poles)))
    sizes = sizes[sizes > 1e-12 * sizes.max(initial=0.0)]
    low, high = (sizes.min(), sizes.max()) if len(sizes) else (1.0, 1.0)
    omega = np.geomspace(low / 3, high * 3, _PROBES)
    value = linear.response(omega)[:, 0, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = 1j * omega[:, None]
        logs = np.log(value) + np.log(s - poles).sum(axis=1) - np.log(s - zeros).sum(axis=1)
    # Far beyond the poles a response is rounding; its product is compared where it is not.
    sizes = np.abs(value)
    seen = np.isfinite(logs) & (sizes > 1e-9 * sizes.max(initial=0.0))
    if seen.sum() < 2:
        return math.nan
    ratios = np.exp(logs[seen] - logs[seen].real.mean())
    if np.abs(ratios - ratios[0]).max() > _AGREEMENT * abs(ratios[0]):
        return math.nan
    return float(np.copysign(math.exp(logs[seen].real.mean()), ratios[0].real))


def transmission_zeros(linear: Linearisation, rank: float = _RANKS[0]) -> Complex:
    """Compute the finite transmission zeros, 1/s, by rising real part, then imaginary part.

    A zero is an s at which `[A - sE, B; C, D]` has less than its normal rank. Infinite zeros are
    removed by orthogonal transformations before eigenvalues are computed (A. Emami-Naeini and
    P. Van Dooren, Automatica 18(4), 1982), so that none of them appears as a large finite one.
    With one input and one output these are the zeros of the transfer function and, where a mode
    is not controllable or not observable, that mode, which is a pole too. Singular values below
    `rank`, as a share of the norm of the balanced A, count as zero.
    """
    if not linear.is_explicit:
        return _descriptor_zeros(linear)
    A, B, C, D = _scaled(linear.A, linear.B, linear.C, linear.D)
    tolerance = rank * float(np.linalg.norm(A))
    A, B, C, D = _with_full_row_rank(A, B, C, D, tolerance)
    if not len(A):
        return np.empty(0, dtype=np.complex128)
    # The dual system: outputs that are not independent are removed like inputs before.
    At, Ct, Bt, Dt = _with_full_row_rank(A.T, C.T, B.T, D.T, tolerance)
    A, B, C, D = At.T, Bt.T, Ct.T, Dt.T
    n = len(A)
    if not (n and D.size):
        return by_real_part(np.linalg.eigvals(A))
    # With [C D] compressed to its last columns, the first n make a pencil without infinite zeros.
    _, _, rows = np.linalg.svd(np.hstack((C, D)))
    turn = np.roll(rows, -len(D), axis=0).T[:, :n]
    # Slow to load; NumPy has no generalised eigenvalues.
    from scipy.linalg import eigvals

    return by_real_part(eigvals(np.hstack((A, B)) @ turn, turn[:n]))


def _descriptor_zeros(linear: Linearisation) -> Complex:
    """Compute the finite eigenvalues of the whole pencil; none where it is not square."""
    n, p, m = len(linear.A), len(linear.outputs), len(linear.inputs)
    if p != m:
        return np.empty(0, dtype=np.complex128)
    system = np.block([[linear.A, linear.B], [linear.C, linear.D]])
    mass = np.zeros((n + p, n + m))
    mass[:n, :n] = linear.E
    return pencil_eigenvalues(system, mass)


def _scaled(A: Array, B: Array, C: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """Scale states, inputs and outputs so that a rank can be decided in double precision."""
    scale = balancing(A)
    A, B, C = A / scale[:, None] * scale, B / scale[:, None], C * scale
    size = float(np.linalg.norm(A)) or 1.0
    by_input = np.array([size / (norm or size) for norm in np.linalg.norm(B, axis=0)])
    by_output = np.array([size / (norm or size) for norm in np.linalg.norm(C, axis=1)])
    return A, B * by_input, C * by_output[:, None], D * by_input * by_output[:, None]


def _with_full_row_rank(
    A: Array, B: Array, C: Array, D: Array, tolerance: float
) -> tuple[Array, Array, Array, Array]:
    """Remove states until D has full row rank, without changing the finite zeros.

    An output without feedthrough that has to stay zero holds some states at zero; their rates
    become outputs in its place.
    """
    while True:
        left, singular, _ = np.linalg.svd(D)
        rank = int((singular > tolerance).sum())
        direct = left[:, :rank].T @ D
        C = left.T @ C
        above, below = C[:rank], C[rank:]
        if not len(below):
            return A, B, above, direct
        _, singular, rows = np.linalg.svd(below)
        held = int((singular > tolerance).sum())
        if not held:
            return A, B, above, direct
        turn = np.roll(rows, -held, axis=0).T  # states held at zero come last
        free = len(A) - held
        A, B, above = turn.T @ A @ turn, turn.T @ B, above @ turn
        C = np.vstack((A[free:, :free], above[:, :free]))
        D = np.vstack((B[free:], direct))
        A, B = A[:free, :free], B[:free]
        if not free:
            return A, B, C, D
