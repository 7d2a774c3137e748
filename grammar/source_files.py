"""Reading of `.bg` files."""

from __future__ import annotations

from pathlib import Path

from bgc.diagnostics.catalogue import files
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source

MAX_BYTES = 16_000_000
MAX_LINES = 1_000_000
_ZIP = b"PK\x03\x04"


def read_source(path: Path) -> Source:
    """Read a file of UTF-8 text, with or without a byte order mark.

    Raises
    ------
    BgError
        If the file does not exist, is a directory, cannot be read, is larger than 16 MB, has more
        than a million lines or is not UTF-8.
    """
    name = str(path)
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            size = max(path.stat().st_size, len(data))
            raise BgError([files.too_large(name, size, MAX_BYTES, "bytes")])
        if (lines := data.count(b"\n")) > MAX_LINES:
            raise BgError([files.too_large(name, lines, MAX_LINES, "lines")])
    except FileNotFoundError:
        raise BgError([files.file_missing(name)]) from None
    except IsADirectoryError:
        raise BgError([files.is_directory(name)]) from None
    except OSError as reason:
        raise BgError([files.unreadable(name, reason.strerror or "unknown")]) from None
    except ValueError:  # a NUL character in the path
        raise BgError([files.file_missing(name)]) from None
    try:
        return Source(name, data.decode("utf-8-sig"))
    except UnicodeDecodeError as reason:
        archive = data.startswith(_ZIP)
        raise BgError([files.not_utf8(name, reason.start, data[reason.start], archive)]) from None
