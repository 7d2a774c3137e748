"""Files of rows that are written while a run goes on, in constant memory.

Each file can be read at any time and holds all rows that have been appended, also where the disk
becomes full or the process is killed.
"""

from __future__ import annotations

import io
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.files import append_rows

MOST_ROWS = 1 << 16
"""Rows of a block at most, and of a chunk of a Zarr group."""

_ROWS_AT_ONCE = 4096


@dataclass(frozen=True, slots=True)
class RowArray:
    """An array of a file, with one entry for each row.

    `places` are those of its numbers in a row of the run, which are divided by `factor`; `shape`
    is that of an entry, () for a column.
    """

    name: str
    unit: str
    shape: tuple[int, ...]
    places: tuple[int, ...]
    factor: float = 1.0

    def of(self, rows: Array) -> Array:
        """The entries of rows, (n, *shape)."""
        if not self.shape:
            found = rows[:, self.places[0]]
        else:
            found = rows[:, list(self.places)].reshape(len(rows), *self.shape)
        return found if self.factor == 1.0 else found / self.factor


class RowFile(ABC):
    """A file, or a folder, that rows are appended to.

    `rows` is their number so far. Methods raise OSError where the operating system refuses; the
    file then holds that many rows, and only `end` may be called.
    """

    rows = 0

    @abstractmethod
    def append(self, times: Array, rows: Array) -> None:
        """Write rows, (n, width), at times, s, (n,)."""

    @abstractmethod
    def end(self, about: Mapping[str, Any]) -> None:
        """Write what is known after the run, and close the file."""


def header_line(names: Sequence[str]) -> str:
    """The first line of a CSV file; names with commas or quotes are quoted."""
    line = io.StringIO()
    append_rows(line, ("time", *names), ())
    return line.getvalue()


def row_lines(table: Array) -> str:
    """The lines of a CSV file: numbers in full precision."""
    return "".join(",".join(map(repr, row)) + "\n" for row in table.tolist())


class CsvRows(RowFile):
    """Lines of a CSV file; a line that could not be written whole is removed."""

    def __init__(self, target: Path | TextIO, columns: Sequence[RowArray]) -> None:
        self._columns = columns
        if isinstance(target, Path):
            special = target.exists() and not target.is_file()
            self._file: Any = target.open("wb", buffering=0)
            self._write: Callable[[str], object] = self._raw_write
            self._regular = not special
        else:
            self._file, self._write, self._regular = target, target.write, False
        self._size = 0  # bytes of whole rows
        self._add(header_line([column.name for column in columns]), 0)

    def append(self, times: Array, rows: Array) -> None:
        """Write lines, some thousands at once."""
        for start in range(0, len(times), _ROWS_AT_ONCE):
            part = slice(start, start + _ROWS_AT_ONCE)
            columns = (column.of(rows[part]) for column in self._columns)
            table = np.column_stack((times[part], *columns))
            self._add(row_lines(table), len(table))

    def end(self, about: Mapping[str, Any]) -> None:
        """Close the file; one that the caller opened stays open."""
        if self._write == self._raw_write:
            self._file.close()

    def _add(self, text: str, count: int) -> None:
        self._write(text)
        self.rows += count

    def _raw_write(self, text: str) -> None:
        data = text.encode()
        try:
            write_all(self._file, data)
        except OSError:
            if self._regular:
                self._file.truncate(self._size)
            raise
        self._size += len(data)


def write_all(file: io.RawIOBase, data: bytes | memoryview) -> None:
    """Write all bytes to an unbuffered file, which may take some at a time."""
    rest = memoryview(data).cast("B")
    while len(rest):
        rest = rest[file.write(rest) or 0 :]
