"""The unit in which tables, plots and messages show a quantity that is stored in SI.

Every place that prints a quantity uses `Shown`: `output pressure : bar` is computed and written to
files in Pa, and shown in bar. A warm run needs this module, so it imports nothing of the compiler.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, isinf
from typing import TypeAlias

from bgc.record_class import dataclass

ShownRow: TypeAlias = tuple[str, str, float]
"""A name, the unit in which it is shown, and the factor of that unit to SI."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A unit as written: a value of it is the SI value divided by `factor`."""

    unit: str
    factor: float = 1.0

    def number(self, si: float) -> float:
        """The number in this unit, of one in `si`; a step of a double off a decimal is rounded."""
        number = si / self.factor
        if self.factor == 1.0:
            return number
        rounded = float(f"{number:.15g}")
        return rounded if rounded * self.factor == si else number

    def text(self, si: float, digits: int = 6) -> str:
        """The number in `si` with its unit, in `digits` digits: `200 bar`, or a plain number."""
        number = self.number(si) + 0.0
        outside = isfinite(si) and si != 0.0 and (isinf(number) or number == 0.0)
        text = self._text_outside(si, digits) if outside else f"{number:.{digits}g}"
        return f"{text} {self.label}".rstrip()

    def _text_outside(self, si: float, digits: int) -> str:
        """A number that is outside the range of doubles in this unit, though not in SI."""
        # Slow to load, and rarely needed.
        from decimal import Decimal

        number = Decimal(si) / Decimal(self.factor)
        return str(Decimal(f"{number:.{digits}g}").normalize()).lower()

    @property
    def label(self) -> str:
        """The unit; empty for a plain number."""
        return "" if self.unit == "1" else self.unit

    def heading(self, name: str) -> str:
        """A name with the unit in brackets, for axes and columns of tables: `tension [kN]`."""
        return f"{name} [{self.label}]" if self.label else name


def shown_by(rows: Iterable[ShownRow]) -> dict[str, Shown]:
    """Units by name."""
    return {name: Shown(unit, factor) for name, unit, factor in rows}
