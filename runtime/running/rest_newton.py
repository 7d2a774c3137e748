"""Steps of Gauss and Newton of least length towards a state of rest.

Steps keep relations between positions to the first order, or do not. Rows are scaled to entries of
one; singular values below a tolerance, which decreases with the residuals, count as zero.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from bgc.language.scene import Rest
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.relations import Relations, Undefined
from bgc.runtime.running.rest_algebra import LEAST_RANK, least, rank_of, row_scales, svd
from bgc.runtime.running.rest_equations import RestEquations, require_ok

AT_REST = 1e-9  # of a residual, in the scale of the states that it depends on
ROUNDING = 1e-15  # of a residual: no step makes it smaller
STILL = 1e-12  # of a step along free directions, in scales
CHEAP = 100.0  # scale of a parameter that is varied: a step changes it before a state
_STEPS = 400  # of a whole search, each with a singular value decomposition; a crane takes 27
_HALVINGS = 25
_SMALL_PART = 1 / 8  # of a step


class RestNewton(RestEquations):
    """Newton's method for one instance: z holds the states in their scales, then the parameters."""

    def __init__(self, instance: Instance, rest: Rest) -> None:
        super().__init__(instance, rest)
        self.momenta = list(rest.momenta)
        self.trapped = np.zeros(0, dtype=np.intp)
        self.begin = np.concatenate([self.start, self.given / self.of_parameters])
        self.z = self.begin
        self.rows = np.ones(0)
        self.steps_left = _STEPS
        status, mass = self.resting.mass()
        require_ok(status)
        self.mass = mass * self.scale / self.scale[:, None]
        self.relations = Relations(self.by_state, self.momenta, self.mass)

    def _newton(self, most: int, *, kept: bool) -> float:
        """Take steps towards rest while they help, at most so many; return the largest residual.

        Steps go along the relations between positions if these are `kept`.
        """
        rank = 1.0  # factor of the tolerance of rank
        remaining = self.residuals(self.z)
        size = np.inf
        settled: tuple[Array, float] | None = None  # the last point at rest, and its residual
        for _ in range(most):
            self.steps_left -= 1
            slope, starts = self.slopes(self.z)
            self.rows = row_scales(slope)
            scaled = remaining / self.rows
            size = float(np.abs(scaled).max(initial=0.0))
            if size <= AT_REST:
                settled = self.z, size
            if size <= ROUNDING or self.steps_left <= 0:
                break
            basis = self._steps(starts, kept)
            matrix = (slope / self.rows[:, None]) @ basis
            sizes = row_scales(matrix) if self.trapped.size else np.ones(len(matrix))
            left, values, right = svd(matrix / sizes[:, None], full=False)
            tried, found = -1, None
            while found is None:
                count = rank_of(values, rank * size)
                if count != tried:
                    used = left[:, :count]
                    inverse = (right[:count].T / values[:count]) @ (used / sizes[:, None]).T
                    left_over = scaled / sizes - used @ (used.T @ (scaled / sizes))
                    solved = np.linalg.norm(left_over) <= 0.5 * np.linalg.norm(scaled / sizes)
                    found = self._tried(-basis @ inverse, remaining, solved=bool(solved))
                if size <= AT_REST or rank < LEAST_RANK:
                    break
                if found is None:
                    tried = count
                    rank *= 0.01  # what was taken for a free direction may not be one
            if found is None:
                break
            self.z, remaining = found
        if size > AT_REST and settled is not None:
            self.z, size = settled
            self.go(self.z)
        return float(size)

    def _steps(self, starts: Array, kept: bool) -> Array:
        """Steps of z to choose from, along the relations between positions or not.

        The size of a step counts from the declared start, which moves with the parameters that are
        varied: a spring that they stretch is then nearer than a crane that folds.
        """
        n, varied = self.size, len(self.z) - self.size
        along = np.eye(n)
        if kept:
            self.go(self.z)
            rows = self.relations.gradients(self.z[:n])
            along = least(rows, np.zeros(len(rows)))[1]
        along[self.trapped] *= CHEAP
        upper = np.hstack([along, CHEAP * starts])
        lower = np.hstack([np.zeros((varied, along.shape[1])), CHEAP * np.eye(varied)])
        return np.vstack([upper, lower])

    def _tried(
        self, inverse: Array, remaining: Array, *, solved: bool
    ) -> tuple[Array, Array] | None:
        """The largest part of a step that decreases the residuals, or what is left to go.

        Stiff dampers make the scales of some rows large, so that small changes of other residuals
        hide what decreases there. Where this leaves a small part of a step, all of which solves
        the linear equations (`solved`), the next step with the same inverse is compared. It does
        not depend on scales of rows (P. Deuflhard, Newton Methods for Nonlinear Problems, 2004,
        section 3.3).
        """
        step = inverse @ (remaining / self.rows)
        before = float(np.linalg.norm(remaining / self.rows))
        to_go = float(np.linalg.norm(step))
        fraction, found = self._damped(
            step, lambda after, part: np.linalg.norm(after / self.rows) <= part * before, 0.0
        )
        if fraction < _SMALL_PART and solved and to_go > STILL:
            _, other = self._damped(
                step,
                lambda after, part: np.linalg.norm(inverse @ (after / self.rows)) <= part * to_go,
                fraction,
            )
            found = found if other is None else other
        if found is None:
            self.go(self.z)
        return found

    def _damped(
        self, step: Array, decreases: Callable[[Array, float], np.bool_], least: float
    ) -> tuple[float, tuple[Array, Array] | None]:
        """The largest part of a step, above `least`, that decreases a measure of the residuals."""
        fraction = 1.0
        for _ in range(_HALVINGS):
            if fraction <= least:
                break
            z = self.z + fraction * step
            with suppress(Undefined):
                after = self.residuals(z)
                if decreases(after, 1 - 0.1 * fraction):
                    return fraction, (z, after)
            fraction /= 2
        return 0.0, None
