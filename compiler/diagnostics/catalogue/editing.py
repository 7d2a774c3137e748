"""Diagnostics of editors: names that cannot be changed."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def not_a_name(name: str, reserved: bool) -> Diagnostic:
    """BG133: a new name that cannot be a name

    What: an editor was asked to rename something to a text that is not a name, or to a word of the
    language.

    Why: a name consists of the letters a to z and A to Z, digits and `_`, and does not begin with
    a digit.

    Example: renaming `coil` to `my coil`, or to `port`.

    Way out: choose another name: `my_coil`.
    """
    fault = "is a word of the language" if reserved else "is not a name"
    help = "choose a name of letters, digits and `_`" + (f", such as `{name}_`" if reserved else "")
    return error("BG133", f"`{name}` {fault}", help=help)


def cannot_rename(name: str, reason: str) -> Diagnostic:
    """BG134: a name that cannot be changed here

    What: an editor was asked to rename something that is built in, is declared in the installed
    library, or has no declaration.

    Why: the files of the installed library are not the user's to change, and other models use
    their names.

    Example: renaming the function `sin`, or the model `Beam` of `crane.beam`.

    Way out: extend the library's model under a name of your own: `model MyBeam is Beam { }`.
    """
    help = (
        "extend it under a name of your own: `model Mine is ..`"
        if "library" in reason
        else ("put the cursor on a name that one of your files declares")
    )
    return error("BG134", f"`{name}` cannot be renamed: {reason}", help=help)


def rename_conflict(old: str, new: str, span: Span, why: str, others: Sequence[Span]) -> Diagnostic:
    """BG135: a new name that changes the meaning of a file

    What: with the new name, a place in one of the files would name something else, or a name would
    be declared twice.

    Why: renaming must not change the model. After the edit every name has to mean the declaration
    that it means now.

    Example: renaming the parameter `L` of a model to `R`, where the model has a parameter `R`.

    Way out: choose a name that is free in all models that use the declaration.
    """
    labels = [Label(other, "also here") for other in others]
    return error(
        "BG135",
        f"`{old}` cannot be renamed to `{new}`: {why}",
        span,
        labels=labels,
        help="choose a name that is free here",
    )


def analysis_failed(span: Span, reason: str) -> Diagnostic:
    """BG136: the compiler failed while a file was edited

    What: an editor asked for the diagnostics of a file, and the compiler ended with an error of
    its own.

    Why: this is a bug in bgc. Syntax and names are still checked; causality and equations of this
    text are not.

    Example: none is known.

    Way out: report it with the file. The next edit starts a new analysis.
    """
    return error(
        "BG136",
        f"this is a bug in bgc: {reason}",
        span,
        help="report it with this file; edit on, the analysis starts again",
    )
