"""Sine, cosine and tangent of the angles whose values are roots: exact, not 6e-17 for 0.

A mount turned by 90 degrees so has zeros in its matrix, and not numbers that are zero but for
the rounding of pi. An angle counts as 90 degrees when it is written as such, or as `pi/2`.
"""

from __future__ import annotations

import math
from fractions import Fraction

_PI = Fraction(math.pi)  # what `pi` and `180 deg` stand for
_SINES = {  # of a share of pi: share times the root of a number
    Fraction(0): (Fraction(0), 1),
    Fraction(1, 6): (Fraction(1, 2), 1),
    Fraction(1, 4): (Fraction(1, 2), 2),
    Fraction(1, 3): (Fraction(1, 2), 3),
    Fraction(1, 2): (Fraction(1), 1),
}


def sine_of(angle: Fraction) -> tuple[Fraction, int] | None:
    """The sine as (share, square): share times the root of square; None where it is no root."""
    return _sine(angle / _PI)


def cosine_of(angle: Fraction) -> tuple[Fraction, int] | None:
    """The cosine in the same way."""
    return _sine(angle / _PI + Fraction(1, 2))


def tangent_of(angle: Fraction) -> tuple[Fraction, int] | None:
    """The tangent in the same way; None also at its poles."""
    sine, cosine = sine_of(angle), cosine_of(angle)
    if sine is None or cosine is None or cosine[0] == 0:
        return None
    return sine[0] / (cosine[0] * cosine[1]), sine[1] * cosine[1]


def _sine(turns: Fraction) -> tuple[Fraction, int] | None:
    """The sine of a share of pi."""
    half = turns % 1
    found = _SINES.get(min(half, 1 - half))
    if found is None:
        return None
    share, square = found
    return (-share if turns % 2 >= 1 else share), square
