"""Random numbers that are functions of a seed and an index: `runtime/c/bgc_random.h` in Python.

SplitMix64 as a counter-based generator (G. L. Steele, D. Lea, C. H. Flood, Fast splittable
pseudorandom number generators, OOPSLA 2014, with variant 13 of the mixers of D. Stafford).
"""

from __future__ import annotations

import math

_MASK = 2**64 - 1
_STEP = 0x9E3779B97F4A7C15
_EXACT_INTEGERS = 2**53  # whole numbers below it are exact doubles


def random(seed: float, index: float) -> float:
    """A number in [0, 1) with 53 random bits; NaN unless both are whole and below 2^53."""
    if not all(abs(x) < _EXACT_INTEGERS and x == math.trunc(x) for x in (seed, index)):
        return math.nan
    start = _mixed(_mixed(int(seed) + _STEP) + _STEP)
    return (_mixed(start + _STEP * (int(index) + 1)) >> 11) * 2.0**-53


def _mixed(z: int) -> int:
    z &= _MASK
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & _MASK
    z = (z ^ z >> 27) * 0x94D049BB133111EB & _MASK
    return z ^ z >> 31
