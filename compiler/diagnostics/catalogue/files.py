"""BG001-BG019: the model file, before its text is parsed."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def file_missing(name: str, of_library: str = "") -> Diagnostic:
    """BG001: a file that does not exist

    What: no file has this path.
    Why: the path is misspelt, or relative to another folder.
    Example: `bgc run crnae.bg`
    Way out: correct the path. The message names a scene of the library that has the name.
    """
    help = "check the path and its spelling"
    if of_library:
        help = f"the library has a scene of this name: `{of_library}`"
    return error("BG001", f"there is no file `{name}`", help=help)


def is_directory(name: str, wanted: str = "a `.bg` file") -> Diagnostic:
    """BG002: a directory in place of a file

    What: the path names a directory.
    Why: bgc compiles one model file at a time; that file imports the others.
    Example: `bgc run models/`
    Way out: name a file in the directory: a `.bg` file, or for `bgc import` that of a robot.
    """
    return error("BG002", f"`{name}` is a directory", help=f"name {wanted} in it")


def unreadable(name: str, reason: str) -> Diagnostic:
    """BG003: a file that cannot be read

    What: the operating system does not allow the file to be read; the message gives its reason.
    Why: usually the file belongs to another user.
    Example: a file without read permission.
    Way out: change the permission, or copy the file.
    """
    return error("BG003", f"`{name}` cannot be read: {reason}")


def not_utf8(name: str, offset: int, byte: int, archive: bool) -> Diagnostic:
    """BG004: a file that is not UTF-8

    What: a byte of the file is not valid UTF-8.
    Why: the file is saved in another encoding, or is not a text file.
    Example: a comment with a Latin-1 `ø`; an FMU or another archive in place of the model.
    Way out: save the file as UTF-8; name the `.bg` file that an archive was made from.
    """
    what = f"`{name}` is not UTF-8: byte 0x{byte:02x} at offset {offset}"
    help = "save the file as UTF-8"
    if archive:
        what, help = f"`{name}` is an archive, not a text", "name the `.bg` file of the model"
    return error("BG004", what, help=help)


def too_large(name: str, size: int, limit: int, unit: str) -> Diagnostic:
    """BG005: a file that is too large

    What: the file is larger than 16 MB, or has more than a million lines.
    Why: such a file is most likely not a model.
    Example: a data file in place of a model.
    Way out: give the right file, or split the model into several files that import each other.
    """
    return error(
        "BG005",
        f"`{name}` is too large: {size:,} {unit}, at most {limit:,}",
        help="split the model into several files",
    )


def saved_by_bondgraphtools(span: Span) -> Diagnostic:
    """BG006: a model saved by BondGraphTools

    What: the file is a YAML model of the Python library BondGraphTools.
    Why: BondGraphTools uses the ending `.bg` too, for another language.
    Example: a file that begins with `version: 0.4`.
    Way out: write the model in this language: components become parts, the netlist becomes arrows.
    """
    return error(
        "BG006",
        "this is a YAML file of BondGraphTools, which also ends in `.bg`",
        span,
        help="write its components as parts (`r : R(2);`) and its netlist as bonds (`j -> r;`)",
    )
