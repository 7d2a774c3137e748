"""The requirements of a scene, judged in a run: limits of columns, and accuracies."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from bgc.diagnostics.catalogue.accuracy import limit_missed, not_accurate
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.values.shown_units import Shown

_MOST_RATIO = 1000.0  # a larger one is not counted
_NEAR = 10.0  # times the error of a value: nearer to its limit, the error is shown


@dataclass(frozen=True, slots=True)
class Requirement:
    """A `require` statement and the value that a run has for it, in the unit of its column.

    Attributes
    ----------
    text
        `max(tension) < 300 kN`, or `tip_height within 1 mm`.
    value, time
        The extreme that is limited and its time, s; or the largest estimated error of a quantity
        whose accuracy is required. NaN where it is not known.
    error
        The estimated error of an extreme; NaN where it is not known, 0 for an accuracy.
    limit, below
        The limit, and whether the value has to be below it.
    shown
        The unit in which the values are shown.
    """

    text: str
    value: float
    error: float
    limit: float
    below: bool
    shown: Shown
    time: float = math.nan

    @property
    def margin(self) -> float:
        """The distance of the value to its limit, positive where it holds; NaN if not known."""
        return self.limit - self.value if self.below else self.value - self.limit

    @property
    def holds(self) -> bool | None:
        """True where the value is within its limit; None where the value is not known."""
        return None if math.isnan(self.margin) else self.margin > 0

    @property
    def verdict(self) -> str:
        """`holds`, `missed` or `unknown`; by how much the value may be off where that decides."""
        word = {True: "holds", False: "missed", None: "unknown"}[self.holds]
        return f"{word}, within the error" if abs(self.margin) <= self.error else word

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """The row of a table: text, value, margin and verdict."""
        if self.holds is None:
            return self.text, "", "", self.verdict
        if math.isnan(self.time):
            ratio = self.limit / self.value if self.value > 0 else math.inf
            return self.text, self.shown.text(self.value, 1), spelled_ratio(ratio), self.verdict
        value, margin = self.shown.text(self.value, 5), self.shown.text(self.margin, 3)
        if abs(self.margin) <= _NEAR * self.error:
            value += f" +- {self.shown.text(self.error, 1)}"
        return self.text, value, margin, self.verdict


def spelled_ratio(ratio: float) -> str:
    """Write how many times an error fits in its limit."""
    return f"{float(f'{ratio:.2g}'):g} x" if ratio < _MOST_RATIO else f"over {_MOST_RATIO:g} x"


def requirement_table(found: Sequence[Requirement]) -> Table:
    """The values of requirements, their margins and whether they hold."""
    rows = tuple(each.cells for each in found)
    return Table("", ("require", "value", "margin", ""), rows)


def missed(found: Sequence[Requirement]) -> Iterator[Diagnostic]:
    """Warn of the requirements that do not hold (BG720, BG721)."""
    for each in found:
        if each.holds is False:
            value = each.shown.text(each.value, 5)
            if math.isnan(each.time):
                yield not_accurate(each.text, each.shown.text(each.value, 1))
            else:
                yield limit_missed(each.text, value, each.time)
