"""Source texts and spans."""

from __future__ import annotations

import re
from bisect import bisect_right

from bgc.record_class import dataclass, field


@dataclass(frozen=True, slots=True)
class Source:
    """One `.bg` text, with the starts of its lines.

    `name` is printed in messages: the path as the user gave it, or `<text>`.
    """

    name: str
    text: str
    line_starts: tuple[int, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        ends = (end.end() for end in re.finditer("\n", self.text))
        object.__setattr__(self, "line_starts", (0, *ends))

    def position(self, offset: int) -> tuple[int, int]:
        """Return line and column, both from 1, of a character offset."""
        line = bisect_right(self.line_starts, offset)
        return line, offset - self.line_starts[line - 1] + 1

    def line_length(self, number: int) -> int:
        """Count the characters of line `number` (from 1), without its line end."""
        start = self.line_starts[number - 1]
        end = self.line_starts[number] - 1 if number < len(self.line_starts) else len(self.text)
        while end > start and self.text[end - 1] == "\r":
            end -= 1
        return end - start

    def line(self, number: int) -> str:
        """Return the text of line `number` (from 1), without its line end."""
        start = self.line_starts[number - 1]
        return self.text[start : start + self.line_length(number)]


@dataclass(frozen=True, slots=True)
class Span:
    """Characters `start` (inclusive) to `end` (exclusive) of a source."""

    source: Source = field(repr=False, compare=False)
    start: int
    end: int

    @property
    def text(self) -> str:
        """The text of the span."""
        return self.source.text[self.start : self.end]

    def to(self, other: Span) -> Span:
        """Return the span from the start of this one to the end of `other`."""
        return Span(self.source, self.start, other.end)
