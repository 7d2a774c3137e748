"""Explain a syntax error in the user's terms.

From the token that was found, the tokens that the parser would accept and the brackets that are
open, the most specific message is chosen. Where a single sign is evidently missing, it is
proposed to the parser, so that it can read on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from lark import Token

from bgc.diagnostics.catalogue import did_you_mean
from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.catalogue.jumps import incomplete_head
from bgc.diagnostics.catalogue.values import unit_with_parentheses
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar.characters import explain_characters
from bgc.grammar.peers import statement_advice
from bgc.grammar.tokens import END, end_of, span_of
from bgc.grammar.unit_spelling import GROUPED, ungrouped
from bgc.grammar.words import BLOCK_OF, FORMS, FORMS_IN, PLACES, RESERVED, TABLE, WORDS

_CLOSER = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
_SIGN = {
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "LBRACE": "{",
    "RBRACE": "}",
    "SEMICOLON": ";",
    "COLON": ":",
    "COMMA": ",",
    "DOT": ".",
    "DOTS": "..",
    "ARROW": "->",
    "EQUAL": "=",
}
_POWER = r"(?:\^(-?[0-9]+(?:\.[0-9]+)?))?"
_RECIPROCAL = re.compile(
    rf"1/([A-Za-z_][A-Za-z0-9_]*){_POWER}((?:[*/][A-Za-z_][A-Za-z0-9_]*{_POWER})*)(?![\w.(*/^])"
)
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_USED_AS_NAME = re.compile(r"\s*(?::|->|,)")
_PART_OR_CHAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*(?:\[[^\]\n]*\])?[ \t]*(?::|->)")
_LONGEST_STATEMENT = 200  # characters that a statement of another tool is recognised by
_DECIMALS = re.compile(r"\d+")
_POSTFIX = ("LPAR", "LSQB", "DOT", "EQUAL")
_HEADS = {"sample": "period", "when": "condition"}
_RESET = re.compile(r"(?:reset\b|[A-Za-z_][A-Za-z0-9_.]*(?:\[[^\]\n]*\])?\s*=(?!=))")
_WORD_KINDS = frozenset(word.upper() for word in TABLE)
_OPERAND_ENDS = frozenset("NAME NUMBER TIME TEXT RPAR RSQB".split())
_OPERAND_STARTS = frozenset("NAME NUMBER TIME DER TEXT LPAR".split())


@dataclass(frozen=True, slots=True)
class ErrorContext:
    """The place of a syntax error, and the state of the parser there.

    Attributes
    ----------
    found
        The token at `offset`; None where no token begins there. At the end of the text its type
        is `$END`.
    read
        The tokens before it.
    open
        The brackets and braces among these that are not closed yet.
    accepted
        The types of the tokens that the parser would accept.
    outermost
        The kind of text: "file" or "setting".
    """

    source: Source
    offset: int
    found: Token | None
    read: list[Token]
    open: list[Token]
    accepted: frozenset[str]
    outermost: str

    @property
    def previous(self) -> Token | None:
        """The token before the error."""
        return self.read[-1] if self.read else None

    def span(self) -> Span:
        """Return the place of the token that was found."""
        length = 1 if self.found is None else len(self.found)
        return Span(self.source, self.offset, self.offset + length)

    def describe_found(self) -> str:
        """Name the token that was found, for a message."""
        if self.found is None:
            return "something else"
        return "the end of the file" if self.found.type == END else _quoted(self.found)

    def describe_previous(self) -> str:
        """Name the token before it, for a message."""
        return _quoted(self.previous) if self.previous else ""

    def at_start_of_line(self) -> bool:
        """Return whether only blanks precede it on its line."""
        text = self.source.text
        return not text[text.rfind("\n", 0, self.offset) + 1 : self.offset].strip()


@dataclass(frozen=True, slots=True)
class Explanation:
    """A diagnostic, and the type of the missing sign if that is all that is wrong."""

    diagnostic: Diagnostic
    missing: str | None = None


def explain(context: ErrorContext) -> Explanation:
    """Choose the most specific message for a syntax error."""
    if context.found is None or _is_misread(context, context.found):
        return Explanation(explain_characters(context.source, context.offset, context.previous))
    for explain_one_kind in _KINDS_OF_ERROR:
        explanation = explain_one_kind(context, context.found)
        if explanation is not None:
            return explanation
    return Explanation(
        wrong.unexpected(
            context.span(),
            context.describe_found(),
            list(_expected(context.accepted)),
            "" if _begins_statement(context.read) else context.describe_previous(),
            _form(context),
        )
    )


def _is_misread(context: ErrorContext, found: Token) -> bool:
    """Return whether the token is the start of a misspelt number or of an unclosed comment."""
    starts_comment = context.source.text.startswith("/*", context.offset)
    return starts_comment or (found[:1] in set("0123456789") and found.type != "NUMBER")


# --- each kind of error, one function: None where the error is of another kind ------------


def _end_of_block(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a block that is still open where the file ends or a declaration begins a line."""
    if not context.open or "RBRACE" not in context.accepted:
        return None
    begins = str(found) in WORDS["file"] and str(found) not in WORDS["model"]
    if found.type == END or (begins and context.source.position(context.offset)[1] == 1):
        opened = _span_of(context, context.open[-1])
        place = context.describe_found()
        return Explanation(wrong.unclosed_block(context.span(), opened, place), "RBRACE")
    return None


