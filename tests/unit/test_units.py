"""Units: exact factors, dimensions, spellings and suggestions; pint is the independent answer."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pint
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import bgc
from bgc.values import units
from bgc.values.units import (
    DIMENSIONLESS,
    Written,
    describe_dimension,
    divide,
    multiply,
    parse_unit,
    power,
    si_symbol,
    spaced_product,
    suggest_conversion,
    suggest_unit,
)

MODELS = Path(__file__).parents[1] / "models"

LONG_NAMES = {
    "m": "meter", "g": "gram", "s": "second", "A": "ampere", "K": "kelvin", "mol": "mole",
    "cd": "candela", "rad": "radian", "Hz": "hertz", "N": "newton", "Pa": "pascal", "bar": "bar",
    "J": "joule", "W": "watt", "C": "coulomb", "V": "volt", "F": "farad", "ohm": "ohm",
    "S": "siemens", "Wb": "weber", "T": "tesla", "H": "henry", "L": "liter", "l": "liter",
    "t": "metric_ton", "Wh": "watt_hour", "kn": "knot",
    "min": "minute", "h": "hour", "day": "day", "deg": "degree", "rev": "turn",
    "rpm": "revolutions_per_minute", "knot": "knot", "nmi": "nautical_mile",
}  # fmt: skip
LONG_PREFIXES = {
    "p": "pico", "n": "nano", "u": "micro", "m": "milli", "c": "centi", "d": "deci",
    "h": "hecto", "k": "kilo", "M": "mega", "G": "giga", "T": "tera",
}  # fmt: skip
PINT_BASE = {
    "[mass]": 0,
    "[length]": 1,
    "[time]": 2,
    "[current]": 3,
    "[temperature]": 4,
    "[substance]": 5,
    "[luminosity]": 6,
}
WORDS = sorted({*units._WITH_PREFIX, *units._WITHOUT_PREFIX, "kN", "MPa", "mm", "uF", "kohm"})

exponents = st.integers(-4, 4).filter(bool)
texts = st.lists(st.tuples(st.sampled_from("*/"), st.sampled_from(WORDS), exponents), min_size=1)
dimensions = st.tuples(*[st.integers(-4, 4)] * 7)


def spell(factors: list[tuple[str, str, int]]) -> str:
    text = "".join(f"{operator}{word}^{exponent}" for operator, word, exponent in factors[:5])
    return text[1:] if text[0] == "*" else "1" + text


def test_every_unit_agrees_with_pint() -> None:
    registry = pint.UnitRegistry()
    names = {word: LONG_NAMES[word] for word in (*units._WITH_PREFIX, *units._WITHOUT_PREFIX)}
    for prefix, word in itertools.product(units.PREFIXES, units._WITH_PREFIX):
        names.setdefault(prefix + word, LONG_PREFIXES[prefix] + LONG_NAMES[word])
    for word, name in names.items():
        unit = parse_unit(word)
        assert unit is not None
        base = (1.0 * registry.Unit(name)).to_base_units()
        assert base.magnitude == pytest.approx(float(unit.factor), rel=1e-14), word
        found = [0] * 7
        for kind, exponent in base.dimensionality.items():
            found[PINT_BASE[kind]] = int(exponent)
        assert tuple(found) == unit.dimension, word


def test_a_word_of_its_own_wins_over_a_prefix() -> None:
    for word, symbol in (("cd", "cd"), ("min", "s"), ("Pa", "Pa"), ("T", "T"), ("h", "s")):
        unit = parse_unit(word)
        assert unit is not None and unit.symbol == symbol


@pytest.mark.parametrize(
    ("text", "factor", "symbol"),
    [
        ("kN*m", 1000, "N*m"),
        ("kg*m/s", 1, "kg*m/s"),
        ("s^-1", 1, "1/s"),
        ("1/s", 1, "1/s"),
        ("N/m", 1, "N/m"),
        ("L/min", Fraction(1, 60_000), "m^3/s"),
        ("l/min", Fraction(1, 60_000), "m^3/s"),
        ("kn", Fraction(1852, 3600), "m/s"),
        ("kWh", 3_600_000, "J"),
        ("mbar", 100, "Pa"),
        ("deg/s", Fraction(math.pi) / 180, "rad/s"),
        ("km/h", Fraction(5, 18), "m/s"),
        ("mm/m", Fraction(1, 1000), "1"),
        ("W/m/K", 1, "W/m/K"),
        ("g*m*m", Fraction(1, 1000), "kg*m^2"),
        ("m^0.5", 1, "m^0.5"),
        ("1", 1, "1"),
        ("rad/s", 1, "rad/s"),
    ],
)
def test_factor_is_exact_and_symbol_keeps_the_spelling(
    text: str, factor: Fraction | int, symbol: str
) -> None:
    unit = parse_unit(text)
    assert unit is not None
    assert (unit.factor, unit.symbol) == (factor, symbol)


def test_degree_is_the_double_of_pi_over_180() -> None:
    degree, rpm = parse_unit("deg"), parse_unit("rpm")
    assert degree is not None and rpm is not None
    assert degree.factor == Fraction(math.pi) / 180
    assert degree.dimension == DIMENSIONLESS
    assert (rpm.symbol, rpm.dimension) == ("rad/s", (0, 0, -1, 0, 0, 0, 0))


@pytest.mark.parametrize(
    "text",
    ["L^9", "", "x", "Nm", "N m", "N/", "/s", "*m", "m^", "m^99", "5", "mm^0.5", "m**2", "1/1"],
)
def test_what_is_no_unit_is_refused(text: str) -> None:
    assert parse_unit(text) is None


@given(texts)
def test_symbol_is_a_unit_of_the_same_dimension_and_factor_one(
    factors: list[tuple[str, str, int]],
) -> None:
    unit = parse_unit(spell(factors))
    assume(unit is not None)  # the exponents of one base add up to more than a unit may have
    assert unit is not None
    again = parse_unit(unit.symbol)
    assert again is not None
    assert (again.factor, again.dimension, again.symbol) == (1, unit.dimension, unit.symbol)


@given(dimensions, dimensions)
def test_si_symbol_reads_back(one: units.Dimension, two: units.Dimension) -> None:
    for dimension in (one, multiply(one, two), divide(one, two), power(one, Fraction(1, 2))):
        unit = parse_unit(si_symbol(dimension))
        assert unit is not None
        assert (unit.factor, unit.dimension) == (1, dimension)


def test_dimension_arithmetic_agrees_with_units() -> None:
    newton, metre, joule = (parse_unit(text) for text in ("N", "m", "J"))
    assert newton is not None and metre is not None and joule is not None
    assert multiply(newton.dimension, metre.dimension) == joule.dimension
    assert divide(joule.dimension, metre.dimension) == newton.dimension
    assert power(power(metre.dimension, 2), Fraction(1, 2)) == metre.dimension


def test_dimensions_are_described_in_words() -> None:
    assert describe_dimension((0, 1, 0, 0, 0, 0, 0)) == "a length (m)"
    assert describe_dimension((0, 2, 0, 0, 0, 0, 0)) == "an area (m^2)"
    assert describe_dimension(DIMENSIONLESS) == "a plain number"
    assert describe_dimension((1, 0, -5, 0, 0, 0, 0)) == "a quantity in kg/s^5"


@pytest.mark.parametrize(
    ("text", "described"),
    [
        ("V*s/rad", "a quantity in V*s/rad"),
        ("kN*m/rad", "a quantity in N*m/rad"),
        ("rpm", "an angular velocity (rad/s)"),
        ("deg", "an angle (rad)"),
        ("kN*m", "a torque or energy (N*m)"),
        ("kg/s^5", "a quantity in kg/s^5"),
    ],
)
def test_a_unit_is_described_in_the_words_in_which_it_was_written(text, described) -> None:
    unit = parse_unit(text)
    assert unit is not None
    assert describe_dimension(Written(unit.dimension, text)) == described


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("KN", "kN"),
        ("Kn", "kN"),
        ("KWh", "kWh"),
        ("lpm", "L/min"),
        ("cSt", "mm^2/s"),
        ("kt", "knot"),
        ("Nm", "N*m"),
        ("kNm", "kN*m"),
        ("kN.m", "kN*m"),
        ("Kg", "kg"),
        ("PA", "Pa"),
        ("meters", "m"),
        ("sec", "s"),
        ("°", "deg"),
        ("µm", "um"),
        ("m/s2", "m/s^2"),
        ("m/s²", "m/s^2"),
        ("Ω", "ohm"),
        ("knots", "knot"),
        ("furlong", ""),
        ("m", ""),
    ],
)
def test_near_misses_are_corrected(wrong: str, right: str) -> None:
    assert suggest_unit(wrong) == right


@pytest.mark.parametrize(
    ("unit", "conversion"),
    [
        ("degC", "a unit with an offset is not supported: add 273.15 and write `K`"),
        ("Celsius", "a unit with an offset is not supported: add 273.15 and write `K`"),
        (
            "degF",
            "a unit with an offset is not supported: add 459.67, multiply by 5/9 and write `K`",
        ),
        ("psi", "multiply by 6.8947573 and write `kPa`"),
        ("gpm", "multiply by 3.785411784 and write `L/min`"),
        ("dB", "write the ratio itself, `10^(level/20)` for a level in dB"),
        ("ft", "multiply by 0.3048 and write `m`"),
        ("deg", ""),
        ("C", ""),
    ],
)
def test_units_with_a_factor_or_an_offset_are_converted(unit: str, conversion: str) -> None:
    assert suggest_conversion(unit) == conversion
    assert suggest_unit(unit) == ""


def test_a_difference_of_temperatures_has_no_offset() -> None:
    assert suggest_unit("W/degC") == "W/K"


@pytest.mark.parametrize(
    ("text", "product"),
    [("V*gain", "V * gain"), ("m/s*gain/r", "m/s * gain/r"), ("V*2", "V * 2"), ("V*other", "")],
)
def test_a_value_behind_a_unit_is_set_apart(text: str, product: str) -> None:
    assert spaced_product(text, {"gain", "r"}.__contains__) == product


def test_a_name_may_be_a_unit_word() -> None:
    """D13: a unit stands only behind a number and one blank, so `3 m` and `3*m` differ."""
    model = bgc.compile(MODELS / "unit_words.bg")
    result = model.simulate()
    np.testing.assert_allclose(result["cart.f"][-1], 1.5 * (1 - np.exp(-2)), rtol=1e-6)
    assert result["way"][-1] == 3.0
    assert result["later"][-1] == 7200.005
    assert result["product"][-1] == 6.0
