"""BG04x: what `bgc doc` and `bgc new` are given."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_topic(name: str, near: str, known: Iterable[str]) -> Diagnostic:
    """BG040: a name that the reference does not have"""
    help = (
        near
        or did_you_mean(name, known)
        or "`bgc doc` lists what there is; `bgc doc FILE.bg NAME` looks in a file"
    )
    return error("BG040", f"there is no documentation of `{name}`", help=help)


def not_in_file(name: str, file: str, known: Sequence[str]) -> Diagnostic:
    """BG041: a name that a file does not declare"""
    has = f"it declares {listed(known)}" if known else "it declares nothing"
    help = did_you_mean(name, known) or has
    return error("BG041", f"`{file}` does not declare `{name}`", help=help)


def file_exists(path: str, option: str = "") -> Diagnostic:
    """BG042: a new file that is there already"""
    help = "take another name, or move the file" + (f"; {option} replaces it" if option else "")
    return error("BG042", f"{path} exists already", help=help)


def bad_new_name(name: str, stem: str) -> Diagnostic:
    """BG043: a name from which no model can be named"""
    return error(
        "BG043",
        f"`{stem}` cannot name a model and its scene",
        help="use letters, digits and `_`, with a letter first, and no word of the language"
        if stem == name
        else f"only the last part of {name} names the model: letters, digits and `_`",
    )
