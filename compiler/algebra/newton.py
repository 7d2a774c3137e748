"""Damped Newton iteration on a few equations given as nodes.

It gives start values and serves checks while compiling; a run solves the same equations in C
(`runtime/c/consistent.c`) with the same natural monotonicity test (Deuflhard 1974).
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

from bgc.algebra.dag import Dag, Symbol
from bgc.algebra.dense import solve_dense
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import Repeated
from bgc.algebra.nodes import Node

_MOST_ELIMINATED_UNKNOWNS = 100  # unknowns; with more, elimination in Python takes too long
_ITERATIONS = 100  # from one point
_WORK = 3e7  # bound of iterations times unknowns^3, some seconds
_SOLVED = 1e-9  # relative size of the last correction
_NEGLIGIBLE = 1e-9  # scale of unknowns that are smaller
_LEAST_DAMPING = 1e-6


class Rows:
    """Equations `residual = 0` in as many unknowns."""

    def __init__(self, dag: Dag, residuals: Sequence[Node], unknowns: Sequence[Symbol]) -> None:
        self._unknowns = unknowns
        symbols = [dag.symbol(u.kind, u.index) for u in unknowns]
        small = len(unknowns) <= _MOST_ELIMINATED_UNKNOWNS
        slopes = [s for r in residuals for s in gradient(dag, r, symbols)] if small else []
        self._residuals = Repeated(dag, residuals)
        self._slopes = Repeated(dag, slopes)

    def solve(self, known: Mapping[Symbol, float], start: Sequence[float]) -> list[float] | None:
        """Find a solution for given values of all other symbols; None if there is none.

        The iteration begins at `start`, then at points of other sizes and signs, since a law may be
        undefined or flat at the first.
        """
        if len(self._unknowns) > _MOST_ELIMINATED_UNKNOWNS:
            return None
        iterations = iter(range(int(_WORK / len(start) ** 3)))
        for point in (start, *_points(len(start))):
            found = self._newton(known, list(point), islice(iterations, _ITERATIONS))
            if found is not None:
                return found
        return None

    def _newton(
        self, known: Mapping[Symbol, float], x: list[float], iterations: Iterator[int]
    ) -> list[float] | None:
        damping = 1.0
        for _ in iterations:
            point = self._point(known, x)
            residual, numbers = self._residuals.at(point), self._slopes.at(point)
            slopes = [numbers[k : k + len(x)] for k in range(0, len(numbers), len(x))]
            change = solve_dense(slopes, residual)
            if change is None:
                return None
            length = _length(change, x)
            if length <= _SOLVED:
                return _moved(x, change, 1.0)
            while damping >= _LEAST_DAMPING:
                trial = _moved(x, change, damping)
                missed = self._residuals.at(self._point(known, trial))
                following = solve_dense(slopes, missed)
                if following is not None and _length(following, x) <= (1 - damping / 4) * length:
                    break
                damping /= 2
            else:
                return None
            x = trial
            damping = min(1.0, 4 * damping)
        return None

    def _point(self, known: Mapping[Symbol, float], x: Sequence[float]) -> dict[Symbol, float]:
        return {**known, **dict(zip(self._unknowns, x, strict=True))}


def _points(size: int) -> Iterator[list[float]]:
    """Further starting points: all unknowns equal, then each with a random sign and size."""
    for value in (1e-3, -1e-3, 1.0, -1.0, 1e3, -1e3):
        yield [value] * size
    rng = random.Random(1)
    for _ in range(10):
        yield [rng.choice((-1, 1)) * 10 ** rng.uniform(-3, 2) for _ in range(size)]


def _length(change: Sequence[float], x: Sequence[float]) -> float:
    parts = (c / max(abs(v), _NEGLIGIBLE) for c, v in zip(change, x, strict=True))
    return math.hypot(*parts) / math.sqrt(len(x))


def _moved(x: Sequence[float], change: Sequence[float], part: float) -> list[float]:
    return [v + part * c for v, c in zip(x, change, strict=True)]
