"""Relations between positions that no motion changes, and points on which they hold.

The position of a joint, the stretch of a spring beside it and the distance of the ends of a rope
are integrated from the same flows; so are the numbers of a quaternion. Rates of such positions are
y' = G(y) v with flows v that are linear in the momenta. A relation h(y) = const therefore has a
gradient k with k G = 0, and k is known at every point: the matrix df/dp of the rates by the momenta
has the columns of G. The points that a motion can reach from y0, those with h(y) = h(y0), are found
by a path from y0 whose direction at each point is orthogonal to all k there.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.rest_algebra import svd
from bgc.runtime.running.structures import Status

_ZERO_PART = 1e-12  # of scaled rows and singular values: what is below counts as zero
_ACCURACY = 1e-12  # of a step along a path, in scales
_LONGEST_PATH = 2000  # steps
_SHORTEST_STEP = 1e-6  # step, in terms of the path
NEARBY = 1e-3  # distance of a second point, in scales

# Stages, and the difference of orders: J. R. Dormand, P. J. Prince, J. Comp. Appl. Math. 6, 1980.
_STAGES = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
_ERRORS = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)

Slope = Callable[[Array], Array]
"""df/dy at a point y, in scales of the states; raises `Undefined` where there is none."""


class Undefined(Exception):
    """An evaluation failed with a status."""

    def __init__(self, status: Status) -> None:
        super().__init__()
        self.status = status


class Relations:
    """Relations between the positions of one instance that are moved by momenta alone.

    `slope` evaluates df/dy, `momenta` are the indices of the momenta, and `mass` is the matrix M of
    M y' = f. A position takes part if its rate is given by the momenta alone, at all points that
    have been evaluated: neither by an orifice nor by a controller. The momenta have to move it at
    the first point or near to it: the scalar part of a quaternion has no rate at the identity.
    """

    def __init__(self, slope: Slope, momenta: list[int], mass: Array) -> None:
        size = len(mass)
        self.slope, self.momenta = slope, np.array(momenta, dtype=np.intp)
        self.others = np.setdiff1d(np.arange(size), self.momenta)
        plain = (mass == np.eye(size)).all(axis=1)
        self.rows: NDArray[np.intp] = self.others[plain[self.others]]
        self.begun = False

    def _moved(self, y: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Derivatives of the rates of the rows by the momenta, and which depend on nothing else."""
        still = y.copy()
        still[self.momenta] = 0.0
        slope = self.slope(still)[self.rows]
        moved = slope[:, self.momenta]
        size = np.abs(moved).max(axis=1, initial=0.0)
        return moved, np.abs(slope[:, self.others]).max(axis=1, initial=0.0) <= _ZERO_PART * size

    def _begin(self, y: Array) -> None:
        """Leave out what the momenta move neither at y nor at a point near to it."""
        self.begun = True
        moves = self._moved(y)[0].any(axis=1)
        nearby = y + NEARBY * np.random.default_rng(1).uniform(0.5, 1, len(y))
        with suppress(Undefined):
            moves |= self._moved(nearby)[0].any(axis=1)
        self.rows = self.rows[moves]

    def _present(self, y: Array) -> Array:
        """Derivatives of the rates of the rows that take part by the momenta, at y."""
        if not self.begun:
            self._begin(y)
        moved, takes_part = self._moved(y)
        self.rows = self.rows[takes_part]
        return moved[takes_part]

    def stopping(self, y: Array, rates: Array) -> Array:
        """The least change of the momenta that stops positions with these rates at y."""
        moved = self._present(y)
        found = np.zeros(len(y))
        if self.rows.size:
            found[self.momenta] = np.linalg.lstsq(moved, -rates[self.rows], rcond=_ZERO_PART)[0]
        return found

    def gradients(self, y: Array) -> Array:
        """Gradients of all relations at y: orthonormal rows."""
        moved = self._present(y)
        if not self.rows.size:
            return np.zeros((0, len(y)))
        size = np.abs(moved).max(axis=1)
        size[size < np.finfo(float).tiny] = 1.0  # a position that stays here keeps its value
        rows = moved / size[:, None]
        columns = np.abs(rows).max(axis=0)
        left, values, _ = svd(rows[:, columns > 0] / columns[columns > 0])
        rank = int((values > _ZERO_PART * values.max(initial=0.0)).sum())
        found = np.zeros((len(self.rows) - rank, len(y)))
        if len(found):
            found[:, self.rows] = orthonormal(left[:, rank:] / size[:, None]).T
        return found

    def reached(self, begin: Array, target: Array) -> tuple[Array, bool]:
        """The point near `target` that a motion reaches from `begin`, and whether it is the last.

        It is a point on the way there where the path takes too many steps.

        The path goes along target - begin, without its components across the relations (explicit
        Runge-Kutta method of order 5 with control of the error of each step).
        """
        along = target - begin

        def rate(y: Array) -> Array:
            across = self.gradients(y)
            found: Array = along - across.T @ (across @ along)
            return found

        y, gone, part = begin, 0.0, 1.0
        first = rate(y)
        if np.array_equal(begin[self.rows], target[self.rows]):
            self._present(target)  # leaves out what other things move there
            return target, True
        count = len(self.rows)
        for _ in range(_LONGEST_PATH):
            slopes = [first]
            for weights in _STAGES:
                change = sum(w * k for w, k in zip(weights, slopes, strict=True))
                after = y + part * change
                slopes.append(rate(after))
            if len(self.rows) < count:  # an orifice or a controller moves some of them, too
                return self.reached(begin, target)
            error = part * sum(w * k for w, k in zip(_ERRORS, slopes, strict=True))
            size = float(np.abs(error).max(initial=0.0)) / _ACCURACY
            if size <= 1 or part <= _SHORTEST_STEP:
                y, first, gone = after, slopes[-1], gone + part
                if gone >= 1:
                    return y, True
            part *= min(5.0, max(0.2, 0.9 * max(size, 1e-10) ** -0.2))
            part = min(max(part, _SHORTEST_STEP), 1 - gone)
        return y, False


def orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis of the space of columns whose rows may differ much in size.

    Where two rows have entries of 1e13 and the others of 1, a QR factorisation alone finds a third
    column with an error of 1e-3. Gaussian elimination of the columns, with their largest entries as
    pivots, separates them before: where one has an entry of 1, those after it have 0.
    """
    found = columns.copy()
    for k in range(found.shape[1]):
        row, ahead = divmod(int(np.abs(found[:, k:]).argmax()), found.shape[1] - k)
        found[:, [k, k + ahead]] = found[:, [k + ahead, k]]
        if found[row, k] == 0:
            break  # all others depend on those before
        found[:, k] /= found[row, k]
        found[:, k + 1 :] -= np.outer(found[:, k], found[row, k + 1 :])
        found[row, k + 1 :] = 0.0
    basis: Array = np.linalg.qr(found)[0]
    return basis
