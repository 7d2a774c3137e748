"""Names of the columns of a result: `tip[1]`, `force`, or with its unit `angle [deg]`."""

from __future__ import annotations

import re

from bgc.record_class import dataclass

_COMPONENTS = {"x": "1", "y": "2", "z": "3"}
_COLUMN = re.compile(r"(?P<vector>.+?)(?:(?<! )\[(?P<index>[\d,]+)\])?(?P<unit> \[[^\]]*\])?")


@dataclass(frozen=True, slots=True)
class AccountColumn:
    """A column that holds an energy account; `factor` is its unit in J."""

    account: str
    column: str
    unit: str = "J"
    factor: float = 1.0


def column_of(path: str) -> str:
    """Name the column of a vector's component written as a member: `tip[1]` for `tip.x`."""
    vector, dot, name = path.rpartition(".")
    return f"{vector}[{_COMPONENTS[name]}]" if dot and name in _COMPONENTS else path


def column_in(name: str, unit: str | None) -> str:
    """Name the column of a quantity that is observed in a unit of the scene: `tip[1] [mm]`."""
    return name if unit is None else f"{name} [{unit}]"


def name_in_si(column: str) -> str:
    """The name of a column without the unit that the scene gave it: `tip[1]` for `tip[1] [mm]`."""
    found = _COLUMN.fullmatch(column)
    return column.removesuffix(found["unit"]) if found and found["unit"] else column


def component_of(column: str) -> tuple[str, str]:
    """The vector or matrix that a column is a component of, and its index; empty for a scalar.

    `tip[1]` is component `1` of `tip`, `tip[1] [mm]` of `tip [mm]`.
    """
    found = _COLUMN.fullmatch(column)
    if found is None or not found["index"]:
        return "", ""
    return found["vector"] + (found["unit"] or ""), found["index"]


def vector_of(column: str) -> str:
    """The name of the vector or matrix that a column is a component of; empty for a scalar."""
    return component_of(column)[0]
