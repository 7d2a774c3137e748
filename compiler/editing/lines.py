"""Lines and columns as editors count them, and offsets as spans count them."""

from __future__ import annotations

import re
from bisect import bisect_right
from typing import Literal, TypeAlias

Encoding: TypeAlias = Literal["utf-8", "utf-16", "utf-32"]
Position: TypeAlias = tuple[int, int]
"""Line and column, both from 0; the column counts code units of the encoding."""

_LINE_END = re.compile(r"\r\n|\n|\r")


class Lines:
    """The lines of a text. Line ends are those of the language server protocol: LF, CRLF and CR."""

    def __init__(self, text: str, encoding: Encoding = "utf-16") -> None:
        self.text = text
        self._encoding = encoding
        ends = list(_LINE_END.finditer(text))
        self._starts = (0, *(end.end() for end in ends))
        self._ends = (*(end.start() for end in ends), len(text))

    def position(self, offset: int) -> Position:
        """Return the position of an offset; one behind the end of its line counts as the end."""
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self._starts, offset) - 1
        before = self.text[self._starts[line] : min(offset, self._ends[line])]
        return line, self._units(before)

    def offset(self, position: Position) -> int:
        """Return the offset of a position; one outside the text counts as the nearest inside."""
        line, column = position
        if line < 0:
            return 0
        if line >= len(self._starts):
            return len(self.text)
        start, end = self._starts[line], self._ends[line]
        if self._encoding == "utf-32" or self.text[start:end].isascii():
            return min(start + max(column, 0), end)
        at, units = start, 0
        while at < end:
            units += self._units(self.text[at])
            if units > column:
                break  # also within a pair of surrogates
            at += 1
        return at

    def end(self) -> Position:
        """Return the position of the end of the text."""
        return self.position(len(self.text))

    def _units(self, text: str) -> int:
        if text.isascii() or self._encoding == "utf-32":
            return len(text)
        if self._encoding == "utf-8":
            return len(text.encode("utf-8", "surrogatepass"))
        return sum(2 if ord(char) > 0xFFFF else 1 for char in text)
