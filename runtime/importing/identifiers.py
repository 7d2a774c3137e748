"""Names of the language for the names of a robot."""

from __future__ import annotations

import re
from collections.abc import Container, Iterable

from bgc.grammar.language_words import RESERVED
from bgc.grammar.latin import latin
from bgc.language.elements import ELEMENTS
from bgc.reference.library_entries import declarations

_TAKEN = frozenset(
    "base tip drives q q0 rates ground robot end servo shafts pi time energy "
    "x y z gravity rot_x rot_y rot_z euler_matrix quaternion_matrix symmetric diag norm zeros "
    "mimicked smooth_rate stack eye transpose".split()
)

_IMPORTED = ("mechanics.", "arms.link")  # modules that the file of a robot may import


class Names:
    """Gives each thing of a model a name of its own, as near to its own name as can be.

    `imported` are the modules, or their first letters, whose names the written file may see,
    `taken` names of values that it has anyway.
    """

    def __init__(
        self, imported: tuple[str, ...] = _IMPORTED, taken: Iterable[str] = _TAKEN
    ) -> None:
        self._values: set[str] = set(taken)
        self._types: set[str] = {
            *ELEMENTS,
            *(d.name for d in declarations() if d.module.startswith(imported)),
        }

    def value(self, text: str, other: str = "part") -> str:
        """Return a new name of a value or part; `other` if the text has no letters."""
        name = re.sub(r"[^A-Za-z0-9_]+", "_", latin(text)).strip("_") or other
        if not name[0].isalpha():
            name = f"{other}_{name}"
        if name in RESERVED:
            name = f"{name}_{other}"
        return _added(name[:60], self._values)

    def type(self, text: str) -> str:
        """Return a new name of a model."""
        words = re.findall(r"[A-Za-z0-9]+", latin(text))
        name = "".join(word[:1].upper() + word[1:] for word in words) or "Robot"
        if not name[0].isalpha():
            name = f"Robot{name}"
        return _added(name[:60], self._types)


def _added(name: str, taken: set[str]) -> str:
    found = free_name(name, taken)
    taken.add(found)
    return found


def free_name(name: str, taken: Container[str]) -> str:
    """Return the name, or the name with the first number behind it that makes it new."""
    found, number = name, 2
    while found in taken:
        found = f"{name}_{number}"
        number += 1
    return found
