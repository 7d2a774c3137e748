"""Tables of data: a node refers to one by its number, whatever its size.

A table of one argument is a piecewise polynomial: constant (`nearest`), linear, or cubic by values
and slopes. Its pieces are numbered along the argument. Where pieces do not join smoothly there is a
break; the pieces between two breaks are a segment. `place` is a continuous rising function of the
argument whose whole part is the segment, so that `floor(place(x))` is a mode that a step can hold,
and `piece(x, segment)` continues a segment beyond its ends.

A table of two arguments is a grid of values, or of values, slopes and twists (bicubic).

The number of a table encodes the order of the derivative by each argument, `_CODE`. The same in C
is `runtime/c/bgc_tables.h`.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from enum import IntEnum
from functools import cached_property
from hashlib import blake2b
from typing import TypeAlias

from bgc.record_class import dataclass, field

_CODE = 64  # of a number: degree * 16 + order by y * 4 + order by x
_HASH_BYTES = 5


class Method(IntEnum):
    """Shape of the pieces, numbered as in `bgc_tables.h`."""

    NEAREST = 0
    LINEAR = 1
    CUBIC = 2
    STEP = 3  # the value at the last knot before


class Outside(IntEnum):
    """Continuation beyond the first and last knot, numbered as in `bgc_tables.h`."""

    HOLD = 0
    EXTRAPOLATE = 1  # along a straight line
    REPEAT = 2


DEGREE = {Method.NEAREST: 0, Method.LINEAR: 1, Method.CUBIC: 3, Method.STEP: 0}


def number_of(content: bytes, degree: int) -> int:
    """The number of a table with this content; a multiple of nothing but exact as a double."""
    digest = blake2b(content, digest_size=_HASH_BYTES).digest()
    return int.from_bytes(digest, "big") * _CODE + degree * 16


def base_of(number: int) -> int:
    """Number of the table that holds the function; `number` may be a derivative of it."""
    return number - number % 16


def orders_of(number: int) -> tuple[int, int]:
    """The orders of the derivatives by the first and the second argument."""
    return number % 4, number // 4 % 4


def derivative_of(number: int, argument: int) -> int | None:
    """The number of the derivative by an argument (0 or 1); None where that is zero."""
    order, degree = orders_of(number)[argument], number // 16 % 4
    return None if order >= degree else number + 4**argument


@dataclass(frozen=True, eq=False)
class Table:
    """A function of one argument, by knots `x` and values `y`, and slopes `d` if it is cubic.

    `breaks` are the boundaries of segments: numbers of boundaries between pieces; None where every
    boundary is a break. `smooth` is set where there are no segments at all. `source` is the name
    for printing.
    """

    method: Method
    outside: Outside
    x: array[float]
    y: array[float]
    d: array[float]
    breaks: array[int] | None
    smooth: bool
    continuous: bool
    source: str
    strict: bool = False  # outside the knots is an error
    number: int = field(init=False)

    def __post_init__(self) -> None:
        head = f"1 {self.method} {self.outside} {self.strict} {len(self.x)} "
        content = head.encode() + b"".join(bytes(part) for part in (self.x, self.y, self.d))
        object.__setattr__(self, "number", number_of(content, DEGREE[self.method]))

    # --- values ---------------------------------------------------------------------

    def value(self, order: int, x: float) -> float:
        """The function or its derivative."""
        if math.isnan(x):
            return x
        if self.outside is Outside.REPEAT:
            x = self._wrapped(x)[1]
        return self._polynomial(self._piece_at(x), order, x)

    def place(self, x: float) -> float:
        """A continuous rising function whose whole part is the segment of x."""
        if math.isnan(x):
            return x
        cycle = 0.0
        if self.outside is Outside.REPEAT:
            cycle, x = self._wrapped(x)
        piece = self._piece_at(x)
        count = self.break_count
        segment = piece if self.breaks is None else bisect_left(self.breaks, piece)
        repeats = self.outside is Outside.REPEAT
        low = self._boundary(self._break(segment - 1)) if segment > 0 else self.x[0]
        high = self._boundary(self._break(segment)) if segment < count else self.x[-1]
        if segment == 0 and not repeats:
            t = (high - x) / (self.x[-1] - self.x[0])
            return 1 - 0.5 * t / (1 + t) if t < math.inf else 0.5
        if segment == count and not repeats:
            t = (x - low) / (self.x[-1] - self.x[0])
            return count + 0.5 * t / (1 + t) if t < math.inf else count + 0.5
        part = min(max((x - low) / (high - low), 0.0), 1 - 2**-53)
        return cycle * (count + 1) + segment + part

    def piece(self, order: int, x: float, segment: float) -> float:
        """The function or its derivative on a segment, continued beyond its ends."""
        if math.isnan(x) or math.isnan(segment):
            return math.nan
        count = self.break_count
        if self.outside is Outside.REPEAT:
            cycle = math.floor(segment / (count + 1))
            segment -= cycle * (count + 1)
            x -= cycle * (self.x[-1] - self.x[0])
        s = int(min(max(segment, 0), count))
        first = self._break(s - 1) + 1 if s > 0 else 0
        last = self._break(s) if s < count else self._last_piece
        return self._polynomial(min(max(self._piece_at(x), first), last), order, x)

    # --- pieces ---------------------------------------------------------------------

    @property
    def period(self) -> float | None:
        """The distance after which the table repeats; None where it does not."""
        return self.x[-1] - self.x[0] if self.outside is Outside.REPEAT else None

    def polynomials(self) -> tuple[list[float], list[float], list[list[float]]]:
        """The boundaries between pieces, a point of each piece, and the derivatives there.

        The derivatives are by order, from 0 to 3, then by piece. Of a table that repeats, they are
        those of the first period.
        """
        pieces = range(self._last_piece + 1)
        boundaries = [self._boundary(k) for k in pieces[:-1]]
        points = [*boundaries[:1], *boundaries] or [self.x[0]]
        derivatives = [[self._polynomial(k, n, points[k]) for k in pieces] for n in range(4)]
        return boundaries, points, derivatives

    @property
    def break_count(self) -> int:
        """The number of breaks; in a period, without that where it begins again."""
        return self._last_piece if self.breaks is None else len(self.breaks)

    @property
    def _last_piece(self) -> int:
        """The number of the last piece; pieces 0 and n of those that do not repeat are outside."""
        knots = len(self.x)
        if self.method is Method.NEAREST:
            return knots - 1
        if self.method is Method.STEP:
            return knots - 2
        return knots - 2 if self.outside is Outside.REPEAT else knots

    def _break(self, k: int) -> int:
        return k if self.breaks is None else self.breaks[k]

    def _boundary(self, k: int) -> float:
        """The argument between pieces k and k + 1."""
        if self.method is Method.NEAREST:
            return 0.5 * (self.x[k] + self.x[k + 1])
        inner = self.outside is Outside.REPEAT or self.method is Method.STEP
        return self.x[k + 1] if inner else self.x[k]

    def _interval(self, x: float) -> int:
        """The interval of x, counted from 0; the first or last one outside."""
        return min(max(bisect_right(self.x, x) - 1, 0), len(self.x) - 2)

    def _piece_at(self, x: float) -> int:
        k = self._interval(x)
        if self.method is Method.NEAREST:
            return k if x < self._boundary(k) else k + 1
        if self.outside is Outside.REPEAT or self.method is Method.STEP:
            return k
        return 0 if x < self.x[0] else len(self.x) if x >= self.x[-1] else k + 1

    def _wrapped(self, x: float) -> tuple[float, float]:
        """The number of whole periods before x, and x in the first period."""
        start, period = self.x[0], self.x[-1] - self.x[0]
        if not math.isfinite(x):
            return 0.0, math.nan
        cycle = float(math.floor((x - start) / period))
        inside = x - cycle * period
        return cycle, min(max(inside, start), self.x[-1])

    def _polynomial(self, piece: int, order: int, x: float) -> float:
        if self.method in (Method.NEAREST, Method.STEP):
            return self.y[piece] if order == 0 else 0.0
        if self.outside is not Outside.REPEAT:
            if piece in (0, len(self.x)):
                return self._line(0 if piece == 0 else len(self.x) - 1, order, x)
            piece -= 1
        left, right = self.x[piece], self.x[piece + 1]
        low, high = self.y[piece], self.y[piece + 1]
        slope = (high - low) / (right - left)
        if self.method is Method.LINEAR:
            return low + slope * (x - left) if order == 0 else slope if order == 1 else 0.0
        return hermite(order, right - left, x - left, low, slope, self.d[piece], self.d[piece + 1])

    def _line(self, end: int, order: int, x: float) -> float:
        """The straight line beyond one end."""
        if self.outside is Outside.HOLD:
            return self.y[end] if order == 0 else 0.0
        if self.method is Method.CUBIC:
            slope = self.d[end]
        else:
            k = min(end, len(self.x) - 2)
            slope = (self.y[k + 1] - self.y[k]) / (self.x[k + 1] - self.x[k])
        return (
            self.y[end] + slope * (x - self.x[end]) if order == 0 else slope if order == 1 else 0.0
        )


def hermite(
    order: int, h: float, u: float, low: float, slope: float, d0: float, d1: float
) -> float:
    """A cubic at u from its left end, or its derivative; `slope` is that of the chord."""
    c, b = (3 * slope - 2 * d0 - d1) / h, (d0 + d1 - 2 * slope) / (h * h)
    match order:
        case 0:
            return low + u * (d0 + u * (c + u * b))
        case 1:
            return d0 + u * (2 * c + 3 * u * b)
        case 2:
            return 2 * c + 6 * u * b
        case _:
            return 6 * b


@dataclass(frozen=True, eq=False)
class Grid:
    """A function of two arguments inside a grid of values, bilinear or bicubic.

    `z` has len(x) rows of len(y) values; `fields` are the derivatives by x, by y and by both, empty
    for a bilinear function. Outside, the polynomials of the border continue.
    """

    x: array[float]
    y: array[float]
    z: array[float]
    fields: tuple[array[float], ...]
    source: str
    number: int = field(init=False)

    def __post_init__(self) -> None:
        parts = (self.x, self.y, self.z, *self.fields)
        head = f"2 {len(self.x)} {len(self.y)} {len(self.fields)} "
        content = head.encode() + b"".join(bytes(part) for part in parts)
        object.__setattr__(self, "number", number_of(content, 3 if self.fields else 1))

    def value(self, orders: tuple[int, int], x: float, y: float) -> float:
        """The function, or its derivative of the given orders."""
        if math.isnan(x) or math.isnan(y):
            return math.nan
        i, j = _cell(self.x, x), _cell(self.y, y)
        h, u = self.x[i + 1] - self.x[i], x - self.x[i]
        k, v = self.y[j + 1] - self.y[j], y - self.y[j]
        corners = [(i + a) * len(self.y) + j + b for a in (0, 1) for b in (0, 1)]
        if not self.fields:
            weights = ((1 - u / h, u / h), (-1 / h, 1 / h), (0.0, 0.0))
            others = ((1 - v / k, v / k), (-1 / k, 1 / k), (0.0, 0.0))
            across = [a * b for a in weights[min(orders[0], 2)] for b in others[min(orders[1], 2)]]
            return sum(w * self.z[at] for w, at in zip(across, corners, strict=True))
        by_x, by_y, by_both = self.fields
        ends, slopes = [], []
        for at, beyond in (corners[:2], corners[2:]):
            ends.append(_along(orders[1], k, v, self.z, by_y, at, beyond))
            slopes.append(_along(orders[1], k, v, by_x, by_both, at, beyond))
        return hermite(orders[0], h, u, ends[0], (ends[1] - ends[0]) / h, *slopes)

    @cached_property
    def shape(self) -> tuple[int, int]:
        """The numbers of knots of both arguments."""
        return len(self.x), len(self.y)


def _along(
    order: int, k: float, v: float, z: Sequence[float], d: Sequence[float], at: int, beyond: int
) -> float:
    return hermite(order, k, v, z[at], (z[beyond] - z[at]) / k, d[at], d[beyond])


def _cell(knots: Sequence[float], at: float) -> int:
    return min(max(bisect_right(knots, at) - 1, 0), len(knots) - 2)


AnyTable: TypeAlias = Table | Grid
