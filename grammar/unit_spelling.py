"""Units with parentheses or characters that the language does not take, and how to write them."""

from __future__ import annotations

import re

_PLAIN = str.maketrans(
    {
        "\u00b5": "u",  # micro sign, and the Greek letter
        "\u03bc": "u",
        "\u03a9": "ohm",  # Greek letter, and the sign of the unit
        "\u2126": "ohm",
        "\u00b0": "deg",
        "\u00b7": "*",  # points and crosses of a product
        "\u22c5": "*",
        "\u00d7": "*",
        "\u2212": "-",
    }
)
_RAISED = {ord(sign): plain for sign, plain in zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True)}
_POWER = re.compile(f"[{''.join(map(chr, _RAISED))}]+")

_WORD = r"[A-Za-z_][A-Za-z0-9_]*(?:\^-?[0-9]+(?:\.[0-9]+)?)?"
_FACTORS = rf"(?:1|{_WORD})(?:[*/]{_WORD})*"
GROUPED = re.compile(rf"({_FACTORS})/\(({_FACTORS})\)")


def ungrouped(found: re.Match[str]) -> str:
    """Spell a match of `GROUPED` without parentheses: `W/K/s` for `W/(K*s)`."""
    words = re.findall(r"([*/])([^*/]+)", f"*{found[2]}")
    return found[1] + "".join(("*" if sign == "/" else "/") + word for sign, word in words)


def plain(text: str) -> str:
    """Spell a unit in plain characters: `um` for a micrometre, `m^2` for a raised two."""
    raised = _POWER.sub(lambda found: f"^{found[0].translate(_RAISED)}", text)
    return raised.translate(_PLAIN)
