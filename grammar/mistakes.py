"""Explain a syntax error in the user's terms.

From the token that was found, the tokens that the parser would accept and the brackets that are
open, the most specific message is chosen. Where a single sign is evidently missing, it is
proposed to the parser, so that it can read on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from lark import Token

from bgc.diagnostics.catalogue import did_you_mean
from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.catalogue.jumps import incomplete_head
from bgc.diagnostics.catalogue.values import unit_with_parentheses
from bgc.diagnostics.source import Span
from bgc.grammar.characters import explain_characters
from bgc.grammar.error_context import (
    OPERAND_ENDS,
    WORD,
    ErrorContext,
    Explanation,
    begins_statement,
    place_of,
    types_of_statement,
)
from bgc.grammar.language_words import BLOCK_OF, FORMS, FORMS_IN, PLACES, RESERVED, TABLE, WORDS
from bgc.grammar.mistaken_values import colon_slice, decimal_comma, two_operands
from bgc.grammar.peers import keyword_advice, statement_advice
from bgc.grammar.tokens import END, end_of
from bgc.grammar.unit_spelling import GROUPED, ungrouped

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
_USED_AS_NAME = re.compile(r"\s*(?::|->|,)")
_PART_OR_CHAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*(?:\[[^\]\n]*\])?[ \t]*(?::|->)")
_LONGEST_STATEMENT = 200  # characters that a statement of another tool is recognised by
_POSTFIX = ("LPAR", "LSQB", "DOT", "EQUAL")
_FOREIGN_PAIRS = {  # operators of other languages, of two tokens each
    "**": "write a power with `^`",
    "==": "give a value with `=`",
    ":=": "give a value with `=`",
    "<>": "write `!=`",
    "=>": "at least is written as `>=`",
    "+=": "write the new value with `=`",
    "++": "write `+ 1`",
    ".*": "write `*`; a product of each component is a `for`",
    "./": "write `/`",
    ".^": "write `^`",
}
_ROWS = re.compile(r"\[[^\[\]{};\n]*;[^\[\]{}\n]*\]")
_ROWS_HELP = "each row stands in brackets of its own: `[[1, 2], [3, 4]]`"
_HEADS = {"sample": "period", "when": "condition"}
_RESET = re.compile(r"(?:reset\b|[A-Za-z_][A-Za-z0-9_.]*(?:\[[^\]\n]*\])?\s*=(?!=))")
_WORD_KINDS = frozenset(word.upper() for word in TABLE)


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
            "" if begins_statement(context.read) else context.describe_previous(),
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
        opened = place_of(context, context.open[-1])
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
        if word in _HEADS and begins_statement(context.read[:-1]):
            span = place_of(context, previous)
            return Explanation(incomplete_head(span, word, _HEADS[word], FORMS[word]))
        return None
    if "LBRACE" not in context.accepted or previous.type not in OPERAND_ENDS:
        return None
    *_, first = types_of_statement(context)
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
    return WORD.fullmatch(found) is not None and bool(begins)


def _statement_unfinished(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a missing `;` before the next statement or the end of the block."""
    if "SEMICOLON" not in context.accepted or context.previous is None:
        return None
    is_word = WORD.fullmatch(found) is not None
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
    opened = place_of(context, context.open[-1])
    place = context.describe_found()
    rows = _ROWS.match(context.source.text, opened.start) if closer == "RSQB" else None
    unclosed = wrong.unclosed_bracket(
        context.span(), opened, _SIGN[closer], place, _ROWS_HELP if rows else ""
    )
    if rows:
        return Explanation(unclosed)
    return Explanation(unclosed, closer if closer in context.accepted else None)


