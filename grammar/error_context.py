"""The place of a syntax error, and what is read there."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from lark import Token

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar.tokens import END, span_of
from bgc.record_class import dataclass

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
OPERAND_ENDS = frozenset("NAME NUMBER TIME TEXT RPAR RSQB".split())


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
        The kind of text: "file", "setting" or "filling".
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
        return "the end of the file" if self.found.type == END else quoted(self.found)

    def describe_previous(self) -> str:
        """Name the token before it, for a message."""
        return quoted(self.previous) if self.previous else ""

    def at_start_of_line(self) -> bool:
        """Return whether only blanks precede it on its line."""
        text = self.source.text
        return not text[text.rfind("\n", 0, self.offset) + 1 : self.offset].strip()


@dataclass(frozen=True, slots=True)
class Explanation:
    """A diagnostic, and the type of the missing sign if that is all that is wrong."""

    diagnostic: Diagnostic
    missing: str | None = None


def begins_statement(read: Sequence[Token]) -> bool:
    """Return whether a statement begins behind these tokens."""
    return not read or read[-1].type in ("SEMICOLON", "LBRACE", "RBRACE")


def types_of_statement(context: ErrorContext) -> Iterator[str]:
    """Return the types of the statement's tokens before the error, from the last to the first."""
    for at in range(len(context.read) - 1, -1, -1):
        if context.read[at].type in ("SEMICOLON", "LBRACE", "RBRACE"):
            return
        yield context.read[at].type


def place_of(context: ErrorContext, token: Token) -> Span:
    """Return the place of a token of the text."""
    return span_of(context.source, token)


def quoted(text: str) -> str:
    """Quote a piece of text as messages do, at most 40 characters of it."""
    return f"`{text}`" if len(text) <= 40 else f"`{text[:37]}...`"
