"""Exact sine, cosine and tangent of the angles for which they are square roots.

With these, the rotation matrix of a mount turned by 90 degrees has exact zeros instead of 6e-17.
An angle is recognised if it was written in degrees or as a fraction of `pi`.
"""

from __future__ import annotations

import math
from fractions import Fraction

PI = Fraction(math.pi)
"""The value of `pi` and of `180 deg`: exactly the double nearest to pi."""

_SINES = {  # angle over pi -> (s, n), for the sine s sqrt(n)
    Fraction(0): (Fraction(0), 1),
    Fraction(1, 6): (Fraction(1, 2), 1),
    Fraction(1, 4): (Fraction(1, 2), 2),
    Fraction(1, 3): (Fraction(1, 2), 3),
    Fraction(1, 2): (Fraction(1), 1),
}


def sine_of(angle: Fraction) -> tuple[Fraction, int] | None:
    """The sine as (s, n), for s sqrt(n); None for an angle that is not in the table."""
    return _sine(angle / PI)


def cosine_of(angle: Fraction) -> tuple[Fraction, int] | None:
    """The cosine as (s, n), for s sqrt(n); None for an angle that is not in the table."""
    return _sine(angle / PI + Fraction(1, 2))


def tangent_of(angle: Fraction) -> tuple[Fraction, int] | None:
    """The tangent as (s, n), for s sqrt(n); None also at its poles."""
    sine, cosine = sine_of(angle), cosine_of(angle)
    if sine is None or cosine is None or cosine[0] == 0:
        return None
    return sine[0] / (cosine[0] * cosine[1]), sine[1] * cosine[1]


def _sine(half_turns: Fraction) -> tuple[Fraction, int] | None:
    """The sine of an angle given in units of pi."""
    half = half_turns % 1
    found = _SINES.get(min(half, 1 - half))
    if found is None:
        return None
    share, square = found
    return (-share if half_turns % 2 >= 1 else share), square
