"""Lay formulas out in `align*` environments of amsmath, long sums over several lines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TypeAlias

Term: TypeAlias = tuple[bool, str]  # whether it is negative, and its text without the sign
LINE = 80  # approximate number of visible characters of a line


def aligned(title: str, equations: Sequence[tuple[str, str]]) -> str:
    """Write equations, left and right side, below a comment with their title."""
    lines = " \\\\\n".join(f"  {left} &= {right}" for left, right in equations)
    return f"% {title}\n\\begin{{align*}}\n{lines}\n\\end{{align*}}\n"


def signed(terms: Iterable[Term]) -> list[str]:
    """The texts of the terms of a sum with their signs."""
    signs = [("-" if negative else "+", text) for negative, text in terms]
    first = [("-" if sign == "-" else "") + text for sign, text in signs[:1]]
    return first + [f"{sign} {text}" for sign, text in signs[1:]]


def broken_sum(terms: Sequence[str]) -> str:
    """Join the terms of a sum, each except the first with its sign, with breaks between lines."""
    lines, width = [""], 0
    for term in terms:
        size = visible_width(term)
        if width and width + size > LINE:
            lines.append("")
            width = 0
        lines[-1] += term if not lines[-1] else f" {term}"
        width += size
    return " \\\\\n      &\\quad ".join(lines)


def visible_width(text: str) -> int:
    """The approximate width of a formula in characters."""
    return len(re.sub(r"\\(?:mathrm|mathit|frac|left|right|,|[a-z]+)|[{}_^\\ ]", "", text))
