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
        return "a prefix has letters, digits and single underscores, a letter first"
    names = {prefix: _names(_OWN, text), prefix.upper(): _names(_OWN.upper(), text)}
    for start, own in names.items():
        if prefix != _OWN and (taken := own & _names(start, text)):
            return f"the C file has a name `{start}_{min(taken)}` already"
    return ""


def _names(start: str, text: str) -> set[str]:
    """The rests of the names of a C text that begin with `start_`."""
    return set(re.findall(rf"\b{start}_(\w+)", text))


def with_prefix(text: str, prefix: str) -> str:
    """Replace `bgc_` and `BGC_` at the start of each name of a C text; literals are kept."""
    names = {"bgc_": f"{prefix}_", "BGC_": f"{prefix.upper()}_"}
    return _TOKEN.sub(lambda found: names.get(found[0], found[0]), text)
