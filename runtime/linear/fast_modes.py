"""The fast modes of a matrix: what balances it, and the projector on those beyond a frequency.

With NumPy alone, so that a run need not wait for SciPy to be loaded.
"""

from __future__ import annotations

import math

import numpy as np

from bgc.runtime.results.arrays import Array

_SWEEPS = 100
_WORTH_SCALING = 0.9  # of the squares of a row and a column
_TOGETHER = 1 - 1e-6  # eigenvalues of sizes in this ratio are not parted
_ITERATIONS = 50
_SETTING_IN = 1e-2  # changes below this shrink quadratically
_ROUNDING = 1e-8  # of which the square is rounding
_CERTAIN = 1e-3  # in the count of modes


def balancing(matrix: Array) -> Array:
    """Powers of two s that make rows and columns of `diag(1/s) matrix diag(s)` alike in size.

    In the 2-norm, the diagonal left out (B. N. Parlett and C. Reinsch, Numerische Mathematik 13,
    1969; R. James, J. Langou and B. R. Lowery, arXiv:1401.5766).
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
    """The spectral projector on the eigenvalues of size beyond a limit.

    Eigenvalues whose sizes agree to a millionth stay together, as fast ones. The matrix should be
    balanced. A Moebius map takes a circle between the slow eigenvalues and the fast ones to the
    imaginary axis; Newton's method for the matrix sign function does the rest (J. D. Roberts,
    Int. J. Control 32, 1980; scaled by norms, N. J. Higham, Functions of Matrices, 5.5). On
    stiff mechanics it is more accurate than an ordered Schur form.

    Returns
    -------
    tuple
        The projector, the number of fast eigenvalues, and the radius of that circle.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where the eigenvalues cannot be told apart in double precision.
    """
    same = np.eye(len(matrix))
    sizes = np.sort(np.abs(np.linalg.eigvals(matrix)))
    slow = int((sizes <= limit).sum())
    while 0 < slow < len(sizes) and sizes[slow - 1] > _TOGETHER * sizes[slow]:
        slow -= 1
    fast = len(sizes) - slow
    if slow == 0 or fast == 0:
        return same if fast else np.zeros_like(same), fast, limit
    # Not where slow modes of size zero, or rounding, would take it.
    inside, outside = max(sizes[slow - 1], 1e-6 * sizes[slow]), sizes[slow]
    radius = math.sqrt(inside * outside)
    with np.errstate(all="ignore"):  # what overflows is not certain, below
        projector = (same + _sign(same - 2 * np.linalg.inv(matrix / radius + same))) / 2
    if not abs(np.trace(projector) - fast) < _CERTAIN:
        raise np.linalg.LinAlgError("no gap between fast and slow eigenvalues")
    return projector, fast, radius


def _sign(matrix: Array) -> Array:
    """The sign of a matrix without eigenvalues on the imaginary axis."""
    change = math.inf
    for _ in range(_ITERATIONS):
        inverse = np.linalg.inv(matrix)
        factor = 1.0
        if change > _SETTING_IN:
            factor = math.sqrt(np.linalg.norm(inverse, 1) / np.linalg.norm(matrix, 1))
        following = (factor * matrix + inverse / factor) / 2
        before = change
        change = float(np.linalg.norm(following - matrix, 1) / np.linalg.norm(following, 1))
        matrix = following
        if change < _ROUNDING or (change < _SETTING_IN and change > before / 2):
            break
    return matrix
