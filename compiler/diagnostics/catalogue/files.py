"""BG001-BG019: the file itself, before a word of it is read."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def file_missing(name: str) -> Diagnostic:
    """BG001: a file that is not there

    What: the path names nothing.
    Why: it is misspelt, or taken from another folder than the one you are in.
    Example: `bgc run crnae.bg`
    Way out: correct the path.
    """
    return error("BG001", f"there is no file `{name}`", help="check the path and its spelling")


def is_directory(name: str) -> Diagnostic:
    """BG002: a directory in place of a file

    What: the path names a directory.
    Why: one model file is compiled at a time; it imports what else it needs.
    Example: `bgc run models/`
    Way out: name the `.bg` file in it.
    """
    return error("BG002", f"`{name}` is a directory", help="name a `.bg` file")


def unreadable(name: str, reason: str) -> Diagnostic:
    """BG003: a file that cannot be read

    What: the operating system refuses to read the file; the message has its reason.
    Why: most often it belongs to another user.
    Example: a file without the permission to read it
    Way out: change the permission, or copy the file.
    """
    return error("BG003", f"`{name}` cannot be read: {reason}")


def not_utf8(name: str, offset: int, byte: int) -> Diagnostic:
    """BG004: a file that is not UTF-8

    What: a byte of the file is not part of any UTF-8 text.
    Why: it is saved in another encoding, or is no text.
    Example: a comment with a Latin-1 `ø`
    Way out: save the file as UTF-8.
    """
    return error(
        "BG004",
        f"`{name}` is not UTF-8: byte 0x{byte:02x} at offset {offset}",
        help="save the file in the encoding UTF-8",
    )


def too_large(name: str, size: int, limit: int) -> Diagnostic:
    """BG005: a file that is too large

    What: the file is larger than 16 MB.
    Why: it is most likely not a model.
    Example: a data file given in place of a model
    Way out: give the right file, or divide the model into several files that import each other.
    """
    return error(
        "BG005",
        f"`{name}` is too large: {size:,} bytes, at most {limit:,}",
        help="divide the model into several files",
    )


def saved_by_bondgraphtools(span: Span) -> Diagnostic:
    """BG006: a model saved by BondGraphTools

    What: the file is a model that the Python library BondGraphTools saved as YAML.
    Why: it uses the ending `.bg` too, but it is another language.
    Example: a file that begins with `version: 0.4`
    Way out: write the model in this language: its components are parts, its netlist is arrows.
    """
    return error(
        "BG006",
        "this is a YAML file of BondGraphTools, which also ends in `.bg`",
        span,
        help="write its components as parts (`r : R(2);`) and its netlist as bonds (`j -> r;`)",
    )
