"""Diagnostics of editors: names that cannot be changed."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def not_a_name(name: str, reserved: bool) -> Diagnostic:
    """BG133: a new name that cannot be a name"""
    fault = "is a word of the language" if reserved else "is not a name"
    help = "choose a name of letters, digits and `_`" + (f", such as `{name}_`" if reserved else "")
    return error("BG133", f"`{name}` {fault}", help=help)


def cannot_rename(name: str, reason: str) -> Diagnostic:
    """BG134: a name that cannot be changed here"""
    help = (
        "extend it under a name of your own: `model Mine is ..`"
        if "library" in reason
        else ("put the cursor on a name that one of your files declares")
    )
    return error("BG134", f"`{name}` cannot be renamed: {reason}", help=help)


def rename_conflict(old: str, new: str, span: Span, why: str, others: Sequence[Span]) -> Diagnostic:
    """BG135: a new name that changes the meaning of a file"""
    labels = [Label(other, "also here") for other in others]
    return error(
        "BG135",
        f"`{old}` cannot be renamed to `{new}`: {why}",
        span,
        labels=labels,
        help="choose a name that is free here",
    )


def analysis_failed(span: Span, reason: str) -> Diagnostic:
    """BG136: the compiler failed while a file was edited"""
    return error(
        "BG136",
        f"this is a bug in bgc: {reason}",
        span,
        help="report it with this file; edit on, the analysis starts again",
    )
