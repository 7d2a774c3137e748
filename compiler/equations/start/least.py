"""The least change of the free states of a start that satisfies conditions, in numbers.

Each step solves the conditions linearised at the present point, with the least change from the
start (sequential quadratic programming with a fixed diagonal metric):

    [D A'; A 0] [dy; l] = [D (y0 - y); -F],    D = 1/size^2 of a free state, 0 of a loop's unknown.

The sizes equilibrate A at the first point: a merged momentum or an unknown of a loop has no certain
scale, and may be twelve orders beside the others.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from operator import mul, truediv

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.dense import solve_dense
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import Repeated
from bgc.algebra.newton import Rows
from bgc.ir.graph import Node

_ITERATIONS = 60
_CONVERGED = 1e-11  # the last change, relative to the unknowns
_SATISFIED = 1e-10  # conditions, relative to their terms
_LEAST_DAMPING = 1e-6
_SCALE_PART = 1e-6  # part of an unknown's scale
_SCALINGS = 4  # of rows and columns by turns


class LeastChange:
    """Conditions in START symbols: the first `free` are states, the others unknowns of loops.

    `rows` are the equations of the loops, `start` and `sizes` the present values and the scales of
    all unknowns, `known` the values of all other symbols, `first` the index of the first unknown.
    """

    def __init__(
        self,
        dag: Dag,
        rows: Sequence[Node],
        free: int,
        start: Sequence[float],
        sizes: Sequence[float],
        known: Mapping[Symbol, float],
        first: int,
    ) -> None:
        self._dag = dag
        self._rows = list(rows)
        self._free = free
        self._start = list(start)
        self._sizes = list(sizes)
        self._known = known
        self._unknowns = [Symbol(Kind.START, first + k) for k in range(len(start))]
        self._symbols = [dag.symbol(u.kind, u.index) for u in self._unknowns]
        self._slopes: dict[Node, list[Node]] = {}
        self._repeated: dict[tuple[Node, ...], Repeated] = {}

    def values(self, nodes: Sequence[Node], at: Sequence[float]) -> list[float]:
        """The values of nodes at a point."""
        point = dict(zip(self._unknowns, at, strict=True))
        found = self._repeated.get(tuple(nodes))
        if found is None:
            found = self._repeated[tuple(nodes)] = Repeated(self._dag, nodes)
        return found.at({**self._known, **point})

    def solve(self, residuals: Sequence[Node]) -> list[float] | None:
        """The point nearest to the start at which residuals and the loops' equations are zero."""
        for point in self._points():
            found = self._descend([*residuals, *self._rows], point)
            if found is not None:
                return found
        return None

    def rows_near(self, residuals: Sequence[Node]) -> list[list[float]]:
        """The derivatives of residuals by the free states, loops closed, near the start."""
        point = self._generic_point
        inner, outer = self._slopes_at(self._rows, point), self._slopes_at(residuals, point)
        free, loops = range(self._free), [row[self._free :] for row in inner]
        moved = [solve_dense(loops, [row[j] for row in inner]) if inner else [] for j in free]
        rows = []
        for row in outer:
            total = list(row[: self._free])
            for j in free:
                column = moved[j]
                if column is not None:
                    total[j] += sum(a * b for a, b in zip(row[self._free :], column, strict=True))
            rows.append(total)
        return rows

    def multipliers(
        self, slopes: Sequence[Node], residuals: Sequence[Node], at: Sequence[float]
    ) -> list[float] | None:
        """The multipliers l with which `A' l` comes nearest to the slopes."""
        target = self.values(slopes, at)
        table = self._slopes_at(residuals, at)
        solved = self._step(table, target, [0.0] * len(residuals), self._sizes_in(table))
        return None if solved is None else solved[1]

    # --- iteration ----------------------------------------------------------------------------

    def _descend(self, residuals: Sequence[Node], point: Sequence[float]) -> list[float] | None:
        y, units = list(point), self._sizes_in(self._slopes_at(residuals, point))
        for _ in range(_ITERATIONS):
            missed, slopes = self.values(residuals, y), self._slopes_at(residuals, y)
            pull = [0.0] * len(y)
            for j in range(self._free):
                pull[j] = (self._start[j] - y[j]) / units[j] ** 2
            solved = self._step(slopes, pull, [-x for x in missed], units)
            if solved is None:
                return None
            change = solved[0]
            sizes = [self._size(slopes[r], y) for r in range(len(residuals))]
            part = self._accepted(residuals, sizes, y, change, missed)
            if part is None:
                return None
            y = [a + part * b for a, b in zip(y, change, strict=True)]
            if part == 1.0 and self._is_small(change, y):
                return y
        return None

    def _accepted(
        self,
        residuals: Sequence[Node],
        sizes: Sequence[float],
        y: Sequence[float],
        change: Sequence[float],
        missed: Sequence[float],
    ) -> float | None:
        """The largest part of a change with which the residuals shrink; None if there is none."""
        before, part = _norm(missed, sizes), 1.0
        while part >= _LEAST_DAMPING:
            trial = [a + part * b for a, b in zip(y, change, strict=True)]
            after = _norm(self.values(residuals, trial), sizes)
            if after <= max((1 - part / 4) * before, _SATISFIED):
                return part
            part /= 2
        return None

    def _step(
        self,
        slopes: Sequence[Sequence[float]],
        pull: Sequence[float],
        right: Sequence[float],
        sizes: Sequence[float],
    ) -> tuple[list[float], list[float]] | None:
        """The change of the unknowns and the multipliers: the linear system of a step."""
        count, more = len(self._start), len(slopes)
        scaled = [[a * s for a, s in zip(row, sizes, strict=True)] for row in slopes]
        lengths = [_largest(row) or 1.0 for row in scaled]
        scaled = [[a / x for a in row] for row, x in zip(scaled, lengths, strict=True)]
        table = [
            [float(i == j < self._free) for j in range(count)] + [row[i] for row in scaled]
            for i in range(count)
        ]
        table += [[*row, *(0.0 for _ in range(more))] for row in scaled]
        wanted = [a * s for a, s in zip(pull, sizes, strict=True)]
        wanted += [a / x for a, x in zip(right, lengths, strict=True)]
        solved = solve_dense(table, [-x for x in wanted]) if table else []
        if solved is None:
            return None
        change = [a * s for a, s in zip(solved, sizes, strict=False)]
        return change, [a / x for a, x in zip(solved[count:], lengths, strict=True)]

    def _sizes_in(self, slopes: Sequence[Sequence[float]]) -> list[float]:
        """The sizes of unknowns with which each row and column, scaled, has an entry near 1."""
        sizes = self._sizes
        for _ in range(_SCALINGS if slopes else 0):
            lengths = [_largest(map(mul, row, sizes)) or 1.0 for row in slopes]
            columns = (map(truediv, column, lengths) for column in zip(*slopes, strict=True))
            sizes = [1.0 / (_largest(column) or 1.0) for column in columns]
        return sizes

    def _size(self, row: Sequence[float], y: Sequence[float]) -> float:
        """The size of a residual's terms."""
        parts = (abs(a) * max(abs(v), s) for a, v, s in zip(row, y, self._sizes, strict=True))
        return sum(parts) or 1.0

    def _is_small(self, change: Sequence[float], y: Sequence[float]) -> bool:
        return all(
            abs(c) <= _CONVERGED * max(abs(v), _SCALE_PART * s)
            for c, v, s in zip(change, y, self._sizes, strict=True)
        )

    def _slopes_at(self, nodes: Sequence[Node], at: Sequence[float]) -> list[list[float]]:
        for node in nodes:
            if node not in self._slopes:
                self._slopes[node] = gradient(self._dag, node, self._symbols)
        numbers = self.values([x for node in nodes for x in self._slopes[node]], at)
        size = len(self._symbols)
        return [numbers[k * size : (k + 1) * size] for k in range(len(nodes))]

    # --- points -------------------------------------------------------------------------------

    def _points(self) -> Iterator[list[float]]:
        """The start, then points around it: a law may be flat or undefined there."""
        yield self._start
        for part in (1e-2, -1e-2, 1.0, -1.0):
            yield self._around(part)
        rng = random.Random(1)
        for _ in range(8):
            yield self._around(
                *(rng.choice((-1, 1)) * 10 ** rng.uniform(-2, 2) for _ in self._start)
            )

    def _around(self, *parts: float) -> list[float]:
        each = parts if len(parts) == len(self._start) else parts[:1] * len(self._start)
        return [x + p * s for x, p, s in zip(self._start, each, self._sizes, strict=True)]

    @cached_property
    def _generic_point(self) -> list[float]:
        """A point near the start that satisfies the equations of the loops."""
        rng = random.Random(2)
        loops = Rows(self._dag, self._rows, self._unknowns[self._free :])
        for part in (0.3, 0.03, 0.003):
            point = self._around(*(part * rng.uniform(0.5, 1.0) for _ in self._start))
            if not self._rows:
                return point
            fixed = dict(zip(self._unknowns[: self._free], point, strict=False))
            found = loops.solve({**self._known, **fixed}, self._start[self._free :])
            if found is not None:
                return [*point[: self._free], *found]
        return self._start


def _largest(entries: Iterable[float]) -> float:
    return max(map(abs, entries), default=0.0)


def _norm(residuals: Sequence[float], sizes: Sequence[float]) -> float:
    values = [x / s for x, s in zip(residuals, sizes, strict=True)]
    return math.hypot(*values) if all(map(math.isfinite, values)) else math.inf
