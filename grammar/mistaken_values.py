"""Explain a syntax error in a value: a number, unit or operator of another form."""

from __future__ import annotations

import re

from lark import Token

from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.grammar.error_context import (
    OPERAND_ENDS,
    WORD,
    ErrorContext,
    Explanation,
    place_of,
    types_of_statement,
)
from bgc.grammar.language_words import SCENE_WORDS
from bgc.grammar.peers import keyword_advice
from bgc.grammar.scene_statements import SCENE_STATEMENTS

_POWER = r"(?:\^(-?[0-9]+(?:\.[0-9]+)?))?"
_RECIPROCAL = re.compile(
    rf"1/([A-Za-z_][A-Za-z0-9_]*){_POWER}((?:[*/][A-Za-z_][A-Za-z0-9_]*{_POWER})*)(?![\w.(*/^])"
)
_GROUPS = re.compile(r"[1-9][0-9]{0,2}(?:,[0-9]{3})+(?![0-9])")  # of thousands
_UNIT_WORDS = re.compile(r"[A-Za-z_]\w*(?:\^-?[0-9.]+)?(?:[*/][A-Za-z_]\w*(?:\^-?[0-9.]+)?)*")
_DECIMALS = re.compile(r"\d+")
_CHOOSE = frozenset(row.word.upper() for row in SCENE_STATEMENTS.values() if row.chooses)
_OPERAND_STARTS = frozenset("NAME NUMBER TIME DER TEXT LPAR".split())


def decimal_comma(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a decimal comma: `1,5`."""
    previous = context.previous
    if found.type != "COMMA" or previous is None or previous.type != "NUMBER":
        return None
    decimals = _DECIMALS.match(context.source.text, context.offset + 1)
    if decimals is None or not previous.isdigit():
        return None
    start = place_of(context, previous).start
    groups = _GROUPS.match(context.source.text, start)
    end = groups.end() if groups else decimals.end()
    whole, decimal = re.sub(r"\D", "", (groups or decimals)[0]), f"`{previous}.{decimals[0]}`"
    help = f"write {decimal}" if groups is None else f"write `{whole}`"
    if groups and len(decimals[0]) == end - context.offset - 1:  # one comma may be either
        help += f", or {decimal} for a decimal comma"
    span = Span(context.source, start, end)
    return Explanation(
        wrong.misspelt_number(span, "a number has a decimal point, not a comma", help)
    )


def colon_slice(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a slice of MATLAB or Python: `x[1:2]`, `A[1, :]`."""
    previous = context.previous
    if found.type != "COLON" or previous is None or not context.open:
        return None
    if context.open[-1].type != "LSQB" or previous.type not in ("LSQB", "COMMA", *OPERAND_ENDS):
        return None
    bounded = previous.type in OPERAND_ENDS
    help = "write a slice as `x[1..3]`" if bounded else "write all indices as a range: `A[2, 1..3]`"
    return Explanation(wrong.foreign_operator(context.span(), help))


def two_operands(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain two values in a row: an operator is missing, or a unit is misspelt."""
    previous = context.previous
    if previous is None or "TIMES" not in context.accepted:
        return None
    if previous.type not in OPERAND_ENDS or found.type not in _OPERAND_STARTS:
        return None
    if context.at_start_of_line() or _CHOOSE.intersection(types_of_statement(context)):
        return None
    word = previous.rpartition(" ")[2] if " " in previous else ""
    if advice := keyword_advice(word) if previous.type == "NUMBER" else "":
        span = place_of(context, previous)
        return Explanation(wrong.unknown_statement(span, word, advice, "", ()))
    if previous.type == "NUMBER" and "if" in (word, str(found)):
        choice = "a choice is `if a then b else c`"
        return Explanation(
            wrong.missing_operator(context.span(), str(previous), "`if`", "", choice)
        )
    if context.open and context.open[-1].type == "LSQB":
        separate = f"separate components by commas: `[{previous}, {found}]`"
        before, after = context.describe_previous(), context.describe_found()
        return Explanation(wrong.missing_operator(context.span(), before, after, "", separate))
    if previous.type == "NUMBER" and " " in previous and found in SCENE_WORDS:
        return None  # the next statement, or a clause: `run 10 s step 1 ms;`
    if previous.type == "NUMBER" and WORD.fullmatch(found):
        span = place_of(context, previous).to(context.span())
        if " " in previous:
            unit = _UNIT_WORDS.match(context.source.text, context.offset)
            rest = unit[0] if unit else found
            message, right = "a unit has no blanks inside", f"`{previous}*{rest}`"
        else:
            message, right = (
                "a unit must follow its number after one blank",
                f"`{previous} {found}`",
            )
        help = f"write {right}; a product is `{previous} * {found}`"
        return Explanation(wrong.misspelt_number(span, message, help))
    before, after = context.describe_previous(), context.describe_found()
    reciprocal = reciprocal_unit(context.source.text[context.offset :])
    spelt = f"{previous} {reciprocal}" if previous.type == "NUMBER" and reciprocal else ""
    return Explanation(wrong.missing_operator(context.span(), before, after, spelt))


def reciprocal_unit(text: str) -> str:
    """The unit of a number, `m^-1*s`, where a text begins with `1/m*s`; else an empty text."""
    found = _RECIPROCAL.match(text)
    if found is None:
        return ""
    name, power, rest = found[1], found[2] or "1", found[3]
    inverse = power[1:] if power.startswith("-") else f"-{power}"
    return f"{name}{'' if inverse == '1' else f'^{inverse}'}{rest}"


def power_of_unit(span: Span, unit: str, power: str) -> Diagnostic:
    """Answer a power glued to a unit: `10 s-1` would be 10 s less 1."""
    number, _, word = unit.partition(" ")
    if word in ("e", "E"):
        message = "an exponent follows the digits of its number without a blank"
        return wrong.misspelt_number(span, message, f"write `{number}e-{power}`")
    spelt = f"{unit}^-{power}"
    return wrong.misspelt_number(
        span,
        "a power of a unit is written with `^`",
        f"write `{spelt}` for a unit, `{unit} - {power}` for a difference",
    )
