"""Diagnostics: model files."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, error
from bgc.diagnostics.source import Span


@error("BG001: there is no file `{name}`", "check the path and its spelling")
def file_missing(name: str, of_library: str = "") -> Values:
    return {"help": f"the library has a scene of this name: `{of_library}`" if of_library else ""}


@error("BG002: `{name}` is a directory", "name {wanted} in it")
def is_directory(name: str, wanted: str = "a `.bg` file") -> None: ...
@error("BG003: `{name}` cannot be read: {reason}")
def unreadable(name: str, reason: str) -> None: ...
@error("BG004: `{name}` is {fault}", "save the file as UTF-8")
def not_utf8(name: str, offset: int, byte: int, archive: bool) -> Values:
    if archive:
        return {"fault": "an archive, not a text", "help": "name the `.bg` file of the model"}
    return {"fault": f"not UTF-8: byte 0x{byte:02x} at offset {offset}"}


@error(
    "BG005: `{name}` is too large: {size:,} {unit}, at most {limit:,}",
    "split the model into several files",
)
def too_large(name: str, size: int, limit: int, unit: str) -> None: ...
@error(
    "BG006: this is a YAML file of BondGraphTools, which also ends in `.bg`",
    "write its components as parts (`r : R(2);`) and its netlist as bonds (`j -> r;`)",
)
def saved_by_bondgraphtools(span: Span) -> None: ...
