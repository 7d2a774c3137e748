"""Units as written after a number or a colon: exact factors to SI, and dimensions.

pint is not used, since its import takes about 0.24 s, most of the time of a warm run, and since a
unit has one spelling here. A test compares every unit with pint.

Two units have a second spelling, which standards allow: `L` and `l`, `knot` and `kn`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

from bgc.algebra.angles import PI
from bgc.grammar.unit_spelling import GROUPED, plain, ungrouped
from bgc.record_class import dataclass, field
from bgc.values.shown_units import Shown

Exponent: TypeAlias = int | Fraction
Dimension: TypeAlias = tuple[Exponent, ...]
"""Exponents of kg, m, s, A, K, mol, cd."""

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd")
DIMENSIONLESS: Dimension = (0,) * len(BASE_UNITS)


class Written(tuple[Exponent, ...]):
    """A dimension that remembers the unit in which it was written, `text`.

    It equals the plain dimension, and units are compared without it. A value keeps it through
    names, signs, sums and functions whose result has the unit of their argument; products and
    powers have a plain dimension.
    """

    text: str

    def __new__(cls, dimension: Dimension, text: str) -> Written:
        """Attach a unit to its dimension."""
        made = super().__new__(cls, dimension)
        made.text = text
        return made


def written_text(dimension: Dimension | None) -> str:
    """The unit in which a dimension was written; empty where that is unknown."""
    return dimension.text if isinstance(dimension, Written) else ""


def times_seconds(dimension: Dimension, exponent: int) -> Dimension:
    """The dimension of a rate (-1) or of an integral over time (1), in the same words.

    `rad` becomes `rad/s`, `kN*m` becomes `N*m*s`.
    """
    plain = multiply(dimension, power((0, 0, 1, 0, 0, 0, 0), exponent))
    unit = parse_unit(written_text(dimension))
    if unit is None:
        return plain
    spelled = parse_unit(f"{unit.symbol}*s" if exponent > 0 else f"{unit.symbol}/s")
    return plain if spelled is None else Written(plain, spelled.symbol)


def preferred(one: Dimension | None, two: Dimension | None) -> Dimension | None:
    """Choose the more specific of two equal dimensions, or the known one."""
    if one is None or (isinstance(two, Written) and not isinstance(one, Written)):
        return one if two is None else two
    return one


@dataclass(frozen=True, slots=True)
class Unit:
    """`factor` times the coherent SI unit of `dimension`.

    `symbol` is that SI unit in the words of the unit as written: `N*m`, not `J`, for `kN*m`, and
    `rad/s` for `rpm`.
    """

    factor: Fraction
    dimension: Dimension
    symbol: str = field(compare=False)


# --- dimensions -------------------------------------------------------------------------


@lru_cache(maxsize=4096)
def multiply(left: Dimension, right: Dimension) -> Dimension:
    """The dimension of a product."""
    return tuple(_plain(x + y) for x, y in zip(left, right, strict=True))


@lru_cache(maxsize=4096)
def divide(left: Dimension, right: Dimension) -> Dimension:
    """The dimension of a quotient."""
    return tuple(_plain(x - y) for x, y in zip(left, right, strict=True))


def power(dimension: Dimension, exponent: Exponent) -> Dimension:
    """The dimension of a power."""
    return tuple(_plain(x * exponent) for x in dimension)


def _plain(exponent: Exponent) -> Exponent:
    """Convert a whole exponent to an int."""
    return exponent.numerator if exponent.denominator == 1 else exponent


# --- the table --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Word:
    """One unit word: its factor, dimension, and the SI words it is a multiple of."""

    factor: Fraction
    dimension: Dimension
    si: tuple[tuple[str, int], ...]


def _words(*rows: tuple[str, Fraction | int, Dimension, str]) -> dict[str, _Word]:
    """Make a table by word from rows (word, factor, dimension, SI words with exponents)."""
    return {
        word: _Word(
            Fraction(factor),
            dimension,
            tuple((part, int(own or 1)) for part, own in re.findall(r"([A-Za-z]+)(-?\d)?", si)),
        )
        for word, factor, dimension, si in rows
    }


PREFIXES: Mapping[str, Fraction] = {
    "p": Fraction(1, 10**12),
    "n": Fraction(1, 10**9),
    "u": Fraction(1, 10**6),
    "m": Fraction(1, 10**3),
    "c": Fraction(1, 10**2),
    "d": Fraction(1, 10),
    "h": Fraction(10**2),
    "k": Fraction(10**3),
    "M": Fraction(10**6),
    "G": Fraction(10**9),
    "T": Fraction(10**12),
}

_WITH_PREFIX: Mapping[str, _Word] = _words(
    ("m", 1, (0, 1, 0, 0, 0, 0, 0), "m"),
    ("g", Fraction(1, 1000), (1, 0, 0, 0, 0, 0, 0), "kg"),
    ("s", 1, (0, 0, 1, 0, 0, 0, 0), "s"),
    ("A", 1, (0, 0, 0, 1, 0, 0, 0), "A"),
    ("K", 1, (0, 0, 0, 0, 1, 0, 0), "K"),
    ("mol", 1, (0, 0, 0, 0, 0, 1, 0), "mol"),
    ("cd", 1, (0, 0, 0, 0, 0, 0, 1), "cd"),
    ("rad", 1, DIMENSIONLESS, "rad"),
    ("Hz", 1, (0, 0, -1, 0, 0, 0, 0), "Hz"),
    ("N", 1, (1, 1, -2, 0, 0, 0, 0), "N"),
    ("Pa", 1, (1, -1, -2, 0, 0, 0, 0), "Pa"),
    ("bar", 100_000, (1, -1, -2, 0, 0, 0, 0), "Pa"),
    ("J", 1, (1, 2, -2, 0, 0, 0, 0), "J"),
    ("Wh", 3600, (1, 2, -2, 0, 0, 0, 0), "J"),
    ("W", 1, (1, 2, -3, 0, 0, 0, 0), "W"),
    ("C", 1, (0, 0, 1, 1, 0, 0, 0), "C"),
    ("V", 1, (1, 2, -3, -1, 0, 0, 0), "V"),
    ("F", 1, (-1, -2, 4, 2, 0, 0, 0), "F"),
    ("ohm", 1, (1, 2, -3, -2, 0, 0, 0), "ohm"),
    ("S", 1, (-1, -2, 3, 2, 0, 0, 0), "S"),
    ("Wb", 1, (1, 2, -2, -1, 0, 0, 0), "Wb"),
    ("T", 1, (1, 0, -2, -1, 0, 0, 0), "T"),
    ("H", 1, (1, 2, -2, -2, 0, 0, 0), "H"),
    ("L", Fraction(1, 1000), (0, 3, 0, 0, 0, 0, 0), "m3"),
    ("l", Fraction(1, 1000), (0, 3, 0, 0, 0, 0, 0), "m3"),
)

_WITHOUT_PREFIX: Mapping[str, _Word] = _words(
    ("t", 1000, (1, 0, 0, 0, 0, 0, 0), "kg"),
    ("min", 60, (0, 0, 1, 0, 0, 0, 0), "s"),
    ("h", 3600, (0, 0, 1, 0, 0, 0, 0), "s"),
    ("day", 86_400, (0, 0, 1, 0, 0, 0, 0), "s"),
    ("deg", PI / 180, DIMENSIONLESS, "rad"),
    ("rev", 2 * PI, DIMENSIONLESS, "rad"),
    ("rpm", PI / 30, (0, 0, -1, 0, 0, 0, 0), "rad s-1"),
    ("knot", Fraction(1852, 3600), (0, 1, -1, 0, 0, 0, 0), "m s-1"),
    ("kn", Fraction(1852, 3600), (0, 1, -1, 0, 0, 0, 0), "m s-1"),
    ("nmi", 1852, (0, 1, 0, 0, 0, 0, 0), "m"),
)


def unit_table() -> dict[str, bool]:
    """Return all unit words, those of SI first, and whether each takes a prefix."""
    return dict.fromkeys(_WITH_PREFIX, True) | dict.fromkeys(_WITHOUT_PREFIX, False)


def _find_word(text: str) -> _Word | None:
    """Find a unit word in the table, with or without a prefix."""
    word = _WITHOUT_PREFIX.get(text) or _WITH_PREFIX.get(text)
    if word is not None:
        return word
    prefix, word = PREFIXES.get(text[:1]), _WITH_PREFIX.get(text[1:])
    if prefix is None or word is None:
        return None
    return _Word(prefix * word.factor, word.dimension, word.si)


# --- reading ----------------------------------------------------------------------------

_FACTOR = re.compile(r"([A-Za-z]+)(?:\^(-?\d{1,2}(?:\.\d{1,3})?))?")
_MAX_EXPONENT = 24
_MOST_CHARACTERS = 200  # characters of a unit


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> Unit | None:
    """Parse a unit as `kg*m/s`, `s^-1` or `kN*m`; None if the text is not a unit.

    Products and quotients are grouped from the left: `J/kg*K` is J*K/kg. A unit may begin with 1,
    as `1/s` does.
    """
    if len(text) > _MOST_CHARACTERS:
        return None
    factor, dimension = Fraction(1), DIMENSIONLESS
    spelled: dict[str, Exponent] = {}
    operators = ["*", *re.findall(r"[*/]", text)]
    pieces = re.split(r"[*/]", text)
    if pieces[0] == "1":
        operators, pieces = operators[1:], pieces[1:]
    for operator, piece in zip(operators, pieces, strict=True):
        match = _FACTOR.fullmatch(piece)
        word = _find_word(match[1]) if match else None
        if match is None or word is None:
            return None
        exponent = _plain(Fraction(match[2] or 1) * (1 if operator == "*" else -1))
        whole = exponent.denominator == 1
        if abs(Fraction(exponent)) > _MAX_EXPONENT or not (whole or word.factor == 1):
            return None
        if word.factor != 1:
            factor *= word.factor ** int(exponent)
        dimension = multiply(dimension, power(word.dimension, exponent))
        for part, own in word.si:
            spelled[part] = spelled.get(part, 0) + own * exponent
    if any(abs(Fraction(exponent)) > _MAX_EXPONENT for exponent in spelled.values()):
        return None  # as one factor would be: the symbol has to be a unit itself
    return Unit(factor, dimension, _spell(spelled.items()))


# --- printing ---------------------------------------------------------------------------


def _spell(factors: Iterable[tuple[str, Exponent]]) -> str:
    """Spell a unit from words and exponents: `kg*m^2/s^3`, `1/s` without a numerator, or `1`."""
    above, below = [], ""
    for word, exponent in factors:
        size = abs(Fraction(exponent))
        raised = word if size == 1 else f"{word}^{float(size):g}"
        if exponent > 0:
            above.append(raised)
        elif exponent < 0:
            below += "/" + raised
    return ("*".join(above) or "1") + below


_NAMED = {
    unit.dimension: (unit.symbol, quantity)
    for unit, quantity in (
        (parse_unit(symbol), quantity)
        for symbol, quantity in (
            ("1", "plain number"),
            ("kg", "mass"),
            ("m", "length"),
            ("s", "time"),
            ("A", "current"),
            ("K", "temperature"),
            ("mol", "amount of substance"),
            ("cd", "luminous intensity"),
            ("m^2", "area"),
            ("m^3", "volume"),
            ("1/m", "curvature"),
            ("1/s", "rate"),
            ("1/s^2", "angular acceleration"),
            ("m/s", "velocity"),
            ("m/s^2", "acceleration"),
            ("m^3/s", "volume flow"),
            ("kg/s", "mass flow"),
            ("kg/m^3", "density"),
            ("kg/m", "mass per length"),
            ("kg*m", "first moment of mass"),
            ("kg*m^2", "moment of inertia"),
            ("N", "force"),
            ("N*s", "momentum"),
            ("N*m*s", "angular momentum"),
            ("N/m", "stiffness"),
            ("m/N", "compliance"),
            ("N*s/m", "damping"),
            ("Pa", "pressure"),
            ("Pa*s", "viscosity"),
            ("Pa*s/m^3", "hydraulic resistance"),
            ("m^3/Pa", "hydraulic compliance"),
            ("J", "torque or energy"),
            ("W", "power"),
            ("C", "charge"),
            ("V", "voltage"),
            ("ohm", "resistance"),
            ("S", "conductance"),
            ("F", "capacitance"),
            ("H", "inductance"),
            ("Wb", "magnetic flux"),
            ("T", "magnetic flux density"),
            ("J/K", "heat capacity"),
            ("W/K", "thermal conductance"),
            ("K/W", "thermal resistance"),
            ("N*m^2", "bending stiffness"),
        )
    )
    if unit is not None
}


_ANGULAR: Mapping[str, str] = {
    "rad": "an angle",
    "rad/s": "an angular velocity",
    "rad/s^2": "an angular acceleration",
}


def si_symbol(dimension: Dimension) -> str:
    """The SI unit of a dimension for tables: `N`, `m/s`, `kg*m/s^3`, or `1`.

    It is in the words of the unit as written: `N*m`, not `J`, of a dimension written as `kN*m`.
    """
    unit = parse_unit(written_text(dimension))
    if unit is not None:
        return unit.symbol
    named = _NAMED.get(dimension)
    return named[0] if named else _spell(zip(BASE_UNITS, dimension, strict=True))


def si_text(dimension: Dimension | None) -> str:
    """The SI unit of a dimension; empty where the dimension is unknown."""
    return si_symbol(dimension) if dimension is not None else ""


def shown_of(dimension: Dimension | None) -> Shown | None:
    """The unit as written, in which a value is shown; None where that is the SI unit."""
    text = written_text(dimension)
    unit = parse_unit(text)
    return None if unit is None or unit.factor == 1 else Shown(text, float(unit.factor))


def describe_dimension(dimension: Dimension) -> str:
    """Describe a dimension in messages: `a length (m)`, `a plain number`.

    The unit is in the words in which it was written. Radians tell quantities of one dimension apart
    and have names of their own: `V*s/rad` is no magnetic flux, `N*m/rad` no energy.
    """
    symbol, quantity = _NAMED.get(dimension, (si_symbol(dimension), ""))
    unit = parse_unit(written_text(dimension))
    if unit is not None and "rad" in unit.symbol:
        named = _ANGULAR.get(unit.symbol)
        return f"{named} ({unit.symbol})" if named else f"a quantity in {unit.symbol}"
    if dimension == DIMENSIONLESS:
        return "a plain number"
    if not quantity:
        return f"a quantity in {symbol}"
    article = "an" if quantity[0] in "aeiou" else "a"
    return f"{article} {quantity} ({symbol if unit is None else unit.symbol})"


# --- suggestions ------------------------------------------------------------------------

_MEANT: Mapping[str, str] = {
    "meter": "m", "metre": "m", "kilometer": "km", "kilometre": "km", "millimeter": "mm",
    "millimetre": "mm", "centimeter": "cm", "centimetre": "cm", "gram": "g", "kilogram": "kg",
    "kilo": "kg", "ton": "t", "tonne": "t", "second": "s", "sec": "s", "millisecond": "ms",
    "msec": "ms", "minute": "min", "hour": "h", "hr": "h", "hrs": "h", "d": "day",
    "newton": "N", "kilonewton": "kN", "joule": "J", "watt": "W", "kilowatt": "kW",
    "pascal": "Pa", "volt": "V", "ampere": "A", "amp": "A", "ohms": "ohm", "kiloohm": "kohm",
    "farad": "F", "henry": "H", "coulomb": "C", "kelvin": "K", "celsius": "K", "degc": "K",
    "hertz": "Hz", "radian": "rad", "degree": "deg", "revolution": "rev", "turn": "rev",
    "rps": "rev/s", "liter": "L", "litre": "L", "knots": "knot", "kt": "knot",
    "kts": "knot", "nm": "N*m", "kn": "kN", "knm": "kN*m", "mnm": "MN*m", "ns": "N*s",
    "tesla": "T", "weber": "Wb", "siemens": "S", "mho": "S", "kmh": "km/h", "kph": "km/h",
    "mps": "m/s", "rads": "rad/s", "cc": "cm^3", "lpm": "L/min", "cst": "mm^2/s", "cp": "mPa*s",
    "mpa": "MPa", "kwh": "kWh", "mwh": "MWh", "nmile": "nmi",
}  # fmt: skip

_CONVERTED: Mapping[str, str] = {  # unsupported units, with the factor to a supported one
    "inch": "multiply by 25.4 and write `mm`",
    "inches": "multiply by 25.4 and write `mm`",
    "ft": "multiply by 0.3048 and write `m`",
    "feet": "multiply by 0.3048 and write `m`",
    "lb": "multiply by 0.45359237 and write `kg`",
    "lbs": "multiply by 0.45359237 and write `kg`",
    "lbf": "multiply by 4.4482216 and write `N`",
    "kgf": "multiply by 9.80665 and write `N`",
    "psi": "multiply by 6.8947573 and write `kPa`",
    "hp": "multiply by 745.69987 and write `W`",
    "ksi": "multiply by 6.8947573 and write `MPa`",
    "gpm": "multiply by 3.785411784 and write `L/min`",
    "gal": "multiply by 3.785411784 and write `L`",
    "atm": "multiply by 101.325 and write `kPa`",
    "mmhg": "multiply by 133.32239 and write `Pa`",
    "mph": "multiply by 0.44704 and write `m/s`",
    "grad": "multiply by 0.9 and write `deg`",
    "gon": "multiply by 0.9 and write `deg`",
    "mile": "multiply by 1609.344 and write `m`",
    "tonf": "multiply by 9.80665 and write `kN`",
    "db": "write the ratio itself, `10^(level/20)` for a level in dB",
}
_OFFSET: Mapping[str, str] = {
    "c": "add 273.15 and write `K`",
    "f": "add 459.67, multiply by 5/9 and write `K`",
}
_TEMPERATURE = re.compile(
    r"(?:deg_?|°\s*)(?:(c)(?:elsius)?|(f)(?:ahrenheit)?)|(c)elsius|(f)ahrenheit"
)


def suggest_conversion(text: str) -> str:
    """Give the conversion from a unit that is not supported, as a sentence; empty if unknown.

    A temperature with an offset (`degC`) has no equivalent unit, so `K` would be a wrong
    suggestion for it.
    """
    word = text.strip().casefold()
    temperature = _TEMPERATURE.fullmatch(word)
    if temperature is not None:
        scale = next(letter for letter in temperature.groups() if letter)
        return f"a unit with an offset is not supported: {_OFFSET[scale]}"
    return _CONVERTED.get(word, "")


def suggest_unit(text: str) -> str:
    """Suggest a unit for a misspelt one; an empty text if none is found.

    `KN` gives `kN`, `Nm` gives `N*m`, `meters` gives `m`, `kN.m` gives `kN*m`.
    """
    if suggest_conversion(text):
        return ""
    tidy = plain(text.strip().replace("°C", "K")).replace("**", "^").replace(".", "*")
    tidy = re.sub(r"\s+", "", tidy)
    tidy = re.sub(r"(?<=[A-Za-z])(-?\d)", r"^\1", tidy)
    corrected = re.sub(r"[A-Za-z]+", lambda match: _correct_word(match[0]), tidy)
    return corrected if corrected != text and parse_unit(corrected) is not None else ""


def spaced_product(text: str, is_value: Callable[[str], bool]) -> str:
    """Separate a unit from names of values: `V * gain` for `V*gain`, else an empty text."""
    for sign in re.finditer(r"[*/]", text):
        unit, rest = text[: sign.start()], text[sign.end() :]
        if parse_unit(unit) is not None and all(map(is_value, re.findall(r"[A-Za-z_]\w*", rest))):
            return f"{unit} {sign[0]} {rest}"
    return ""


def ungrouped_unit(text: str, start: int = 0) -> tuple[int, int, str] | None:
    """The unit with parentheses that holds the name at `start`: its place and its right spelling.

    `K` in `3 W/(K*s)` gives the place of `W/(K*s)` and `W/K/s`; None where the text is not a unit.
    """
    for found in GROUPED.finditer(text, text.rfind("\n", 0, start) + 1):
        if found.start() <= start < found.end():
            spelled = ungrouped(found)
            return (found.start(), found.end(), spelled) if parse_unit(spelled) else None
    return None


def _correct_word(word: str) -> str:
    if _find_word(word) is not None:
        return word
    folded = word.casefold()
    for spelling in (folded, folded.removesuffix("s")):
        if spelling in _MEANT:
            return _MEANT[spelling]
    cases = (
        word.capitalize(),
        word[:1].lower() + word[1:],
        word[:1].lower() + word[1:].capitalize(),
        word[:1] + word[1:].capitalize(),
        word.lower(),
        word.upper(),
    )
    cuts = ((word[:k], word[k:]) for k in range(1, len(word)))
    products = (f"{one}*{two}" for one, two in cuts if _find_word(one) and _find_word(two))
    known = (case for case in cases if _find_word(case) is not None)
    return next(known, None) or next(products, word)


def quotient_unit(above: str, below: str) -> str:
    """The SI unit of a quotient as people read it: `A/V`, `m/(N*s)`, nothing of a plain number."""
    if above == below or below in ("", "1"):
        return above if above != below and above != "1" else ""
    over, slash, under = above.partition("/")
    if slash and "/" not in under + below:
        return f"{over}/({under.strip('()')}*{below})"
    compound = any(sign in below for sign in "*/")
    return f"{above or '1'}/({below})" if compound else f"{above or '1'}/{below}"