def _head_of_block(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a `when` without its condition or `{`, and a `sample` without its period or `{`."""
    previous = context.previous
    if previous is None or _block(context) != "model":
        return None
    if found.type == "LBRACE":
        word = str(previous)
        if word in _HEADS and _begins_statement(context.read[:-1]):
            span = _span_of(context, previous)
            return Explanation(incomplete_head(span, word, _HEADS[word], FORMS[word]))
        return None
    if "LBRACE" not in context.accepted or previous.type not in _OPERAND_ENDS:
        return None
    *_, first = _types_of_statement(context)
    word = first.lower()
    ends = found.type in ("RBRACE", "SEMICOLON", END)
    if word in _HEADS and (ends or _begins_contents(context, found)):
        behind = end_of(previous)
        end = Span(context.source, behind, behind)
        return Explanation(incomplete_head(end, word, "`{`", FORMS[word]))
    return None


def _begins_contents(context: ErrorContext, found: Token) -> bool:
    """Return whether a statement of a `when` or `sample` begins here."""
    begins = str(found) in WORDS["model"] or _RESET.match(context.source.text, context.offset)
    return _WORD.fullmatch(found) is not None and bool(begins)


def _statement_unfinished(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a missing `;` before the next statement or the end of the block."""
    if "SEMICOLON" not in context.accepted or context.previous is None:
        return None
    is_word = _WORD.fullmatch(found) is not None
    begins = found.type != "NAME" and str(found) in WORDS[_block(context)]
    if found.type in ("RBRACE", END) or begins or (is_word and context.at_start_of_line()):
        behind = end_of(context.previous)
        end = Span(context.source, behind, behind)
        return Explanation(wrong.missing_semicolon(end, context.describe_previous()), "SEMICOLON")
    return None


def _bracket(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a bracket that is closed but not open, or open where its statement ends."""
    innermost = context.open[-1].type if context.open else ""
    if found.type in _CLOSER.values() and _CLOSER.get(innermost) != found.type:
        opener = next(kind for kind, closer in _CLOSER.items() if closer == found.type)
        if innermost in ("", "LBRACE") and all(token.type != opener for token in context.open):
            return Explanation(wrong.unmatched_closer(context.span()))
    elif found.type not in ("SEMICOLON", "LBRACE", END) and not _begins_line(context, found):
        return None
    closer = _CLOSER.get(innermost)
    if closer is None or innermost == "LBRACE":
        return None
    if closer not in context.accepted and found.type not in _CLOSER.values():
        return None
    opened = _span_of(context, context.open[-1])
    place = context.describe_found()
    unclosed = wrong.unclosed_bracket(context.span(), opened, _SIGN[closer], place)
    return Explanation(unclosed, closer if closer in context.accepted else None)


def _operator(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a second comparison in a row, `=` for `==`, `==` for `=`, and `**`."""
    previous = context.previous
    if previous is None:
        return None
    if previous.type == found.type in ("EQUAL", "TIMES") and end_of(previous) == context.offset:
        doubled = Span(context.source, context.offset - 1, context.offset + 1)
        help = "give a value with `=`" if found.type == "EQUAL" else "write a power with `^`"
        return Explanation(wrong.foreign_operator(doubled, help))
    if previous.type not in _OPERAND_ENDS:
        return None
    before = set(_types_of_statement(context))
    if found.type == "COMPARE" and "COMPARE" in before:
        return Explanation(wrong.chained_comparison(context.span()))
    if found.type == "EQUAL" and before & {"IF", "ASSERT", "AND", "OR", "NOT"}:
        return Explanation(wrong.equals_in_condition(context.span()))
    return None


def _derivative(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a `der` without `(` behind it."""
    previous = context.previous
    if previous is None or previous.type != "DER" or "LPAR" not in context.accepted:
        return None
    return Explanation(wrong.derivative_of_nothing(_span_of(context, previous)))


def _unit_with_parentheses(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain the parentheses of a unit that stands behind a colon or `in`: `: J/(kg*K)`."""
    previous = context.previous
    if found.type != "OVER" or previous is None or "OVER" in context.accepted:
        return None
    start = _span_of(context, previous).start
    unit = GROUPED.match(context.source.text, start)
    if unit is None:
        return None
    span = Span(context.source, start, unit.end())
    return Explanation(unit_with_parentheses(span, ungrouped(unit)))


def _empty_statement(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a `;` with no statement before it."""
    if found.type != "SEMICOLON" or not _begins_statement(context.read):
        return None
    return Explanation(wrong.empty_statement(context.span()))


def _reserved(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a reserved word in place of a name."""
    previous = context.previous
    if found.type == "COLON" and previous is not None and str(previous) in RESERVED:
        return Explanation(wrong.reserved_word(_span_of(context, previous), str(previous)))
    if "NAME" not in context.accepted or str(found) not in RESERVED:
        return None
    if context.at_start_of_line() and not _begins_statement(context.read):
        return None
    return Explanation(wrong.reserved_word(context.span(), str(found)))


def _first_word(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a statement whose first word is unknown or belongs to another kind of block."""
    if _begins_statement(context.read):
        word, span = str(found), context.span()
        if _USED_AS_NAME.match(context.source.text, span.end):
            return None
    elif _begins_statement(context.read[:-1]) and context.read[-1].type == "NAME":
        word, span = str(context.read[-1]), _span_of(context, context.read[-1])
    else:
        return None
    here = _block(context)
    for block, place in PLACES.items():
        if word in WORDS[block] and word not in WORDS[here]:
            return Explanation(wrong.misplaced_statement(span, word, place))
    if word in RESERVED or not _WORD.fullmatch(word):
        return None
    known = WORDS[here]
    near = did_you_mean(word, known)
    if not near and span == context.span():
        known = [each for words in WORDS.values() for each in words]
        near = did_you_mean(word, known)
    if near or (span == context.span() and "NAME" not in context.accepted):
        return Explanation(wrong.unknown_statement(span, word, near, _form(context), known))
    return None


def _decimal_comma(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a decimal comma: `1,5`."""
    previous = context.previous
    if found.type != "COMMA" or previous is None or previous.type != "NUMBER":
        return None
    decimals = _DECIMALS.match(context.source.text, context.offset + 1)
    if decimals is None or not previous.isdigit():
        return None
    start = _span_of(context, previous)
    span = Span(context.source, start.start, decimals.end())
    help = f"write `{previous}.{decimals[0]}`"
    return Explanation(
        wrong.misspelt_number(span, "a number has a decimal point, not a comma", help)
    )


def _two_operands(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain two values in a row: an operator is missing, or a unit is misspelt."""
    previous = context.previous
    if previous is None or "TIMES" not in context.accepted:
        return None
    if previous.type not in _OPERAND_ENDS or found.type not in _OPERAND_STARTS:
        return None
    if context.at_start_of_line():
        return None
    if previous.type == "NUMBER" and _WORD.fullmatch(found):
        span = _span_of(context, previous).to(context.span())
        if " " in previous:
            message, right = "a unit has no blanks inside", f"`{previous}*{found}`"
        else:
            message, right = (
                "a unit must follow its number after one blank",
                f"`{previous} {found}`",
            )
        help = f"write {right}; a product is `{previous} * {found}`"
        return Explanation(wrong.misspelt_number(span, message, help))
    before, after = context.describe_previous(), context.describe_found()
    reciprocal = reciprocal_unit(context.source.text[context.offset :])
    unit = f"{previous} {reciprocal}" if previous.type == "NUMBER" and reciprocal else ""
    return Explanation(wrong.missing_operator(context.span(), before, after, unit))


def reciprocal_unit(text: str) -> str:
    """The unit of a number, `m^-1*s`, where a text begins with `1/m*s`; else an empty text."""
    found = _RECIPROCAL.match(text)
    if found is None:
        return ""
    name, power, rest = found[1], found[2] or "1", found[3]
    inverse = power[1:] if power.startswith("-") else f"-{power}"
    return f"{name}{'' if inverse == '1' else f'^{inverse}'}{rest}"


_KINDS_OF_ERROR: tuple[Callable[[ErrorContext, Token], Explanation | None], ...] = (
    _head_of_block,
    _end_of_block,
    _first_word,
    _statement_unfinished,
    _bracket,
    _operator,
    _derivative,
    _unit_with_parentheses,
    _empty_statement,
    _reserved,
    _decimal_comma,
    _two_operands,
)


def _begins_statement(read: Sequence[Token]) -> bool:
    """Return whether a statement begins behind these tokens."""
    return not read or read[-1].type in ("SEMICOLON", "LBRACE", "RBRACE")


def _form(context: ErrorContext) -> str:
    """Return the form of the statement with the error, or of the statements of its block."""
    block = _block(context)
    if _begins_statement(context.read):
        return _peer_form(context, context.offset) or FORMS_IN[block]
    at = len(context.read) - 1
    while not _begins_statement(context.read[at - 1 : at]):
        at -= 1
    first = context.read[at].type.lower()
    if first in FORMS and first != "model":  # other tools have models without braces
        return FORMS[first]
    advice = _peer_form(context, _span_of(context, context.read[at]).start)
    return advice or FORMS.get(first, FORMS_IN[block])


def _peer_form(context: ErrorContext, begin: int) -> str:
    """Return the way to write a statement that begins at an offset in another tool's words."""
    return statement_advice(context.source.text[begin : begin + _LONGEST_STATEMENT])


def _begins_line(context: ErrorContext, found: Token) -> bool:
    """Return whether a line begins here that reads like a statement."""
    begins = str(found) in RESERVED or _PART_OR_CHAIN.match(context.source.text, context.offset)
    return bool(begins) and context.at_start_of_line()


def _types_of_statement(context: ErrorContext) -> Iterator[str]:
    """Return the types of the statement's tokens before the error, from the last to the first."""
    for at in range(len(context.read) - 1, -1, -1):
        if context.read[at].type in ("SEMICOLON", "LBRACE", "RBRACE"):
            return
        yield context.read[at].type


def _block(context: ErrorContext) -> str:
    return block_kind(context.read, context.open, context.outermost)


def block_kind(read: Sequence[Token], opened: Sequence[Token], outermost: str) -> str:
    """Return the kind of the innermost open block, by the first word of the statement before `{`.

    `read` are all tokens so far, `opened` those of them that open what is not closed yet.
    """
    braces = [token for token in opened if token.type == "LBRACE"]
    if not braces:
        return outermost
    at = next(at for at in range(len(read) - 1, -1, -1) if read[at] is braces[-1])
    while not _begins_statement(read[:at][-1:]):
        at -= 1
    return BLOCK_OF.get(read[at].type, "law")


def _expected(accepted: frozenset[str]) -> Iterator[str]:
    """Name what the parser would accept, for a message."""
    if "PARAM" in accepted or "RUN" in accepted:
        yield "a statement"
    elif "MODEL" in accepted:
        yield "a declaration"
        return
    elif "NUMBER" in accepted:
        yield "an expression"
    elif "NAME" in accepted:
        yield "a name"
    if "UNIT" in accepted:
        yield "a unit"
    if "TEXT" in accepted and "NUMBER" not in accepted:
        yield "a text in quotes"
    if "PARAM" not in accepted and "RUN" not in accepted and "NUMBER" not in accepted:
        for kind in sorted(accepted):
            if kind in _WORD_KINDS:
                yield f"`{kind.lower()}`"
    continues = "TIMES" in accepted or "NUMBER" in accepted
    signs = [kind for kind in _SIGN if kind in accepted and not (continues and kind in _POSTFIX)]
    yield from (f"`{_SIGN[kind]}`" for kind in signs)
    if "TIMES" in accepted and not signs:
        yield "an operator"
    if END in accepted:
        yield "the end of the file"


def _span_of(context: ErrorContext, token: Token) -> Span:
    return span_of(context.source, token)


def _quoted(text: str) -> str:
    """Quote a piece of text as messages do, at most 40 characters of it."""
    return f"`{text}`" if len(text) <= 40 else f"`{text[:37]}...`"
