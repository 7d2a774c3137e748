"""BG001-BG019: the model file, before its text is parsed."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def file_missing(name: str, of_library: str = "") -> Diagnostic:
    """BG001: a file that does not exist"""
    help = "check the path and its spelling"
    if of_library:
        help = f"the library has a scene of this name: `{of_library}`"
    return error("BG001", f"there is no file `{name}`", help=help)


def is_directory(name: str, wanted: str = "a `.bg` file") -> Diagnostic:
    """BG002: a directory in place of a file"""
    return error("BG002", f"`{name}` is a directory", help=f"name {wanted} in it")


def unreadable(name: str, reason: str) -> Diagnostic:
    """BG003: a file that cannot be read"""
    return error("BG003", f"`{name}` cannot be read: {reason}")


def not_utf8(name: str, offset: int, byte: int, archive: bool) -> Diagnostic:
    """BG004: a file that is not UTF-8"""
    what = f"`{name}` is not UTF-8: byte 0x{byte:02x} at offset {offset}"
    help = "save the file as UTF-8"
    if archive:
        what, help = f"`{name}` is an archive, not a text", "name the `.bg` file of the model"
    return error("BG004", what, help=help)


def too_large(name: str, size: int, limit: int, unit: str) -> Diagnostic:
    """BG005: a file that is too large"""
    return error(
        "BG005",
        f"`{name}` is too large: {size:,} {unit}, at most {limit:,}",
        help="split the model into several files",
    )


def saved_by_bondgraphtools(span: Span) -> Diagnostic:
    """BG006: a model saved by BondGraphTools"""
    return error(
        "BG006",
        "this is a YAML file of BondGraphTools, which also ends in `.bg`",
        span,
        help="write its components as parts (`r : R(2);`) and its netlist as bonds (`j -> r;`)",
    )
