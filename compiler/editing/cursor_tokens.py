"""Tokens by their places: the names behind an offset, and the token under a cursor."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence

from lark import Token

from bgc.diagnostics.source import Source, Span
from bgc.grammar.tokens import end_of, span_of, start_of


class Words:
    """The tokens of a text. Tokens that recovery inserted have no characters and are left out."""

    def __init__(self, source: Source, tokens: Sequence[Token]) -> None:
        self.source = source
        self.tokens = tuple(sorted((t for t in tokens if str(t)), key=start_of))
        self._starts = [start_of(token) for token in self.tokens]

    def name_after(self, offset: int, name: str) -> Span | None:
        """Return the first place of a name at or behind an offset."""
        for token in self.tokens[bisect_left(self._starts, offset) :]:
            if token.type == "NAME" and str(token) == name:
                return span_of(self.source, token)
        return None

    def at(self, offset: int) -> Token | None:
        """Return the token under a cursor; where two meet, the one that is a word."""
        place = bisect_right(self._starts, offset) - 1
        found = [
            token
            for token in self.tokens[max(place - 1, 0) : place + 1]
            if start_of(token) <= offset <= end_of(token)
        ]
        return min(found, key=lambda t: not str(t)[0].isalnum(), default=None)

    def before(self, offset: int) -> tuple[Token, ...]:
        """Return the tokens that end at or before an offset."""
        return tuple(
            t for t in self.tokens[: bisect_right(self._starts, offset)] if end_of(t) <= offset
        )
