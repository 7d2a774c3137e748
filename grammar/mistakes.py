"""Names a syntax error in the user's terms.

The parser knows what was found, what it could go on with, and which brackets are open. From
these the most pointed message is chosen, and, where one sign is evidently missing, that sign is
proposed to the parser so that it can read on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from lark import Token

from bgc.diagnostics.catalogue import did_you_mean
from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar.characters import explain_characters
from bgc.grammar.tokens import END, end_of, span_of
from bgc.grammar.words import BLOCK_OF, FORMS, FORMS_IN, PLACES, RESERVED, WORDS

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
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_USED_AS_NAME = re.compile(r"\s*(?::|->|,)")
_PART_OR_CHAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*(?:\[[^\]\n]*\])?[ \t]*(?::|->)")
_DECIMALS = re.compile(r"\d+")
_POSTFIX = ("LPAR", "LSQB", "DOT", "EQUAL")
_WORD_KINDS = frozenset(word.upper() for words in WORDS.values() for word in words) | frozenset(
    "IS OF IN OUT MAIN AS WITHIN EVERY THEN ELSE DER TIME".split()
)
_OPERAND_ENDS = frozenset("NAME NUMBER TIME TEXT RPAR RSQB".split())
_OPERAND_STARTS = frozenset("NAME NUMBER TIME DER TEXT LPAR".split())


@dataclass(frozen=True, slots=True)
class Trouble:
    """Where the parser cannot go on.

    `found` is the token there, None where the characters are no token at all; at the end of
    the text its type is `$END`. `read` are the tokens before it, `open` those of them that
    open a bracket or brace still to be closed, and `accepted` the types it could go on with.
    `outermost` is "file", or "setting" where the text is only that.
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
        """The token before."""
        return self.read[-1] if self.read else None

    def span(self) -> Span:
        """The place of the token that was found."""
        length = 1 if self.found is None else len(self.found)
        return Span(self.source, self.offset, self.offset + length)

    def describe_found(self) -> str:
        """What was found, as messages name it."""
        if self.found is None:
            return "something else"
        return "the end of the file" if self.found.type == END else _quoted(self.found)

    def describe_previous(self) -> str:
        """What was read before it, as messages name it."""
        return _quoted(self.previous) if self.previous else ""

    def at_start_of_line(self) -> bool:
        """Whether nothing but blanks is before it on its line."""
        text = self.source.text
        return not text[text.rfind("\n", 0, self.offset) + 1 : self.offset].strip()


@dataclass(frozen=True, slots=True)
class Mistake:
    """The diagnostic, and the type of the sign that is missing, if it is only that."""

    diagnostic: Diagnostic
    missing: str | None = None


def diagnose(trouble: Trouble) -> Mistake:
    """Find the most pointed message for a syntax error."""
    if trouble.found is None or _is_misread(trouble, trouble.found):
        return Mistake(explain_characters(trouble.source, trouble.offset, trouble.previous))
    for explain in _EXPLANATIONS:
        mistake = explain(trouble, trouble.found)
        if mistake is not None:
            return mistake
    return Mistake(
        wrong.unexpected(
            trouble.span(),
            trouble.describe_found(),
            list(_expected(trouble.accepted)),
            "" if _begins_statement(trouble.read) else trouble.describe_previous(),
            _form(trouble),
        )
    )


def _is_misread(trouble: Trouble, found: Token) -> bool:
    """Whether the token is only the start of a misspelt number, or of an unclosed comment."""
    starts_comment = trouble.source.text.startswith("/*", trouble.offset)
    return starts_comment or (found[:1] in set("0123456789") and found.type != "NUMBER")


# --- tokens out of place ----------------------------------------------------------------


def _end_of_block(trouble: Trouble, found: Token) -> Mistake | None:
    """A block is open at the end of the file, or where the next declaration begins a line."""
    if not trouble.open or "RBRACE" not in trouble.accepted:
        return None
    begins = str(found) in WORDS["file"] and str(found) not in WORDS["model"]
    if found.type == END or (begins and trouble.source.position(trouble.offset)[1] == 1):
        opened = _span_of(trouble, trouble.open[-1])
        place = trouble.describe_found()
        return Mistake(wrong.unclosed_block(trouble.span(), opened, place), "RBRACE")
    return None


