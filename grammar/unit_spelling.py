"""Units with parentheses, which the language does not take, and how they are written."""

from __future__ import annotations

import re

_WORD = r"[A-Za-z_][A-Za-z0-9_]*(?:\^-?[0-9]+(?:\.[0-9]+)?)?"
_FACTORS = rf"(?:1|{_WORD})(?:[*/]{_WORD})*"
GROUPED = re.compile(rf"({_FACTORS})/\(({_FACTORS})\)")


def ungrouped(found: re.Match[str]) -> str:
    """Spell a match of `GROUPED` without parentheses: `W/K/s` for `W/(K*s)`."""
    words = re.findall(r"([*/])([^*/]+)", f"*{found[2]}")
    return found[1] + "".join(("*" if sign == "/" else "/") + word for sign, word in words)
