"""Parse trees, their tokens, and the places of tokens in the text."""

from __future__ import annotations

from typing import Any, TypeAlias

from lark import Token, Tree

from bgc.diagnostics.source import Source, Span

ParseTree: TypeAlias = Tree[Any]
"""A rule as it was read. Its children are trees, tokens, and None where a part is left out."""

END = "$END"
"""Lark's token type for the end of the text."""


def token_at(kind: str, offset: int) -> Token:
    """Make an empty token: the end of the text, or a sign that the text lacks."""
    return Token(kind, "", start_pos=offset, end_pos=offset)


def span_of(source: Source, token: Token) -> Span:
    """Return the place of a token."""
    return Span(source, start_of(token), end_of(token))


def start_of(token: Token) -> int:
    """Return the offset of the first character of a token."""
    assert token.start_pos is not None, "every token has its place"
    return token.start_pos


def end_of(token: Token) -> int:
    """Return the offset behind the last character of a token."""
    assert token.end_pos is not None, "every token has its place"
    return token.end_pos
