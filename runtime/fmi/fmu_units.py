"""Units of an FMU: each unit in use with its exponents of the SI base units."""

from __future__ import annotations

import re
from collections.abc import Iterable

from bgc.record_class import dataclass
from bgc.values.shown_units import Shown
from bgc.values.units import BASE_UNITS, parse_unit

_RADIANS = re.compile(r"(^|[*/])rad(?:\^?(-?\d+))?(?=$|[*/])")


@dataclass(frozen=True, slots=True)
class UnitDefinition:
    """A unit: `base` are the attributes of BaseUnit, `displays` units with their factors."""

    name: str
    base: tuple[tuple[str, str], ...]
    displays: tuple[tuple[str, str], ...]


def unit_name(unit: str) -> str:
    """The name of a unit in the model description; empty for a plain number."""
    return "" if unit in ("", "1") else unit


def unit_definitions(used: Iterable[tuple[str, Shown | None]]) -> tuple[UnitDefinition, ...]:
    """Define the units in use, given with the units in which tables show them, sorted by name."""
    displays: dict[str, dict[str, str]] = {}
    for unit, shown in used:
        if name := unit_name(unit):
            found = displays.setdefault(name, {})
            if shown is not None and shown.unit != name:
                found[shown.unit] = repr(1.0 / shown.factor)
    return tuple(
        UnitDefinition(name, _base(name), tuple(sorted(displays[name].items())))
        for name in sorted(displays)
    )


def _base(name: str) -> tuple[tuple[str, str], ...]:
    """The exponents of the base units, the factor if it is not 1, and radians."""
    unit = parse_unit(name)
    if unit is None or any(exponent != int(exponent) for exponent in unit.dimension):
        return ()
    exponents = {
        base: int(exponent) for base, exponent in zip(BASE_UNITS, unit.dimension, strict=True)
    }
    radians = _RADIANS.findall(unit.symbol)
    exponents["rad"] = sum(int(power or 1) * (-1 if sign == "/" else 1) for sign, power in radians)
    attributes = [(base, str(exponent)) for base, exponent in exponents.items() if exponent]
    if unit.factor != 1:
        attributes.append(("factor", repr(float(unit.factor))))
    return tuple(attributes)
