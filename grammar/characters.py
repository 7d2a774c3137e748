"""Explain characters that begin no token of the language."""

from __future__ import annotations

import re

from lark import Token

from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source, Span

_EQUALS = re.compile(r"\s*=(?!=)")
_NUMBER_AND_MORE = re.compile(
    r"(?P<number>(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"(?:(?P<point>\.(?!\.))|(?P<glued>[A-Za-z_][A-Za-z0-9_]*)"
    r"|(?: (?P<unit>[A-Za-z_][A-Za-z0-9_^*/-]*))?(?P<tail>(?:\.| ?[*/])[A-Za-z_][A-Za-z0-9_]*))"
)
_FOREIGN = {
    "&&": "write `and`",
    "||": "write `or`",
    "&": "write `and`",
    "|": "write `or`",
    "!": "write `not`",
    "~": "write `not`",
    "%": "a remainder is `fmod(a, b)`; a comment begins with `//`",
    "#": "a comment begins with `//`",
}
_HELP_FOR = {
    "\u00b7": "a product is written with `*`",
    "\u00d7": "a product is written with `*`",
    "\u2212": "this is a typographic minus; write `-`",
    "\u2013": "this is a dash; write `-`",
    "\u2192": "an arrow is written as `->`",
    "\u00b0": "an angle in degrees is written as `30 deg`",
    "\u03a9": "a resistance is written in `ohm`",
    "\u2126": "a resistance is written in `ohm`",
    "\u00b5": "micro is written as `u`: `10 uF`",
    "\u03bc": "micro is written as `u`: `10 uF`",
    "\u00b2": "a square is written as `^2`",
    "\u00b3": "a cube is written as `^3`",
    "\u201c": 'this is a typographic quote; write `"`',
    "\u201d": 'this is a typographic quote; write `"`',
    "\u00a0": "this is a non-breaking blank; write a plain one",
    "\ufeff": "this is a byte order mark; remove it",
}


def explain_characters(source: Source, at: int, previous: Token | None) -> Diagnostic:
    """Explain the characters at an offset; `previous` is the token before them."""
    text = source.text
    if text.startswith("/*", at):
        return wrong.unclosed_comment(Span(source, at, at + 2))
    if text[at] == '"':
        end = text.find("\n", at)
        return wrong.unclosed_text(Span(source, at, len(text) if end < 0 else end))
    if text[at] == "'":
        name = str(previous) if previous is not None and previous.type == "NAME" else "A"
        derived = _EQUALS.match(text, at + 1) is not None
        return wrong.transposition_mark(Span(source, at, at + 1), name, derived)
    if text[at] in ".0123456789":
        return _number(source, at)
    for sign, help in _FOREIGN.items():
        if text.startswith(sign, at):
            return wrong.foreign_operator(Span(source, at, at + len(sign)), help)
    char = text[at]
    shown = f"`{char}`" if char.isprintable() else f"U+{ord(char):04X}"
    named = f"{shown} (U+{ord(char):04X})" if char.isprintable() and not char.isascii() else shown
    return wrong.unknown_character(Span(source, at, at + 1), named, _HELP_FOR.get(char, ""))


def _number(source: Source, at: int) -> Diagnostic:
    """Explain a misspelt number or unit, with the right spelling."""
    found = _NUMBER_AND_MORE.match(source.text, at)
    if found is None:
        span = Span(source, at, at + 1)
        return wrong.misspelt_number(span, "this is not a number", "a number is `1`, `.5` or `1.5`")
    number, point, glued, unit, tail = found.group("number", "point", "glued", "unit", "tail")
    span = Span(source, at, found.end())
    if point:
        message = "a number has digits after its point"
        if found.end() < len(source.text) and source.text[found.end()] in ".0123456789":
            message = "a number has one point"
        help = f"write `{number}` or `{number}.0`"
    elif glued:
        message = "a unit must follow its number after one blank"
        help = f"write `{number} {glued}` for a unit, `{number}*{glued}` for a product"
    elif unit is None:
        message = "a unit cannot begin with `/`"
        word = (tail or "").strip(" /")
        help = f"write `{number} {word}^-1` for a unit, `{number} / {word}` for a quotient"
    else:
        sign, word = (tail or "*").strip()[0], (tail or "").strip(" */.")
        spelt = "*" if sign == "." else sign
        message = "a unit has no blanks or points inside"
        help = f"write `{number} {unit}{spelt}{word}`"
        if sign != ".":
            help += f" for a unit, `{number} {unit} {sign} {word}` otherwise"
    return wrong.misspelt_number(span, message, help)
