"""Operations on doubles with the results of C at the edges: overflow, poles, NaN."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

Function: TypeAlias = Callable[[float], float]


def divide(x: float, y: float) -> float:
    """X / y; infinite at y = 0, NaN for 0 / 0."""
    if y != 0:
        return x / y
    return math.nan if x == 0 or math.isnan(x) else math.copysign(math.inf, x) * sign_bit(y)


def sign_bit(x: float) -> float:
    """1 or -1 by the sign bit, also for zeros."""
    return math.copysign(1.0, x)


def power(x: float, y: float) -> float:
    """C's `pow`: infinite on overflow and at zero to a negative power, NaN for (-8)^(1/3)."""
    try:
        return math.pow(x, y)
    except OverflowError:
        return -math.inf if x < 0 and _is_odd(y) else math.inf
    except ValueError:
        if x != 0:
            return math.nan
        return math.copysign(math.inf, x) if _is_odd(y) else math.inf


def _is_odd(y: float) -> bool:
    return y == math.floor(y) and math.fmod(y, 2) != 0


def sign(x: float) -> float:
    """-1, 0 or 1; NaN for NaN."""
    return x if math.isnan(x) else float((x > 0) - (x < 0))


def smaller(x: float, y: float) -> float:
    """The minimum as `model_min` computes it."""
    return x if x < y or x != x else y


def larger(x: float, y: float) -> float:
    """The maximum as `model_max` computes it."""
    return x if x > y or x != x else y


def with_limits(function: Function, overflow: Function, *poles: float) -> Function:
    """A function of `math` without exceptions: `overflow(x)` on overflow and at its poles."""

    def of(x: float) -> float:
        try:
            return function(x)
        except OverflowError:
            return overflow(x)
        except ValueError:
            return overflow(x) if x in poles else math.nan

    return of


def upwards(x: float) -> float:
    """Positive infinity."""
    return math.inf


def downwards(x: float) -> float:
    """Negative infinity."""
    return -math.inf


def outwards(x: float) -> float:
    """Infinity with the sign of x."""
    return math.copysign(math.inf, x)


def choose(condition: float, yes: float, no: float) -> float:
    """`yes` if the condition is not zero, else `no`; an undefined condition itself."""
    if condition == 0:
        return no
    return yes if condition == condition else condition


def truth(holds: bool, *operands: float) -> float:
    """1 or 0; NaN where an operand is."""
    return math.nan if any(map(math.isnan, operands)) else float(holds)


def equal(x: float, y: float) -> float:
    """1 or 0. `x == x` asks whether x is a number (`switches`), so 0 where both are NaN."""
    return 0.0 if x != x and y != y else truth(x == y, x, y)


def both(x: float, y: float) -> float:
    """Conjunction: 0 if a side is 0, whatever the other is."""
    return 0.0 if x == 0 or y == 0 else truth(True, x, y)


def either(x: float, y: float) -> float:
    """Disjunction: 1 if a side holds, whatever the other is."""
    return 1.0 if x < 0 or x > 0 or y < 0 or y > 0 else x + y


def rounding(function: Callable[[float], int]) -> Function:
    """`math.floor` or `math.ceil` as a double; infinities and NaN stay."""
    return lambda x: float(function(x)) if math.isfinite(x) else x


def remainder(x: float, y: float) -> float:
    """C's `fmod`: the sign is that of x."""
    return math.nan if y == 0 or math.isinf(x) else math.fmod(x, y)