def _statement_unfinished(trouble: Trouble, found: Token) -> Mistake | None:
    """Only the `;` is missing before the next statement, or before the end of the block."""
    if "SEMICOLON" not in trouble.accepted or trouble.previous is None:
        return None
    is_word = _WORD.fullmatch(found) is not None
    begins = found.type != "NAME" and str(found) in WORDS[_block(trouble)]
    if found.type in ("RBRACE", END) or begins or (is_word and trouble.at_start_of_line()):
        behind = end_of(trouble.previous)
        end = Span(trouble.source, behind, behind)
        return Mistake(wrong.missing_semicolon(end, trouble.describe_previous()), "SEMICOLON")
    return None


def _bracket(trouble: Trouble, found: Token) -> Mistake | None:
    """Something closes that is not open, or ends what a bracket still holds."""
    innermost = trouble.open[-1].type if trouble.open else ""
    if found.type in _CLOSER.values() and _CLOSER.get(innermost) != found.type:
        opener = next(kind for kind, closer in _CLOSER.items() if closer == found.type)
        if innermost in ("", "LBRACE") and all(token.type != opener for token in trouble.open):
            return Mistake(wrong.unmatched_closer(trouble.span()))
    elif found.type not in ("SEMICOLON", "LBRACE", END) and not _begins_line(trouble, found):
        return None
    closer = _CLOSER.get(innermost)
    if closer is None or innermost == "LBRACE":
        return None
    if closer not in trouble.accepted and found.type not in _CLOSER.values():
        return None
    opened = _span_of(trouble, trouble.open[-1])
    place = trouble.describe_found()
    unclosed = wrong.unclosed_bracket(trouble.span(), opened, _SIGN[closer], place)
    return Mistake(unclosed, closer if closer in trouble.accepted else None)


def _operator(trouble: Trouble, found: Token) -> Mistake | None:
    """A second comparison in a row, `=` for `==`, `==` for `=`, or `**`."""
    previous = trouble.previous
    if previous is None:
        return None
    if previous.type == found.type in ("EQUAL", "TIMES") and end_of(previous) == trouble.offset:
        doubled = Span(trouble.source, trouble.offset - 1, trouble.offset + 1)
        help = "a value is given with `=`" if found.type == "EQUAL" else "a power is `^`"
        return Mistake(wrong.foreign_operator(doubled, help))
    if previous.type not in _OPERAND_ENDS:
        return None
    before = set(_types_of_statement(trouble))
    if found.type == "COMPARE" and "COMPARE" in before:
        return Mistake(wrong.chained_comparison(trouble.span()))
    if found.type == "EQUAL" and before & {"IF", "ASSERT", "AND", "OR", "NOT"}:
        return Mistake(wrong.equals_in_condition(trouble.span()))
    return None


def _derivative(trouble: Trouble, found: Token) -> Mistake | None:
    """`der` is followed by something else than `(`."""
    previous = trouble.previous
    if previous is None or previous.type != "DER" or "LPAR" not in trouble.accepted:
        return None
    return Mistake(wrong.derivative_of_nothing(_span_of(trouble, previous)))


def _empty_statement(trouble: Trouble, found: Token) -> Mistake | None:
    """A `;` with nothing before it."""
    if found.type != "SEMICOLON" or not _begins_statement(trouble.read):
        return None
    return Mistake(wrong.empty_statement(trouble.span()))


def _reserved(trouble: Trouble, found: Token) -> Mistake | None:
    """A word of the language where a name must stand."""
    previous = trouble.previous
    if found.type == "COLON" and previous is not None and str(previous) in RESERVED:
        return Mistake(wrong.reserved_word(_span_of(trouble, previous), str(previous)))
    if "NAME" not in trouble.accepted or str(found) not in RESERVED:
        return None
    if trouble.at_start_of_line() and not _begins_statement(trouble.read):
        return None
    return Mistake(wrong.reserved_word(trouble.span(), str(found)))


def _first_word(trouble: Trouble, found: Token) -> Mistake | None:
    """A statement whose first word is unknown, or belongs somewhere else."""
    if _begins_statement(trouble.read):
        word, span = str(found), trouble.span()
        if _USED_AS_NAME.match(trouble.source.text, span.end):
            return None
    elif _begins_statement(trouble.read[:-1]) and trouble.read[-1].type == "NAME":
        word, span = str(trouble.read[-1]), _span_of(trouble, trouble.read[-1])
    else:
        return None
    here = _block(trouble)
    for block, place in PLACES.items():
        if word in WORDS[block] and word not in WORDS[here]:
            return Mistake(wrong.misplaced_statement(span, word, place))
    if word in RESERVED or not _WORD.fullmatch(word):
        return None
    near = did_you_mean(word, WORDS[here])
    if not near and span == trouble.span():
        near = did_you_mean(word, [each for words in WORDS.values() for each in words])
    if near or (span == trouble.span() and "NAME" not in trouble.accepted):
        return Mistake(wrong.unknown_statement(span, word, near, _form(trouble)))
    return None


