"""Derivatives of the columns of a run by one parameter."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Slopes:
    """Derivatives of columns by a parameter or an initial value, whose SI unit is `unit`.

    `columns` are those of the run, in their own units per `unit`; without energy accounts.
    """

    unit: str
    columns: Mapping[str, Array]

    def unit_of(self, unit: str) -> str:
        """The unit of a derivative of a column in `unit`: `m/kg`, `N/(N/m)`, `1/s`."""
        if self.unit in ("", "1"):
            return unit
        bare = all(letter not in self.unit for letter in "*/ ")
        return f"{unit or '1'}/{self.unit if bare else f'({self.unit})'}"


def column_name(column: str, parameter: str) -> str:
    """The name of the column of a derivative: `d tip_height/d crane.boom.mass`."""
    return f"d {column}/d {parameter}"
