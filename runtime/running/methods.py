"""The integration methods and their properties.

`runtime/c/tableaus.c` holds the one table of them. A loaded model returns it
(`Library.methods`); `known_methods` reads it from the source text where no model is loaded, as for
documentation. A test compares the two.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

# The defaults of models in which explicit steps may cost less: with error control and fixed steps.
SWITCHING, SWITCHING_FIXED = "switching", "switching_fixed"
ADAPTIVE_OPTIONS = ("rtol", "atol", "step", "max_step", "max_steps", "settle")

_FAMILY = re.compile(r"^static const bgc_family (\w+) = \{\n(.*?)^\};", re.MULTILINE | re.DOTALL)
_STAGES = re.compile(r"^static const bgc_\w+ (\w+) = \{\n    \.stages = (\d+),", re.MULTILINE)
_TABLE = re.compile(r"^const bgc_method bgc_methods\[\] = \{\n(.*?)^\};", re.MULTILINE | re.DOTALL)
_ROW = re.compile(r"^    \{\n(.*?)^    \},", re.MULTILINE | re.DOTALL)
_FIELD = re.compile(r'^\s+\.(\w+) = &?"?(.*?)"?,$', re.MULTILINE)


@dataclass(frozen=True, slots=True)
class MethodInfo:
    """An integration method, as `bgc_method_info` of `bgc.h` describes it.

    Attributes
    ----------
    name, family
        As `rodas5p`; as `Rosenbrock`.
    purpose
        A line of text: the equations and uses that it is for.
    order
        Order of the solution.
    error_order
        Order of the embedded solution that estimates the error; 0: fixed steps only.
    jacobian
        Whether steps use df/dx. Without, the method is explicit and M of M y' = f must be diagonal.
    lanes
        Whether several instances can take its steps together.
    embedded_order
        Order of the solution by which fixed steps may be subdivided; 0: they may not.
    substeps
        Most parts of a fixed step where the options give none.
    stages
        Number of its stages.
    """

    name: str
    family: str
    purpose: str
    order: int
    error_order: int
    jacobian: bool
    lanes: bool
    embedded_order: int
    substeps: int
    stages: int

    @property
    def fixed(self) -> bool:
        """Return whether its steps have a given length."""
        return self.error_order == 0

    @property
    def explicit(self) -> bool:
        """Return whether its steps need no Jacobian."""
        return not self.jacobian

    @property
    def options(self) -> tuple[str, ...]:
        """Names of the options that it takes in a `solver` statement."""
        if not self.fixed:
            return ADAPTIVE_OPTIONS
        keep = ("keep",) if self.jacobian else ()
        divided = ("substeps", "rtol", "atol") if self.embedded_order else ()
        return ("step", *keep, *divided, "max_steps", "settle")


def default_method(methods: Iterable[MethodInfo], fixed: bool, changes: bool = False) -> MethodInfo:
    """Return the default with fixed steps or with error control: the first such method.

    With `changes` the first that changes to an explicit method where nothing is stiff.
    """
    changing = (SWITCHING, SWITCHING_FIXED)
    return next(m for m in methods if m.fixed == fixed and (m.name in changing or not changes))


@cache
def known_methods() -> tuple[MethodInfo, ...]:
    """Read all methods from the table in `runtime/c/tableaus.c`, in its order."""
    text = (Path(__file__).parents[1] / "c" / "tableaus.c").read_text(encoding="utf-8")
    families = {name: dict(_FIELD.findall(body)) for name, body in _FAMILY.findall(text)}
    table = _TABLE.search(text)
    assert table is not None
    stages = {name: int(number) for name, number in _STAGES.findall(text)}
    rows = (dict(_FIELD.findall(row)) for row in _ROW.findall(table[1]))
    return tuple(_method(row, families, stages) for row in rows)


def _method(
    row: dict[str, str], families: dict[str, dict[str, str]], stages: dict[str, int]
) -> MethodInfo:
    family = families[row["family"]]
    return MethodInfo(
        name=row["name"],
        family=family["name"],
        purpose=row["purpose"],
        order=int(row["order"]),
        error_order=int(row.get("error_order", 0)),
        jacobian=family.get("jacobian") == "1",
        lanes=family.get("lanes") == "1",
        embedded_order=int(row.get("embedded_order", 0)),
        substeps=int(row.get("substeps", 1)),
        stages=stages[row.get("tableau", "") or row["collocation"]],
    )
