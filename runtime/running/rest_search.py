"""The search for rest: the state nearest to the given initial one at which all rates vanish.

Inputs and devices have their first values, and sources their values at the start. With y = x/s, the
states in their scales, the equations are

    f(x, p) = 0     the rates, and the algebraic equations
    g(x) = 0        the conditions and flows that keep chains of rigid connections closed
    h(x) = h(x0)    the values to be held

First the momenta become those of standstill: speeds of the start do not steer the search. Steps of
Gauss and Newton of least length solve the equations (A. Ben-Israel, J. Math. Anal. Appl. 15, 1966).
Then steps within the space of directions that no equation restores, each followed by steps of the
first kind, determine the rest. Relations between positions that no motion of the system changes
hold as at the declared start y0: the pose of a ship follows the spring that carries it, and a rope
is as long as its ends are apart. Conserved quantities of other kinds, such as oil between closed
valves, come next. What is then still free is as near to y0 as possible, first what stores energy:
a yaw or a joint under a rate drive stays where it was put. The start y0 may depend on the
parameters p that are varied.

Displacements that nothing moves and that start at zero, as the oil that has flowed into a cylinder
since its valves were shut, give way before given positions do: as few of them as possible, those
whose efforts have to change least. Under a load, a cylinder keeps its extension and the pressure of
its rod side, and the pressure of the bore follows.

Relations between positions hold to the accuracy of the solution: they are compared with a point
that a path of possible motions reaches from y0 (`relations.py`), and the last steps serve them
alone. Only values that are held may contradict them. Rows are scaled to entries of one; singular
values below a tolerance, which decreases with the residuals, count as zero.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from itertools import islice
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from bgc.language.scene import Rest
from bgc.runtime.linear.equilibrium import find_equilibrium
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest_report import Fixed
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.relations import NEARBY, Undefined, orthonormal
from bgc.runtime.running.rest_algebra import leading_rows, least, rank_of, row_scales, svd
from bgc.runtime.running.rest_newton import AT_REST, CHEAP, ROUNDING, STILL, RestNewton

_ITERATIONS = 200
_BOUNDED_ITERATIONS = 3  # from the end of a step that a valve bounds
_FEWER_ITERATIONS = 40  # where the system itself is followed afterwards
_WORSE = (10.0, 2.0)  # growth of the rates in a step of the system: bold steps first
_RELAXATIONS = 3  # in vain, of a whole search
_FEWER_STEPS = 100  # of those that only move what no relation joins
_LAST_STEPS = 100  # at least, of those that restore relations between positions
_QUARTERINGS = 4  # of a step along free directions
_NEAR = 0.5  # of the length of such a step
_FARTHER = 0.5  # of a step along free directions, for terms of higher order
_IDLE = 3  # steps along free directions that hardly come nearer to the declared start
_INDEPENDENT = 1e-6  # of free directions, the part that two states have in common
_MIXED = 1e-13  # of the square of a unit vector: rounding
_NEARLY_STILL = 1e-8  # of a step along free directions where steps no longer become shorter

Found = TypeVar("Found")


def _of_point(method: Callable[[RestSearch], Found]) -> Callable[[RestSearch], Found]:
    """Keep the result of a method that depends on z and on the relations until these change."""

    @wraps(method)
    def kept(search: RestSearch) -> Found:
        search.go(search.z)
        place = search.z.tobytes(), len(search.relations.rows)
        if search.known_at != place:
            search.known_at, search.known = place, {}
        if method.__name__ not in search.known:
            search.known[method.__name__] = method(search)
        found: Found = search.known[method.__name__]
        return found

    return kept


class RestSearch(RestNewton):
    """The search of one instance: z holds the states in their scales, then the parameters."""

    def __init__(self, instance: Instance, rest: Rest) -> None:
        super().__init__(instance, rest)
        self.stiffness = np.zeros(self.size)
        self.stiffness[: len(rest.stiffness)] = rest.stiffness
        self.unread = np.zeros(0, dtype=np.intp)
        # Directions that rest leaves free: what fixes some, states that take part, their motion in
        # all that are free then, and how many are fixed.
        self.left_free: list[tuple[Fixed, NDArray[np.intp], Array, int]] = []
        self.relaxations = 0  # in vain
        self.known: dict[str, Any] = {}  # what has been found at the point `known_at`
        self.known_at = b"", 0
        self.reached = self.start  # the last point that a motion reaches from y0
        self.reached_at = self._conditions()
        self.arrived = True  # the path to that point was followed to its end
        self.nearest: Array | None = None  # to rest, of where relations hold: the first one found

    # --- relations between positions ----------------------------------------------------------

    def _conditions(self) -> tuple[bytes, int]:
        """The parameters that are varied and the number of positions that relations may join."""
        return self.z[self.size :].tobytes(), len(self.relations.rows)

    @_of_point
    def off(self) -> Array:
        """The distance of y from the point near it that a motion reaches from y0."""
        y = self.z[: self.size]
        with suppress(Undefined):
            while True:
                begin = self.reached if self._conditions() == self.reached_at else self.declared
                before = self.reached_at = self._conditions()
                self.reached, self.arrived = self.relations.reached(begin, y)
                if self._conditions() == before:
                    return y - self.reached
        self.arrived = True
        self.reached = self.declared  # the path leads through points without rates
        return y - self.declared

    # --- steps --------------------------------------------------------------------------------

    def run(self, *, giving_way: bool = True) -> None:
        """Go to a state of rest, and from there along such states to the one that is wanted.

        `giving_way` tells whether trapped displacements do so before given positions.
        """
        with suppress(Undefined):
            self._stop()
            self.unread = self._unread()
            if giving_way:
                self.trapped = self._trapped()
        self._restore()
        if not self.trapped.size:
            self._approach()
        else:
            with suppress(Undefined):
                self._return()
            self._approach(related=True)
            self.steps_left = min(self.steps_left, _FEWER_STEPS)
            self._approach(related=False)
            self.steps_left = max(self.steps_left, _LAST_STEPS)
            self._approach(related=True)
        self._follow()
        self._relate()

    def _approach(self, *, related: bool | None = None) -> None:
        """Go along free directions: all, or those in which related positions take part, or not.

        A valve bounds some of the others, such as the oil of a line: what stands at its bound keeps
        a step from being taken as a whole, and must not keep the positions from theirs.
        """
        before, idle = np.inf, 0
        while self.steps_left > 0 and idle < _IDLE:
            along = self.along()
            if related is not None:
                along = self._part(along, related=related)
            sizes = np.abs(along)
            sizes[self.trapped] *= CHEAP
            size = float(sizes.max(initial=0.0))
            if size <= STILL or (size <= _NEARLY_STILL and size > 0.5 * before):
                break
            distance = self._distance()
            farther = _FARTHER * float(np.abs(along).max()) if related else 0.0
            if not self._followed(along, distance + farther, bounded=related is False):
                break
            idle = idle + 1 if self._distance() > 0.99 * distance and size > 0.9 * before else 0
            before = size

    def _part(self, along: Array, *, related: bool) -> Array:
        """The part of a step in free directions in which related positions take part, or not."""
        free = self._free()
        near = free @ free.T
        own = np.sqrt(near.diagonal())
        found = np.zeros(len(along), dtype=bool)
        new = np.zeros(len(along), dtype=bool)
        new[self.relations.rows] = new[self.size :] = True
        joined = np.abs(near) > _INDEPENDENT * np.outer(own, own) + _MIXED
        while new.any():
            found |= new
            new = joined[new].any(axis=0) & ~found
        return np.where(found == related, along, 0.0)

    def _stop(self) -> None:
        """Change the momenta by the least with which no position moves."""
        z, n = self.z.copy(), self.size
        z[:n] += self.relations.stopping(z[:n], self.residuals(z)[:n])
        self.residuals(z)
        self.z = z

    def _return(self) -> None:
        """Return to rest from the positions of the declared start, with what else is at rest now.

        Where valves open and close, rest is found with positions that tear relations. With the
        valves as they are at rest, it may be found next to the declared positions.
        """
        begin, z = self.z, self.z.copy()
        places = np.concatenate([self.relations.rows, self.trapped])
        z[places] = self.declared[places]
        self.z = z
        if (
            self.held
            or np.abs(z - begin).max() <= STILL
            or self._newton(_FEWER_ITERATIONS, kept=True) > AT_REST
        ):
            self.z = begin
            self.go(begin)

    def _trapped(self) -> NDArray[np.intp]:
        """The displacements that nothing moves, as oil between shut valves, and that start at zero.

        Their rates depend on nothing but states that keep their own value, such as the opening of a
        valve that is shut. What is counted from the start on may give way; a charge that is given
        may not.
        """
        n, momenta = self.size, set(self.momenta)
        slope, _ = self.slopes(self.z)
        still = np.abs(self.residuals(self.z)[:n]) <= STILL
        read = [set(np.flatnonzero(row).tolist()) for row in slope[:n, :n]]
        own = {k for k in range(n) if still[k] and k not in momenta and read[k]}
        kept: set[int] = set()
        while more := {k for k in own - kept if read[k] <= kept | {k}}:
            kept |= more
        zero = (self.stiffness != 0) & still & (self.declared == 0)
        found = [k for k in np.flatnonzero(zero).tolist() if k not in momenta and read[k] <= kept]
        return np.array(found, dtype=np.intp)

    def _unread(self) -> NDArray[np.intp]:
        """The states that no equation reads, here or nearby, and no relation joins: integrals."""
        n = self.size
        nearby = self.z.copy()
        nearby[:n] += NEARBY * np.random.default_rng(1).uniform(0.5, 1, n)
        reads = np.zeros(n, dtype=bool)
        for z in (self.z, nearby):
            reads |= self.slopes(z)[0][:, :n].any(axis=0)
        reads[self.relations.rows] = True
        return np.flatnonzero(~reads)

    def _follow(self) -> None:
        """Put states that nothing reads where conserved quantities have them, near their start."""
        if self.unread.size:
            kept = self._conserved(self.momenta)
            self.z = self.z.copy()
            self.z[self.unread] = self.declared[self.unread]
            away = self.z[: self.size] - self.declared
            self.z[self.unread] += least(kept[:, self.unread], -kept @ away)[0]

    def _relate(self) -> None:
        """Restore the relations between positions, and nothing else along free directions."""
        self.steps_left = max(self.steps_left, _LAST_STEPS)
        before = np.inf
        while True:
            along, size = self._towards_relations()
            if size <= ROUNDING or size > 0.5 * before or not self._followed(along):
                return
            before = size

    def _relax(self) -> float:
        """Follow the system itself from z, ever more damped; return the largest scaled residual."""
        begin = self.z

        def rates(y: Array) -> Array:
            try:
                return self.residuals(y)[: self.size]
            except Undefined:
                return np.full(self.size, np.nan)

        def slope(y: Array) -> Array:
            return self.slopes(y)[0][: self.size]

        def projected(y: Array) -> Array:
            self.go(y)
            self.instance.restart()
            moved: Array = self.resting.state / self.scale
            return moved

        everywhere = np.eye(self.size), np.arange(self.size)
        for worse in _WORSE:
            with suppress(Undefined):
                self.z, _ = find_equilibrium(
                    rates, slope, self.mass, begin, projected, lambda _: everywhere, worse
                )
                size = self._newton(_FEWER_ITERATIONS, kept=True)
                if size <= AT_REST:
                    return size
            self.z = begin
        return np.inf

    def _followed(self, along: Array, distance: float = np.inf, *, bounded: bool = False) -> bool:
        """Take a large part of a step along free directions from which rest is found again.

        Where valves open and close, rest may be found far away: the distance must not increase. If
        a valve bounds the step (`bounded`), the largest part that ends near to rest comes first,
        and rest is found by a few steps of Newton's method or not at all.
        """
        begin = self.z
        parts = [0.25**k for k in range(_QUARTERINGS)]
        if bounded:
            halves = (0.5**k for k in range(2 * _QUARTERINGS))
            parts = [*islice((a for a in halves if self._is_near(begin, a * along)), 1), *parts]
        for part in parts:
            self.z = begin + part * along
            if self.steps_left <= 0:
                break
            with suppress(Undefined):
                size = self._newton(_BOUNDED_ITERATIONS, kept=True) if bounded else self._restore()
                if size <= AT_REST and self._distance() <= 1.001 * distance + STILL:
                    return True
        self.z = begin
        self.go(begin)
        return False

    def _is_near(self, begin: Array, step: Array) -> bool:
        """Test whether rest is near to the end of a step, in the scales of rows at its begin."""
        with suppress(Undefined):
            misfit = np.abs(self.residuals(begin + step) / self.rows).max(initial=0.0)
            return bool(misfit <= _NEAR * np.abs(step).max(initial=0.0))
        return False

    def _distance(self) -> float:
        """Distance from the declared start without what is trapped.

        Conserved quantities have ten times the weight.
        """
        kept = self._leading()
        away = self.z[: self.size] - self.declared
        away[self.trapped] = away[self.unread] = 0.0
        return float(np.linalg.norm(away) + 10 * np.linalg.norm(kept @ away))

    def _restore(self) -> float:
        """Go to a state of rest; return the largest scaled residual.

        Steps keep relations between positions to the first order, unless values that are held or
        the parameters that are varied prevent that.
        """
        begin = self.z
        if not self.held:
            size = self._newton(_FEWER_ITERATIONS, kept=True)
            self.nearest = self.z if self.nearest is None else self.nearest
            if size > AT_REST and not self.varied and self.relaxations < _RELAXATIONS:
                self.z = begin
                size = self._relax()
                self.relaxations += size > AT_REST
            if size <= AT_REST:
                return size
            self.z = begin
        return self._newton(_ITERATIONS, kept=False)

    def _related(self, starts: Array) -> Array:
        """Changes of the relations between positions by z."""
        rows = self.relations.gradients(self.z[: self.size])
        changes: Array = rows @ np.hstack([np.eye(self.size), -starts])
        return changes

    @_of_point
    def _slopes(self) -> tuple[Array, Array]:
        return self.slopes(self.z)

    @_of_point
    def _free(self) -> Array:
        """Directions that no equation restores."""
        slope, _ = self._slopes()
        rows = row_scales(slope)
        _, values, right = svd(slope / rows[:, None])
        free: Array = right[rank_of(values, 0.0) :].T
        return free

    def along(self) -> Array:
        """The step along directions that no equation restores.

        It leads to where the relations between positions hold, as far as held values allow, then to
        where conserved quantities are those of the declared start, and of what is then left to the
        nearest state.
        """
        free, (_, starts) = self._free(), self._slopes()
        self.left_free = []
        if not free.size:
            return np.zeros(len(self.z))
        away = self.z[: self.size] - self.declared
        moved = np.hstack([np.eye(self.size), -starts]) @ free  # of y - y0, by the free directions
        kept = self._leading()
        changes, off = self._unrelated()
        found, others = least(changes @ free, -off)
        self.left_free = [("joined", self.relations.rows, moved, moved.shape[1] - others.shape[1])]
        every = np.eye(self.size)
        untied = np.delete(np.arange(self.size), [*self.trapped, *self.unread])
        stored = untied[self.stiffness[untied] != 0]
        for rows in (kept, every[stored], every[untied], None):
            rows = self._stiffest(moved @ others) if rows is None else rows
            matrix = rows @ moved
            wanted = -rows @ away - matrix @ found
            step, left = least(matrix @ others, wanted, np.abs(moved).max(initial=0.0))
            places = np.flatnonzero(rows.any(axis=0))
            fixed: Fixed = "conserved" if rows is kept else "kept"
            count = others.shape[1] - left.shape[1]
            self.left_free.append((fixed, places, moved @ others, count))
            found, others = found + others @ step, others @ left
        along: Array = free @ found
        return along

    def _stiffest(self, moved: Array) -> Array:
        """Rows of as many trapped displacements as directions are left, which `moved` holds.

        They are those whose efforts would have to change most: of a loaded cylinder the oil on the
        rod side, whose area is smaller than that of the bore.
        """
        efforts = moved[self.trapped] * (self.stiffness * self.scale)[self.trapped, None]
        rows: Array = np.eye(self.size)[self.trapped[leading_rows(efforts, efforts.shape[1])]]
        return rows

    @_of_point
    def _unrelated(self) -> tuple[Array, Array]:
        """Changes of the relations between positions by z, and by how much they are violated."""
        off = self.off()
        changes = self._related(self._slopes()[1])
        return changes, changes[:, : self.size] @ off

    def _towards_relations(self) -> tuple[Array, float]:
        """The least step along free directions that restores the relations, and their violation."""
        free = self._free()
        changes, off = self._unrelated()
        step, _ = least(changes @ free, -off)
        return free @ step, float(np.abs(off).max(initial=0.0))

    @_of_point
    def _leading(self) -> Array:
        """Gradients of the conserved quantities that lead the search."""
        return self._conserved([*self.momenta, *self.trapped, *self.unread])

    def _conserved(self, without: list[int]) -> Array:
        """Gradients of the conserved quantities without some states: l' M with l' df/dy = 0.

        Such as the difference between the stretch of a spring and an angle that is integrated from
        the same rate. Their rows are orthonormal.
        """
        slope = self._slopes()[0][: self.size, : self.size]
        rows = row_scales(slope)
        left, values, _ = svd(slope / rows[:, None])
        kept = (left[:, rank_of(values, 0.0) :] / rows[:, None]).T @ self.mass
        if kept.size:
            kept = orthonormal(kept.T).T
            _, others = least(kept[:, without].T, np.zeros(len(without)))
            kept = others.T @ kept
        return kept