def _decimal_comma(trouble: Trouble, found: Token) -> Mistake | None:
    """A comma where a number goes on: `1,5`."""
    previous = trouble.previous
    if found.type != "COMMA" or previous is None or previous.type != "NUMBER":
        return None
    decimals = _DECIMALS.match(trouble.source.text, trouble.offset + 1)
    if decimals is None or not previous.isdigit():
        return None
    start = _span_of(trouble, previous)
    span = Span(trouble.source, start.start, decimals.end())
    help = f"write `{previous}.{decimals[0]}`"
    return Mistake(wrong.misspelt_number(span, "a number has a decimal point, no comma", help))


def _two_operands(trouble: Trouble, found: Token) -> Mistake | None:
    """A value directly behind another: an operator or a proper unit is missing."""
    previous = trouble.previous
    if previous is None or "TIMES" not in trouble.accepted:
        return None
    if previous.type not in _OPERAND_ENDS or found.type not in _OPERAND_STARTS:
        return None
    if trouble.at_start_of_line():
        return None
    if previous.type == "NUMBER" and _WORD.fullmatch(found):
        span = _span_of(trouble, previous).to(trouble.span())
        if " " in previous:
            message, right = "a unit has no blanks inside", f"`{previous}*{found}`"
        else:
            message, right = "one blank stands before a unit", f"`{previous} {found}`"
        help = f"write {right}; a product is `{previous} * {found}`"
        return Mistake(wrong.misspelt_number(span, message, help))
    before, after = trouble.describe_previous(), trouble.describe_found()
    return Mistake(wrong.missing_operator(trouble.span(), before, after))


_EXPLANATIONS: tuple[Callable[[Trouble, Token], Mistake | None], ...] = (
    _end_of_block,
    _first_word,
    _statement_unfinished,
    _bracket,
    _operator,
    _derivative,
    _empty_statement,
    _reserved,
    _decimal_comma,
    _two_operands,
)


def _begins_statement(read: list[Token]) -> bool:
    """Whether a statement begins behind these tokens."""
    return not read or read[-1].type in ("SEMICOLON", "LBRACE", "RBRACE")


def _form(trouble: Trouble) -> str:
    """The form of the statement the trouble is in, or of what may stand in its block."""
    block = _block(trouble)
    if _begins_statement(trouble.read):
        return FORMS_IN[block]
    at = len(trouble.read) - 1
    while not _begins_statement(trouble.read[:at][-1:]):
        at -= 1
    return FORMS.get(trouble.read[at].type.lower(), FORMS_IN[block])


def _begins_line(trouble: Trouble, found: Token) -> bool:
    """Whether a line begins here that looks like a statement."""
    looks_so = str(found) in RESERVED or _PART_OR_CHAIN.match(trouble.source.text, trouble.offset)
    return bool(looks_so) and trouble.at_start_of_line()


def _types_of_statement(trouble: Trouble) -> Iterator[str]:
    """The types of the tokens of the statement so far, from the last to the first."""
    for at in range(len(trouble.read) - 1, -1, -1):
        if trouble.read[at].type in ("SEMICOLON", "LBRACE", "RBRACE"):
            return
        yield trouble.read[at].type


def _block(trouble: Trouble) -> str:
    """The kind of block the trouble is in: that of the first word before its `{`."""
    braces = [token for token in trouble.open if token.type == "LBRACE"]
    if not braces:
        return trouble.outermost
    read = trouble.read
    at = next(at for at in range(len(read) - 1, -1, -1) if read[at] is braces[-1])
    while not _begins_statement(read[:at][-1:]):
        at -= 1
    return BLOCK_OF.get(read[at].type, "law")


def _expected(accepted: frozenset[str]) -> Iterator[str]:
    """What the text could go on with, as messages name it."""
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


def _span_of(trouble: Trouble, token: Token) -> Span:
    return span_of(trouble.source, token)


def _quoted(text: str) -> str:
    """A text in the marks of messages, clipped."""
    return f"`{text}`" if len(text) <= 40 else f"`{text[:37]}...`"
