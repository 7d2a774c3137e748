"""Units as entries of the reference."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Code, Entry, Group, Text, rows_of
from bgc.values.units import PREFIXES, describe_dimension, parse_unit, unit_table

_UNITS_OF_THEIR_OWN = {"rad": "plane angle", "Hz": "frequency", "J": "energy"}


def _summaries() -> Mapping[str, str]:
    return {word: _summary(word) for word in unit_table()}


def _quantity(word: str) -> str:
    unit = parse_unit(word)
    assert unit is not None
    if unit.symbol in _UNITS_OF_THEIR_OWN:
        return _UNITS_OF_THEIR_OWN[unit.symbol]
    named = describe_dimension(unit.dimension)
    return named.partition(" ")[2].partition(" (")[0]


def _summary(word: str) -> str:
    unit = parse_unit(word)
    assert unit is not None
    if unit.factor == 1:
        return f"{_quantity(word)}, SI"
    return f"{_quantity(word)}, {float(unit.factor):.10g} {unit.symbol}"


def _entry(text: str) -> Entry:
    """Describe a unit: a word, one with a prefix, a product."""
    takes_prefix = unit_table().get(text)
    body: tuple[Block, ...] = (Code(f"param x : {text} = 2 {text};"),)
    if takes_prefix:
        examples = ", ".join(f"`{p}{text}`" for p in ("m", "k", "M"))
        body += (Text(f"It takes prefixes: {examples} and others (`bgc doc units`)."),)
    elif takes_prefix is False:
        body += (Text("It takes no prefix."),)
    return Entry("unit", text, _summary(text), body, ("units",))


def _others(text: str) -> tuple[Entry, ...]:
    return () if parse_unit(text) is None else (_entry(text),)


def _listing() -> tuple[Block, ...]:
    rows = tuple((prefix, f"{float(factor):g}") for prefix, factor in PREFIXES.items())
    plain = ", ".join(word for word, takes in unit_table().items() if not takes)
    return (
        rows_of(_summaries()),
        Table("prefixes", ("prefix", "factor"), rows, f"not of {plain}"),
        Text(
            "A unit stands one blank behind a number and holds none itself: `8 t`, `2 kg*m/s`, "
            "`10 s^-1`, `9.81 m/s^2`. Products and quotients group from the left: `J/kg*K` is "
            "J*K/kg. After a colon it declares the unit of a value: `param mass : kg = 8 t;`. A "
            "number without a unit is in SI units and fits any. Files and arrays are in SI units; "
            "tables and plots show values in the units in which they were written."
        ),
    )


GROUP = Group(
    "units",
    "units of measurement",
    _summaries,
    _entry,
    aliases=("unit", "prefixes"),
    listing=_listing,
    other=_others,
)
"""All unit words; each with a prefix is a unit too."""
