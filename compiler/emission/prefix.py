"""Other names for what a C file of a model exports, so that two models link into one program."""

from __future__ import annotations

import re

_OWN = "bgc"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]{0,30}(?:_[A-Za-z0-9]+)*")
# String literals are kept: a parameter may be called `bgc_mass`.
_TOKEN = re.compile(r'"(?:[^"\\\n]|\\.)*"|\bbgc_|\bBGC_')


def prefix_problem(prefix: str, text: str) -> str:
    """Return why a prefix cannot replace `bgc` in a C text; empty if it can."""
    if not _NAME.fullmatch(prefix):
        return "letters, digits and single underscores, a letter first"
    taken = re.compile(rf"\b(?:{prefix}|{prefix.upper()})_")
    if prefix != _OWN and taken.search(text):
        return f"another prefix: names of the C file begin with `{prefix}_`"
    return ""


def with_prefix(text: str, prefix: str) -> str:
    """Replace `bgc_` and `BGC_` at the start of each name of a C text; literals are kept."""
    names = {"bgc_": f"{prefix}_", "BGC_": f"{prefix.upper()}_"}
    return _TOKEN.sub(lambda found: names.get(found[0], found[0]), text)
