"""Explain characters that begin no token of the language."""

from __future__ import annotations

import re
import unicodedata

from lark import Token

from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar.unit_spelling import plain

_EQUALS = re.compile(r"\s*=(?!=)")
_NUMBER_AND_MORE = re.compile(
    r"(?P<number>(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"(?:(?P<point>\.(?!\.))|(?P<glued>[A-Za-z_][A-Za-z0-9_]*)"
    r"|(?: (?P<unit>[A-Za-z_][A-Za-z0-9_^*/-]*))?(?P<tail>(?:\.| ?[*/])[A-Za-z_][A-Za-z0-9_]*))"
)
_GROUPED_DIGITS = re.compile(r"(?P<first>[0-9]{1,3})(?P<rest>(?:[_'][0-9]{3})+)(?![A-Za-z0-9_])")
_METRIC_LETTER = re.compile(r"(?P<number>[0-9.]+)(?P<letter>[kMG])(?P<digits>[0-9]*)(?!\w)")
_EXPONENT = {"k": "3", "M": "6", "G": "9"}
_POINT_AND_EXPONENT = re.compile(r"([0-9]+)\.([eE][+-]?[0-9]+)")
_WITH_UNIT = re.compile(
    r"(?P<number>(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)[ \u00a0]?"
    r"(?P<unit>(?:[A-Za-z*/^]|(?<=\^)-|(?<=[\w^-])[0-9]|[^\x00-\x7f\s])+)"
)
_NAME = re.compile(r"(?:\w|_)+")
_QUOTED = re.compile(r"'[^'\n]*'")
_FOREIGN = {
    "~=": "write `!=`",
    "&&": "write `and`",
    "||": "write `or`",
    "&": "write `and`",
    "|": "write `or`",
    "!": "write `not`",
    "~": "write `not`",
    "%": "a remainder is `fmod(a, b)`; a comment begins with `//`",
}
_HELP_FOR = {
    "#": "a comment begins with `//`",
    "?": "a choice is `if a then b else c`",
    "@": "leave it out",
    "\\": "a quotient is `a / b`; a line ends without a sign",
    "$": "leave it out",
    "\u00b7": "a product is written with `*`",
    "\u22c5": "a product is written with `*`",
    "\u00d7": "a product is written with `*`",
    "\u00f7": "a quotient is written with `/`",
    "\u2212": "this is a typographic minus; write `-`",
    "\u2013": "this is a dash; write `-`",
    "\u2014": "this is a dash; write `-`",
    "\u2264": "at most is written as `<=`",
    "\u2265": "at least is written as `>=`",
    "\u2260": "unequal is written as `!=`",
    "\u221a": "a square root is `sqrt(x)`",
    "\u221e": "leave the limit out, or write a large number such as `1e30`",
    "\u00b2": "a square is written as `^2`",
    "\u00b3": "a cube is written as `^3`",
    "\u201c": 'this is a typographic quote; write `"`',
    "\u201d": 'this is a typographic quote; write `"`',
    "\u201e": 'this is a typographic quote; write `"`',
    "\u00a0": "this is a non-breaking blank; write a plain one",
    "\ufeff": "this is a byte order mark; remove it",
    **dict.fromkeys("\u2192\u21c0\u27f6\u21c1\u21d2", "an arrow is written as `->`"),
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
        quoted = _QUOTED.match(text, at)
        if quoted and (previous is None or previous.type in ("COMMA", "EQUAL", "LPAR")):
            span, help = Span(source, at, quoted.end()), f'write `"{quoted[0][1:-1]}"`'
            return wrong.unknown_character(span, "`'`", f"a text stands in double quotes: {help}")
        if grouped := _grouped_digits(source, at):
            return grouped
        name = str(previous) if previous is not None and previous.type == "NAME" else "A"
        derived = _EQUALS.match(text, at + 1) is not None
        return wrong.transposition_mark(Span(source, at, at + 1), name, derived)
    if text[at] in ".0123456789":
        return _number(source, at)
    for sign, help in _FOREIGN.items():
        if text.startswith(sign, at):
            return wrong.foreign_operator(Span(source, at, at + len(sign)), help)
    char = text[at]
    help = _unit_in_plain_characters(text, at) or _HELP_FOR.get(char, "")
    if not help and (char.isalpha() or char.isdigit()):
        help = _name_in_plain_letters(text, at)
    shown = f"`{char}`" if char.isprintable() else f"U+{ord(char):04X}"
    named = f"{shown} (U+{ord(char):04X})" if char.isprintable() and not char.isascii() else shown
    return wrong.unknown_character(Span(source, at, at + 1), named, help)


def _number(source: Source, at: int) -> Diagnostic:
    """Explain a misspelt number or unit, with the right spelling."""
    if grouped := _grouped_digits(source, at):
        return grouped
    if pointed := _POINT_AND_EXPONENT.match(source.text, at):
        span = Span(source, at, pointed.end())
        help = f"write `{pointed[1]}{pointed[2]}`"
        return wrong.misspelt_number(span, "a number has digits after its point", help)
    if metric := _METRIC_LETTER.match(source.text, at):
        number = metric["number"] + (f".{metric['digits']}" if metric["digits"] else "")
        if number.count(".") < 2:
            span = Span(source, at, metric.end())
            help = (
                f"write `{number}e{_EXPONENT[metric['letter']]}`, or a unit with this prefix after "
                f"one blank: `{number} {metric['letter']}Hz`"
            )
            return wrong.misspelt_number(span, "a prefix stands before a unit only", help)
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


def _grouped_digits(source: Source, at: int) -> Diagnostic | None:
    """Explain digits in groups, `1_000` or `1'000`, at their start or their first mark."""
    start = at
    while start and source.text[start - 1].isdigit():
        start -= 1
    found = _GROUPED_DIGITS.match(source.text, start)
    if found is None:
        return None
    digits = re.sub(r"\D", "", found[0])
    span = Span(source, start, found.end())
    return wrong.misspelt_number(span, "digits are written without groups", f"write `{digits}`")


def _unit_in_plain_characters(text: str, at: int) -> str:
    """Spell the number and unit that hold the character at an offset in plain characters."""
    line = text.rfind("\n", 0, at) + 1
    for found in _WITH_UNIT.finditer(text, line):
        if found.start("unit") <= at < found.end():
            unit = plain(found["unit"])
            if match := re.fullmatch(r"deg([CF])", unit):
                shift = "add 273.15" if match[1] == "C" else "add 459.67, multiply by 5/9"
                return f"a unit with an offset is not supported: {shift} and write `K`"
            if unit.isascii() and unit[0].isalpha():
                return f"write `{found['number']} {unit}`"
    return ""


def _name_in_plain_letters(text: str, at: int) -> str:
    """Spell the name that holds the letter at an offset in plain letters: `theta`."""
    names = _NAME.finditer(text, text.rfind("\n", 0, at) + 1)
    found = next((name for name in names if name.start() <= at < name.end()), None)
    spelt = "".join(map(_plain_letter, found[0])) if found else ""
    return f"write `{spelt}`: names are made of a to z, A to Z, 0 to 9 and `_`" if spelt else ""


def _plain_letter(char: str) -> str:
    """Spell one letter in plain ones; an empty text where there is no usual way."""
    if char.isascii():
        return char
    name = unicodedata.name(char, "")
    if greek := re.match(r"GREEK (SMALL|CAPITAL) LETTER (?:FINAL )?(\w+)", name):
        return greek[2].capitalize() if greek[1] == "CAPITAL" else greek[2].lower()
    if char == "\u00b5":
        return "mu"
    bare = unicodedata.normalize("NFKD", char.replace("\u00df", "ss"))
    return "".join(letter for letter in bare if letter.isascii())
