"""Interval arithmetic (Moore 1966): where the result of an operation lies, given its operands.

Each row of `operations` names its rule here. A rule is written once for all kinds of ends: doubles,
and nodes of a graph (`interpretation`). `bgc_ranges.h` has the same rules in C.

A bound holds for every value that doubles reach, while operands and results are finite. Rounding
of sums, products, quotients and square roots is monotone, so their rounded ends bound the results;
a product and a sum that the C compiler contracts may differ by the rounding of the product.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Generic, TypeAlias, TypeVar

from bgc.record_class import dataclass

End = TypeVar("End")


@dataclass(frozen=True, slots=True)
class Interval(Generic[End]):
    """All numbers between two ends, which belong to it; None where there is no end."""

    low: End | None = None
    high: End | None = None


@dataclass(frozen=True, slots=True)
class Ends(Generic[End]):
    """Arithmetic on the ends of intervals.

    Attributes
    ----------
    const
        The end of an exact number.
    add, mul, div, neg, least, greatest
        The operations on ends.
    call
        An operation, given by its number, on ends.
    outwards
        The results of an operation, given by its number, with its errors, and without ends that
        are no numbers.
    numbers
        Two numbers between which an end lies in any case; infinite where none is known.
    """

    const: Callable[[Fraction], End]
    add: Callable[[End, End], End]
    mul: Callable[[End, End], End]
    div: Callable[[End, End], End]
    neg: Callable[[End], End]
    least: Callable[[End, End], End]
    greatest: Callable[[End, End], End]
    call: Callable[..., End]
    outwards: Callable[[int, Interval[End]], Interval[End]]
    numbers: Callable[[End], tuple[float, float]]


Rule: TypeAlias = Callable[..., Interval[Any]]
"""(ends, the operation on ends, *operands) -> where the result is, within the image of the row."""

Limits: TypeAlias = tuple[Fraction | int | None, Fraction | int | None]
"""The least and the greatest number of a set; None where there is none."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """The rule of an operation, and its function in `bgc_ranges.h`, less the prefix `bgc_range_`.

    `takes_function` tells that the function in C has the operation itself as its first argument.
    """

    c: str
    rule: Rule
    takes_function: bool = False


def numbers_of(ends: Ends[End], a: Interval[End]) -> tuple[float, float]:
    """Two numbers between which all of an interval lies in any case."""
    low = -math.inf if a.low is None else ends.numbers(a.low)[0]
    high = math.inf if a.high is None else ends.numbers(a.high)[1]
    return low, high


def within(ends: Ends[End], a: Interval[End], limits: Limits) -> Interval[End]:
    """The part of an interval within limits."""
    least, most = limits
    low, high = a.low, a.high
    if least is not None and (low is None or not ends.numbers(low)[0] >= least):
        end = ends.const(Fraction(least))
        low = end if low is None else ends.greatest(low, end)
    if most is not None and (high is None or not ends.numbers(high)[1] <= most):
        end = ends.const(Fraction(most))
        high = end if high is None else ends.least(high, end)
    return Interval(low, high)


def _both(f: Callable[[End, End], End], a: End | None, b: End | None) -> End | None:
    """A function of two ends, None where one is missing."""
    return None if a is None or b is None else f(a, b)


def _either(f: Callable[[End, End], End], a: End | None, b: End | None) -> End | None:
    """A function of the ends that there are."""
    return b if a is None else a if b is None else f(a, b)


def _hull(ends: Ends[End], *found: Interval[End]) -> Interval[End]:
    """The smallest interval that holds some others."""
    hull = found[0]
    for other in found[1:]:
        low = _both(ends.least, hull.low, other.low)
        hull = Interval(low, _both(ends.greatest, hull.high, other.high))
    return hull


def corners(
    ends: Ends[End], f: Callable[[End, End], End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """The hull of an operation at all pairs of ends, between which it is monotone in each operand.

    Unknown unless there are all four ends.
    """
    values = [_both(f, x, y) for x in (a.low, a.high) for y in (b.low, b.high)]
    return _hull(ends, *(Interval(value, value) for value in dict.fromkeys(values)))


# --- arithmetic ---------------------------------------------------------------------------------


def unknown(ends: Ends[End], f: Callable[..., End], *operands: Interval[End]) -> Interval[End]:
    """Anywhere in the image."""
    return Interval()


def total(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """The sums of both ends."""
    return Interval(_both(ends.add, a.low, b.low), _both(ends.add, a.high, b.high))


def opposite(ends: Ends[End], f: Callable[..., End], a: Interval[End]) -> Interval[End]:
    """The negative of an interval."""
    low = None if a.high is None else ends.neg(a.high)
    return Interval(low, None if a.low is None else ends.neg(a.low))


def difference(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """A sum with the opposite."""
    return total(ends, f, a, opposite(ends, f, b))


def product(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """By the signs of the factors where they are known, else by all four ends."""
    for factor, other in ((a, b), (b, a)):
        least, most = numbers_of(ends, factor)
        if most <= 0 and least < 0:
            return opposite(ends, f, product(ends, f, opposite(ends, f, factor), other))
        first, last = numbers_of(ends, other)
        if least >= 0 and first >= 0:
            low = _both(ends.mul, factor.low, other.low)
            return Interval(low, _both(ends.mul, factor.high, other.high))
        if least >= 0 and last > 0:
            lows = (_both(ends.mul, x, other.low) for x in (factor.low, factor.high))
            highs = (_both(ends.mul, x, other.high) for x in (factor.low, factor.high))
            return Interval(_both(ends.least, *lows), _both(ends.greatest, *highs))
    return corners(ends, ends.mul, a, b)


def quotient(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """By the sign of the divisor, which may reach zero only beside a dividend of one sign."""
    least, most = numbers_of(ends, b)
    if most <= 0 and least < 0:
        return opposite(ends, f, quotient(ends, f, a, opposite(ends, f, b)))
    if least < 0:
        return corners(ends, ends.div, a, b) if b.low == b.high else Interval()
    zero = ends.const(Fraction(0))
    first, last = numbers_of(ends, a)

    def far(x: End | None) -> End | None:  # beside the largest divisor
        return None if x is None else zero if b.high is None else ends.div(x, b.high)

    def near(x: End | None) -> End | None:  # beside the smallest divisor
        return ends.div(x, b.low) if x is not None and b.low is not None and least > 0 else None

    if first >= 0:
        return Interval(far(a.low), near(a.high))
    if last <= 0:
        return Interval(near(a.low), far(a.high))
    low, high = _both(ends.least, near(a.low), far(a.low)), near(a.high)
    return Interval(low, _both(ends.greatest, high, far(a.high)))


def power(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """A negative base has a power with a whole exponent only."""
    exponent, most = numbers_of(ends, b)
    base, _ = numbers_of(ends, a)
    if exponent != most or not math.isfinite(exponent):
        if base < 0:
            return Interval()
        found = corners(ends, f, a, b) if base > 0 else Interval(None, None)
        return within(ends, found, (0, None))
    if exponent % 2 == 1:
        if exponent > 0:
            return rising(ends, lambda x: f(x, b.low), a)
        if base <= 0:
            return Interval()
    elif exponent % 2 == 0:
        a = size(ends, f, a)
    a = within(ends, a, (0, None))
    if exponent >= 0:
        return rising(ends, lambda x: f(x, b.low), a)
    return within(ends, falling(ends, lambda x: f(x, b.low), a), (0, None))


def choice(
    ends: Ends[End],
    f: Callable[..., End],
    condition: Interval[End],
    yes: Interval[End],
    no: Interval[End],
) -> Interval[End]:
    """One of both, by the condition where it is certain."""
    least, most = numbers_of(ends, condition)
    if least > 0 or most < 0:
        return yes
    return no if least == most == 0 else _hull(ends, yes, no)


def remainder(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """No larger than either operand, with the sign of the first one."""
    most = _either(ends.least, size(ends, f, a).high, size(ends, f, b).high)
    below, above = numbers_of(ends, a)
    zero, least = ends.const(Fraction(0)), None if most is None else ends.neg(most)
    return Interval(zero if below >= 0 else least, zero if above <= 0 else most)


# --- functions ----------------------------------------------------------------------------------


def rising(ends: Ends[End], f: Callable[..., End], a: Interval[End]) -> Interval[End]:
    """The values at both ends."""
    low = None if a.low is None else f(a.low)
    return Interval(low, None if a.high is None else f(a.high))


def falling(ends: Ends[End], f: Callable[..., End], a: Interval[End]) -> Interval[End]:
    """The values at both ends, exchanged."""
    found = rising(ends, f, a)
    return Interval(found.high, found.low)


def size(ends: Ends[End], f: Callable[..., End], a: Interval[End]) -> Interval[End]:
    """The absolute values in an interval."""
    least, most = numbers_of(ends, a)
    if least >= 0:
        return a
    turned = opposite(ends, f, a)
    if most <= 0:
        return turned
    low = _either(ends.greatest, a.low, turned.low)
    return within(ends, Interval(low, _both(ends.greatest, a.high, turned.high)), (0, None))


def even(ends: Ends[End], f: Callable[..., End], a: Interval[End]) -> Interval[End]:
    """An even function that rises from zero on."""
    return rising(ends, f, size(ends, f, a))


def hypotenuse(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """The values at both ends of the sizes."""
    x, y = size(ends, f, a), size(ends, f, b)
    return Interval(_both(f, x.low, y.low), _both(f, x.high, y.high))


def largest(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """Bound the larger operand; one known lower end bounds it from below."""
    low = _either(ends.greatest, a.low, b.low)
    return Interval(low, _both(ends.greatest, a.high, b.high))


def smallest(
    ends: Ends[End], f: Callable[..., End], a: Interval[End], b: Interval[End]
) -> Interval[End]:
    """Bound the smaller operand; one known upper end bounds it from above."""
    return Interval(_both(ends.least, a.low, b.low), _either(ends.least, a.high, b.high))


def wave(top: float) -> Rule:
    """A function of period 2 pi, with its maximum at `top` and its minimum half a period later."""

    def rule(ends: Ends[End], f: Callable[..., End], a: Interval[End]) -> Interval[End]:
        low, high = ((x - top) / math.pi for x in numbers_of(ends, a))
        if not high - low < 2:
            return Interval()
        at_ends = _hull(ends, rising(ends, f, a), falling(ends, f, a))
        turns = range(math.ceil(low - _MARGIN), math.floor(high + _MARGIN) + 1)
        return Interval(
            None if any(k % 2 == 1 for k in turns) else at_ends.low,
            None if any(k % 2 == 0 for k in turns) else at_ends.high,
        )

    return rule


def tangent(ends: Ends[End], f: Callable[..., End], a: Interval[End]) -> Interval[End]:
    """Rising between two poles."""
    low, high = (x / math.pi + 0.5 for x in numbers_of(ends, a))
    between = math.isfinite(high - low) and math.floor(low - _MARGIN) == math.floor(high + _MARGIN)
    return rising(ends, f, a) if between else Interval()


_MARGIN = 1e-9  # half turns by which an end may miss a maximum, a minimum or a pole

UNKNOWN = Bounds("unknown", unknown)
RISING = Bounds("rising", rising, takes_function=True)
FALLING = Bounds("falling", falling, takes_function=True)
