"""The texts that an editor works on: its buffers, else the files of the disk, each parsed once."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from lark import Token

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Source
from bgc.grammar import syntax
from bgc.grammar.parse import parse_with_tokens
from bgc.grammar.source_files import read_source
from bgc.record_class import dataclass
from bgc.resolution.parse_cached import Parsed
from bgc.resolution.resolve import Reader

_Stamp: TypeAlias = str | tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """A parsed text with its tokens and syntax errors."""

    path: Path
    source: Source
    file: syntax.File
    tokens: tuple[Token, ...]
    diagnostics: tuple[Diagnostic, ...]


class Documents(Reader):
    """Parsed texts by path. A buffer hides the file of its path; files are read when they change.

    The source of a text has its resolved path as its name.
    """

    def __init__(self) -> None:
        self._buffers: dict[Path, str] = {}
        self._parsed: dict[Path, tuple[_Stamp, Document]] = {}

    def open(self, path: Path, text: str) -> None:
        """Enter a buffer, or replace its text."""
        self._buffers[path.resolve()] = text

    def close(self, path: Path) -> None:
        """Drop a buffer: the file of its path counts again."""
        self._buffers.pop(path.resolve(), None)
        self._parsed.pop(path.resolve(), None)

    def copy(self) -> Documents:
        """Return documents with the same texts, to be changed on their own."""
        other = Documents()
        other._buffers = dict(self._buffers)
        other._parsed = dict(self._parsed)
        return other

    @property
    def open_paths(self) -> tuple[Path, ...]:
        """The paths of the buffers."""
        return tuple(self._buffers)

    def has(self, path: Path) -> bool:
        """Return whether there is a buffer or a file."""
        return super().has(path) or path.resolve() in self._buffers

    def read(self, path: Path, name: str) -> Parsed:
        """Parse a text; its messages have the path, not `name`."""
        document = self.document(path)
        return document.file, document.diagnostics

    def document(self, path: Path) -> Document:
        """Return the parsed text of a path; BgError if its file cannot be read."""
        key = path.resolve()
        buffer = self._buffers.get(key)
        stamp = _stamp(key) if buffer is None else buffer
        known = self._parsed.get(key)
        if known is not None and known[0] == stamp:
            return known[1]
        source = read_source(key) if buffer is None else Source(str(key), buffer)
        file, tokens, diagnostics = parse_with_tokens(source)
        document = Document(key, source, file, tokens, diagnostics)
        self._parsed[key] = stamp, document
        return document

    def find(self, path: Path) -> Document | None:
        """Return the parsed text of a path, None if its file cannot be read."""
        try:
            return self.document(path)
        except BgError:
            return None


def _stamp(path: Path) -> _Stamp:
    try:
        found = path.stat()
    except (OSError, ValueError):
        return (0, 0)
    return found.st_mtime_ns, found.st_size
