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

import numpy as np
from numpy.typing import NDArray

from bgc.runtime.results.arrays import Array

_LEAST = 1e-12  # of scaled rows and singular values: what is below counts as zero
_ACCURACY = 1e-12  # of a step along a path, in scales
_LONGEST_PATH = 2000  # steps
_SHORTEST = 1e-6  # step, in terms of the path

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
"""df/dy at a point y, in scales of the states."""


class Relations:
    """Relations between the positions of one instance that are moved by momenta alone.

    `slope` evaluates df/dy, `momenta` are the indices of the momenta, and `mass` is the matrix M of
    M y' = f. A position takes part if its rate is given by the momenta alone, at all points that
    have been evaluated: neither by an orifice nor by a controller.
    """

    def __init__(self, slope: Slope, momenta: list[int], mass: Array) -> None:
        size = len(mass)
        self.slope, self.momenta = slope, np.array(momenta, dtype=np.intp)
        self.others = np.setdiff1d(np.arange(size), self.momenta)
        plain = (mass == np.eye(size)).all(axis=1)
        self.rows: NDArray[np.intp] = self.others[plain[self.others]]

    def gradients(self, y: Array) -> Array:
        """Gradients of all relations at y: orthonormal rows."""
        if not (self.rows.size and self.momenta.size):
            return np.zeros((0, len(y)))
        still = y.copy()
        still[self.momenta] = 0.0
        slope = self.slope(still)[self.rows]
        moved = slope[:, self.momenta]
        size = np.abs(moved).max(axis=1)
        stay = np.abs(slope[:, self.others]).max(axis=1, initial=0.0) <= _LEAST * size
        takes_part = stay & (size > 0)
        if not takes_part.all():
            self.rows = self.rows[takes_part]
            moved, size = moved[takes_part], size[takes_part]
        if not self.rows.size:
            return np.zeros((0, len(y)))
        rows = moved / size[:, None]
        columns = np.abs(rows).max(axis=0)
        left, values, _ = np.linalg.svd(rows[:, columns > 0] / columns[columns > 0])
        rank = int((values > _LEAST * values.max(initial=0.0)).sum())
        found = np.zeros((len(self.rows) - rank, len(y)))
        if len(found):
            found[:, self.rows] = np.linalg.qr(left[:, rank:] / size[:, None])[0].T
        return found

    def reached(self, begin: Array, target: Array) -> Array:
        """The point near `target` that a motion reaches from `begin`.

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
        if not self.rows.size:
            return target
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
            if size <= 1 or part <= _SHORTEST:
                y, first, gone = after, slopes[-1], gone + part
                if gone >= 1:
                    break
            part *= min(5.0, max(0.2, 0.9 * max(size, 1e-10) ** -0.2))
            part = min(max(part, _SHORTEST), 1 - gone)
        return y
