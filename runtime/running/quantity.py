"""Numbers with units, read from and written for users: `7`, `7 t`, `45 deg`."""

from __future__ import annotations

import math
import re
from numbers import Real
from typing import TypeAlias

from bgc.diagnostics.catalogue.arguments import not_a_quantity, not_a_value, wrong_unit
from bgc.diagnostics.diagnostic import BgError

_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def read_quantity(text: str, name: str, unit: str) -> float:
    """Read a number, or a number, a blank and a unit, as an SI value of the given unit.

    `name` names the value in messages. Raises BgError: BG062 if the text is not a number with an
    optional unit, BG063 if the unit has another dimension.
    """
    match = _NUMBER.match(text.strip())
    if match is None:
        raise BgError([not_a_value(text, name)])
    number = float(match.group())
    rest = text.strip()[match.end() :]
    if not math.isfinite(number) or (rest and not rest[0].isspace()):
        raise BgError([not_a_value(text, name)])
    return number * _factor(rest.strip(), name, unit) if rest else number


def read_number(text: str) -> float | None:
    """Read a number, with a unit or without, as its SI value; None if the text is another."""
    match = _NUMBER.match(text.strip())
    if match is None:
        return None
    rest = text.strip()[match.end() :]
    if not rest:
        return float(match.group())
    # As in `_factor`.
    from bgc.values.units import parse_unit

    parsed = parse_unit(rest.strip()) if rest[0].isspace() else None
    return float(match.group()) * float(parsed.factor) if parsed else None


Quantity: TypeAlias = float | str
"""An SI number, or a text with a unit: `0.002`, `"2 ms"`."""


def in_si(value: Quantity | None, name: str, unit: str) -> float | None:
    """Return an argument as an SI number, from a number or a text; None for None.

    `name` names it in messages. Raises BgError: BG062 or BG063 for a text, BG790 for another type.
    """
    if value is None:
        return None
    if isinstance(value, str):
        return read_quantity(value, name, unit)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise BgError([not_a_quantity(name, type(value).__name__, unit)])
    return float(value)


def spelled_time(seconds: float) -> str:
    """Write a time in s, ms, us or ns, whichever fits, with up to 12 digits."""
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= 0.999999 * size:
            return f"{seconds / size:.12g} {unit}"
    return f"{seconds * 1e9:.12g} ns"


def _factor(given: str, name: str, unit: str) -> float:
    """Return the factor from the unit `given` to SI; it must have the dimension of `unit`."""
    # The compiler's units are slow to load, and SI numbers do without them.
    from bgc.values.units import DIMENSIONLESS, parse_unit, ungrouped_unit

    parsed = parse_unit(given)
    if parsed is None:
        grouped = ungrouped_unit(given)
        raise BgError([not_a_value(given, name, grouped[2] if grouped else "")])
    wanted = parse_unit(unit) if unit else None
    if parsed.dimension != (wanted.dimension if wanted else DIMENSIONLESS):
        raise BgError([wrong_unit(name, given, unit)])
    return float(parsed.factor)
