"""Options in records: what users may give, its unit and range, and where it may be given.

A record is a frozen dataclass. A field made by `option` carries an `Option`, from which the checks
of values, the table of the manual, the options of commands and those of C follow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from enum import Flag, auto
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass, field, fields, replace

if TYPE_CHECKING:  # commands that compile nothing do without units
    from bgc.values.units import Dimension

_DIMENSIONS: Mapping[str, Dimension] = {
    "": (0, 0, 0, 0, 0, 0, 0),
    "s": (0, 0, 1, 0, 0, 0, 0),
    "Hz": (0, 0, -1, 0, 0, 0, 0),
}


class Where(Flag):
    """The places where an option may be given; C stands for FMUs and pages too."""

    SCENE = auto()
    COMMAND = auto()
    PYTHON = auto()
    C = auto()


@dataclass(frozen=True, slots=True)
class Option:
    """An option that users may give: its meaning, unit, range and places.

    Attributes
    ----------
    doc
        Its meaning, as a part of a sentence.
    default
        What holds where it is not given, in words.
    unit
        SI: `s`, `Hz`, or empty for a plain number; None where each state has its own.
    kind
        `float`, `int` for whole numbers, `str`, `tuple` for texts that an option of commands gives
        one by one, or `bool` for a switch of commands.
    number
        The kind of number in messages, where it is not the usual word.
    choices
        The words among which to choose.
    noun
        What messages call its value: `interval`.
    low, high
        The least and the largest value. Zero is never allowed: it stands for "not given".
    where
        Where it may be given.
    serves
        Whether it means something in a record with these other values.
    keyword, flag, metavar
        Its name in Python and in scenes; as an option of commands, empty where these lack it; and
        what stands for its value in help texts, where it is not the kind of number.
    example
        A value, as help texts show it.
    """

    doc: str
    default: str = "none"
    unit: str | None = ""
    kind: type = float
    number: str = ""
    choices: Collection[str] = ()
    noun: str = ""
    low: float = 0.0
    high: float = math.inf
    where: Where = ~Where(0)
    serves: Callable[[Any], bool] = lambda record: True
    keyword: str = ""
    flag: str = ""
    metavar: str = ""
    example: str = ""

    @property
    def dimension(self) -> Dimension | None:
        """The dimension of its unit; None where each state has its own."""
        return None if self.unit is None else _DIMENSIONS[self.unit]

    @property
    def help(self) -> str:
        """Its line in the help of commands."""
        shown = f": {self.example}" if self.example else ""
        return f"{self.doc[0].upper()}{self.doc[1:]}{shown}."

    def problem(self, name: str, value: float, span: Span | None = None) -> Diagnostic | None:
        """Return the error for a value, SI, outside its range (BG066); None for a good one."""
        in_range = 0.0 < value < math.inf and self.low <= value <= self.high
        if in_range and (self.kind is float or value == math.floor(value)):
            return None
        example = "8" if self.kind is int else "1e-3"
        return bad_option(name, value, self._allowed(), example, span)

    def _allowed(self) -> str:
        limit = f", between {self.low:g} and {self.high:g}" if self.low else f" up to {self.high:g}"
        return (self.number or f"a positive {'whole ' * (self.kind is int)}number") + (
            "" if math.isinf(self.high) else limit
        )


def option(doc: str, *, of: Any = 0.0, **facts: Any) -> Any:
    """Make a field of a record that users may give, with the value `of` where they do not.

    `facts` are those of `Option`.
    """
    return field(default=of, metadata={"option": Option(doc, **facts)})


@cache
def options_of(record: type, where: Where) -> Mapping[str, Option]:
    """The options of a record that may be given somewhere in `where`, by field, in order."""
    found: dict[str, Option] = {}
    for each in fields(record):
        known = each.metadata.get("option")
        if known is not None and known.where & where:
            keyword = known.keyword or each.name
            usual = f"--{keyword.replace('_', '-')}" if Where.COMMAND in known.where else ""
            found[each.name] = replace(known, keyword=keyword, flag=known.flag or usual)
    return MappingProxyType(found)
