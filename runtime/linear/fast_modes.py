"""The fast modes of a matrix: balancing, and the projector on modes beyond a frequency.

Only NumPy is used, since SciPy takes longer to load than most runs.
"""

from __future__ import annotations

import math

import numpy as np

from bgc.runtime.results.arrays import Array

_SWEEPS = 100
_WORTH_SCALING = 0.9  # of the squares of a row and a column
_TOGETHER = 1 - 1e-6  # ratio of sizes from which on eigenvalues are not separated
_ITERATIONS = 50
_QUADRATIC = 1e-2  # changes below this shrink quadratically
_ROUNDING = 1e-8  # a change whose square is rounding
_CERTAIN = 1e-3  # error allowed in the trace, which is the number of fast modes


def balancing(matrix: Array) -> Array:
    """Find powers of two s so that rows and columns of `diag(1/s) matrix diag(s)` have equal norms.

    The 2-norm is used, without the diagonal (B. N. Parlett and C. Reinsch, Numerische Mathematik
    13, 1969; R. James, J. Langou and B. R. Lowery, arXiv:1401.5766).
    """
    scale = np.ones(len(matrix))
    largest = np.abs(matrix).max(initial=0.0)
    squares = (matrix / largest) ** 2 if largest > 0 else matrix.copy()
    np.fill_diagonal(squares, 0.0)
    for _ in range(_SWEEPS):
        done = True
        for k in range(len(matrix)):
            row, column = float(squares[k].sum()), float(squares[:, k].sum())
            if not (row > 0 and column > 0):
                continue
            factor = 2.0 ** round(math.log2(row / column) / 4)
            if column * factor**2 + row / factor**2 < _WORTH_SCALING * (row + column):
                done = False
                scale[k] *= factor
                squares[:, k] *= factor**2
                squares[k] /= factor**2
        if done:
            break
    return scale


def fast_projector(matrix: Array, limit: float) -> tuple[Array, int, float]:
    """Compute the spectral projector on the eigenvalues with a modulus above a limit.

    Eigenvalues whose moduli agree to a millionth stay together and count as fast. The matrix
    should be balanced. A Moebius map takes a circle between the slow and the fast eigenvalues to
    the imaginary axis; the matrix sign function, by Newton's method, separates them (J. D. Roberts,
    Int. J. Control 32, 1980; scaled by norms, N. J. Higham, Functions of Matrices, 5.5). For stiff
    mechanics this is more accurate than an ordered Schur form.

    Returns
    -------
    tuple
        The projector, the number of fast eigenvalues, and the radius of that circle.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the eigenvalues cannot be separated in double precision.
    """
    same = np.eye(len(matrix))
    sizes = np.sort(np.abs(np.linalg.eigvals(matrix)))
    slow = int((sizes <= limit).sum())
    while 0 < slow < len(sizes) and sizes[slow - 1] > _TOGETHER * sizes[slow]:
        slow -= 1
    fast = len(sizes) - slow
    if slow == 0 or fast == 0:
        return same if fast else np.zeros_like(same), fast, limit
    # A slow eigenvalue of zero, or of rounding, must not draw the circle to zero.
    inside, outside = max(sizes[slow - 1], 1e-6 * sizes[slow]), sizes[slow]
    radius = math.sqrt(inside * outside)
    with np.errstate(all="ignore"):  # an overflow fails the test of the trace below
        projector = (same + _sign(same - 2 * np.linalg.inv(matrix / radius + same))) / 2
    if not abs(np.trace(projector) - fast) < _CERTAIN:
        raise np.linalg.LinAlgError("no gap between fast and slow eigenvalues")
    return projector, fast, radius


def _sign(matrix: Array) -> Array:
    """Compute the sign of a matrix without eigenvalues on the imaginary axis."""
    change = math.inf
    for _ in range(_ITERATIONS):
        inverse = np.linalg.inv(matrix)
        factor = 1.0
        if change > _QUADRATIC:
            factor = math.sqrt(np.linalg.norm(inverse, 1) / np.linalg.norm(matrix, 1))
        following = (factor * matrix + inverse / factor) / 2
        before = change
        change = float(np.linalg.norm(following - matrix, 1) / np.linalg.norm(following, 1))
        matrix = following
        if change < _ROUNDING or (change < _QUADRATIC and change > before / 2):
            break
    return matrix
