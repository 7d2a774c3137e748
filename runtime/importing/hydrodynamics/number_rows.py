"""Text files of numbers: their lines, and rows of numbers below headers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path

from bgc.diagnostics.catalogue.imported import wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.grammar.source_files import read_source
from bgc.record_class import dataclass

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?$")


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a file, with its numbers if it has nothing else."""

    text: str
    numbers: tuple[float, ...]
    span: Span


def read_lines(path: Path) -> list[Line]:
    """Read the lines of a text that are not blank."""
    source, start, lines = read_source(path), 0, []
    for line in source.text.split("\n"):
        if line.strip():
            lines.append(Line(line, numbers_of(line), Span(source, start, start + len(line))))
        start += len(line) + 1
    return lines


def numbers_of(text: str) -> tuple[float, ...]:
    """Return the numbers of a line, none where it holds anything else."""
    words = text.split()
    found = leading_numbers(text)
    return found if len(found) == len(words) else ()


def leading_numbers(text: str) -> tuple[float, ...]:
    """Return the numbers before the first word that is none, or is too large for a double."""
    found: list[float] = []
    for word in text.replace("!", " ! ").split():
        value = float(word.lower().replace("d", "e")) if _NUMBER.match(word) else math.inf
        if not math.isfinite(value):
            break
        found.append(value)
    return tuple(found)


def rows_below_header(path: Path, widths: tuple[int, ...]) -> Iterator[Line]:
    """Iterate over the rows of numbers of a file, which may have headers of words in front.

    Raises
    ------
    BgError
        BG138 for a row of another number of columns, and for words below the first row.
    """
    began = False
    for line in read_lines(path):
        if line.numbers and len(line.numbers) in widths:
            began = True
            yield line
        elif began:
            columns = " or ".join(map(str, widths))
            what = f"this is no row of {columns} numbers"
            raise BgError([wrong_value(line.span, what, "write the file again, or correct it")])
    if not began:
        what = f"{path} has no rows of numbers"
        raise BgError([wrong_value(None, what, "write the file again")])
