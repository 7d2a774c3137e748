"""Diagnostics: renaming in an editor."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error
from bgc.diagnostics.source import Span


@error("BG133: `{name}` {fault}", "choose a name of letters, digits and `_`{such}")
def not_a_name(name: str, reserved: bool) -> Values:
    if reserved:
        return {"fault": "is a word of the language", "such": f", such as `{name}_`"}
    return {"fault": "is not a name", "such": ""}


@error(
    "BG134: `{name}` cannot be renamed: {reason}",
    "put the cursor on a name that one of your files declares",
)
def cannot_rename(name: str, reason: str) -> Values:
    own = "extend it under a name of your own: `model Mine is ..`"
    return {"help": own if "library" in reason else ""}


@error(
    "BG135: `{old}` cannot be renamed to `{new}`: {why}",
    "choose a name that is free here",
    labels={"others": "also here"},
)
def rename_conflict(old: str, new: str, span: Span, why: str, others: Sequence[Span]) -> None: ...
@error(
    "BG136: this is a bug in bgc: {reason}",
    "report it with this file; edit on, the analysis starts again",
)
def analysis_failed(span: Span, reason: str) -> None: ...