def _operator(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a second comparison in a row, `=` for `==`, `==` for `=`, and `**`."""
    previous = context.previous
    if previous is None:
        return None
    behind = end_of(previous) == context.offset
    pair = context.source.text[context.offset - 1 : context.offset + 1] if behind else ""
    help = _FOREIGN_PAIRS.get(pair)
    if help and "IMPORT" not in types_of_statement(context):
        doubled = Span(context.source, context.offset - 1, context.offset + 1)
        return Explanation(wrong.foreign_operator(doubled, _peer_form_of(context) or help))
    if previous.type not in OPERAND_ENDS:
        return None
    before = set(types_of_statement(context))
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
    return Explanation(wrong.derivative_of_nothing(place_of(context, previous)))


def _unit_with_parentheses(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain the parentheses of a unit that stands behind a colon or `in`: `: J/(kg*K)`."""
    previous = context.previous
    if found.type != "OVER" or previous is None or "OVER" in context.accepted:
        return None
    start = place_of(context, previous).start
    unit = GROUPED.match(context.source.text, start)
    if unit is None:
        return None
    span = Span(context.source, start, unit.end())
    return Explanation(unit_with_parentheses(span, ungrouped(unit)))


def _empty_statement(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a `;` with no statement before it."""
    if found.type != "SEMICOLON" or not begins_statement(context.read):
        return None
    return Explanation(wrong.empty_statement(context.span()))


def _reserved(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a reserved word in place of a name."""
    previous = context.previous
    if found.type == "COLON" and previous is not None and str(previous) in RESERVED:
        return Explanation(wrong.reserved_word(place_of(context, previous), str(previous)))
    if "NAME" not in context.accepted or str(found) not in RESERVED:
        return None
    of_derivative = [token.type for token in context.read[-2:]] == ["DER", "LPAR"]
    if "NUMBER" in context.accepted or of_derivative:  # no name is chosen here
        return None
    if context.at_start_of_line() and not begins_statement(context.read):
        return None
    return Explanation(wrong.reserved_word(context.span(), str(found)))


def _first_word(context: ErrorContext, found: Token) -> Explanation | None:
    """Explain a statement whose first word is unknown or belongs to another kind of block."""
    if begins_statement(context.read):
        word, span = str(found), context.span()
        if _USED_AS_NAME.match(context.source.text, span.end):
            return None
    elif begins_statement(context.read[:-1]) and context.read[-1].type == "NAME":
        word, span = str(context.read[-1]), place_of(context, context.read[-1])
    else:
        return None
    here = _block(context)
    for block, place in PLACES.items():
        if word in WORDS[block] and word not in WORDS[here]:
            return Explanation(wrong.misplaced_statement(span, word, place))
    if word in RESERVED or not WORD.fullmatch(word):
        return None
    if advice := keyword_advice(_statement_at(context, span.start), here):
        return Explanation(wrong.unknown_statement(span, word, advice, "", ()))
    if word in WORDS[here] and word in FORMS:  # a statement, but not in its form
        return Explanation(wrong.unknown_statement(span, word, "", FORMS[word], ()))
    known = WORDS[here]
    near = did_you_mean(word, known)
    if not near and span == context.span():
        known = [each for words in WORDS.values() for each in words]
        near = did_you_mean(word, known)
    if near or (span == context.span() and "NAME" not in context.accepted):
        return Explanation(wrong.unknown_statement(span, word, near, _form(context), known))
    return None


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
    decimal_comma,
    colon_slice,
    two_operands,
)


def _form(context: ErrorContext) -> str:
    """Return the form of the statement with the error, or of the statements of its block."""
    block = _block(context)
    if begins_statement(context.read):
        return _peer_form(context, context.offset) or FORMS_IN[block]
    at = len(context.read) - 1
    while not begins_statement(context.read[at - 1 : at]):
        at -= 1
    first = context.read[at].type.lower()
    if "ELSE" in context.accepted and "THEN" in types_of_statement(context):
        return "a choice has both branches: `if a then b else c`"
    advice = _peer_form(context, place_of(context, context.read[at]).start)
    return advice or FORMS.get(first, FORMS_IN[block])


def _peer_form(context: ErrorContext, begin: int) -> str:
    """Return the way to write a statement that begins at an offset in another tool's words."""
    return statement_advice(_statement_at(context, begin), _block(context))


def _peer_form_of(context: ErrorContext) -> str:
    """Return the way to write the statement of the error, if it is one of another tool."""
    at = len(context.read)
    while not begins_statement(context.read[:at]):
        at -= 1
    begin = place_of(context, context.read[at]).start if at < len(context.read) else context.offset
    return _peer_form(context, begin)


def _statement_at(context: ErrorContext, begin: int) -> str:
    """Return the beginning of the statement at an offset, enough to recognise its form."""
    return context.source.text[begin : begin + _LONGEST_STATEMENT]


def _begins_line(context: ErrorContext, found: Token) -> bool:
    """Return whether a line begins here that reads like a statement."""
    begins = str(found) in RESERVED or _PART_OR_CHAIN.match(context.source.text, context.offset)
    return bool(begins) and context.at_start_of_line()


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
    while not begins_statement(read[:at][-1:]):
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
