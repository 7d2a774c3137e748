"""Places of an old text in a new one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Move: TypeAlias = Callable[[int], int | None]


def moving(old: str, new: str) -> Move:
    """Return the function from an offset in the old text to that in the new one.

    It returns None for an offset within what was edited: all that stands between the longest
    common beginning of the texts and their longest common end.
    """
    least = min(len(old), len(new))
    head = _common(old, new, least)
    tail = _common(old[::-1], new[::-1], least - head)
    growth = len(new) - len(old)

    def move(offset: int) -> int | None:
        if offset <= head:
            return offset
        return offset + growth if offset >= len(old) - tail else None

    return move


def _common(one: str, other: str, most: int) -> int:
    """Return the length of the common beginning of two texts, found by halving."""
    low, high = 0, most
    while low < high:
        middle = (low + high + 1) // 2
        if one[low:middle] == other[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low
