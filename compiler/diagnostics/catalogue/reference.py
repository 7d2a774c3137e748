"""Diagnostics: arguments of `bgc doc` and `bgc new`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import Values, did_you_mean, error, listed, nearest


@error(
    "BG040: there is no documentation of `{name}`",
    "`bgc doc` lists what there is; `bgc doc FILE.bg NAME` looks in a file",
)
def unknown_topic(name: str, near: str, known: Iterable[str]) -> Values:
    return {"help": near or did_you_mean(name, known)}


@error("BG041: `{file}` does not declare `{name}`", "it declares {has}")
def not_in_file(name: str, file: str, known: Sequence[str]) -> Values:
    return {"has": listed(known) or "nothing", **nearest(name, known)}


@error("BG042: {path} exists already", "take another name, or move the file{more}")
def file_exists(path: str, option: str = "") -> Values:
    return {"more": f"; {option} replaces it" if option else ""}


@error(
    "BG043: `{stem}` cannot name a model and its scene",
    "use letters, digits and `_`, with a letter first, and no word of the language",
)
def bad_new_name(name: str, stem: str) -> Values:
    last = f"only the last part of {name} names the model: letters, digits and `_`"
    return {"help": "" if stem == name else last}
