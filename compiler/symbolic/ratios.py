"""Rational functions as products of factors over products of factors, in lowest terms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction

import sympy
from sympy.polys.rings import PolyElement

from bgc.record_class import dataclass
from bgc.symbolic.factors import common_factor, divided, split
from bgc.symbolic.quotients import Field


@dataclass(frozen=True, slots=True)
class Ratio:
    """The product of `above` over that of `below`, polynomials of one field.

    No factor above shares one with a factor below. The first of each is a product of letters and
    an integer (the sign of all stands above); the others are primitive, with a positive leading
    coefficient, and no letter divides them.
    """

    field: Field
    above: tuple[PolyElement, ...]
    below: tuple[PolyElement, ...]

    @property
    def is_zero(self) -> bool:
        """Test whether the function is zero everywhere."""
        return not self.above[0]

    @property
    def letters(self) -> list[sympy.Expr]:
        """The letters that occur, functions of letters among them."""
        used = {
            letter
            for polynomial in (*self.above, *self.below)
            for exponents in polynomial
            for letter, exponent in zip(self.field.letters, exponents, strict=False)
            if exponent
        }
        return [letter for letter in self.field.letters if letter in used]

    @property
    def symbols(self) -> set[sympy.Symbol]:
        """The symbols that occur, in functions too."""
        return {symbol for letter in self.letters for symbol in letter.free_symbols}

    @property
    def expression(self) -> sympy.Expr:
        """The SymPy expression, factors multiplied out as little as they are here."""
        return self.numerator / self.denominator

    @property
    def numerator(self) -> sympy.Expr:
        """The numerator."""
        return _product(self.field, self.above)

    @property
    def denominator(self) -> sympy.Expr:
        """The denominator."""
        return _product(self.field, self.below)

    def at_zero(self, letter: int) -> Ratio | None:
        """The function with zero for a letter; None where that makes it infinite."""
        above, below = (
            [_without(p, letter) for p in factors] for factors in (self.above, self.below)
        )
        return None if not all(below) else lowest(self.field, above, below)

    def coefficients(
        self, letter: int, values: Mapping[sympy.Expr, Fraction]
    ) -> tuple[list[Fraction], list[Fraction]]:
        """The polynomials in one letter, highest power first, with numbers for the others."""
        return (
            _multiplied([evaluated(self.field, p, letter, values) for p in self.above]),
            _multiplied([evaluated(self.field, p, letter, values) for p in self.below]),
        )


def lowest(field: Field, above: Iterable[PolyElement], below: Iterable[PolyElement]) -> Ratio:
    """The ratio of two products, with every common factor of one above and one below cancelled."""
    tops, bottoms = list(above), list(below)
    one = field.ring.one
    if not all(tops):
        return Ratio(field, (field.ring.zero,), (one,))
    tops, bottoms = _without_known_sums(field, tops, bottoms)
    for i in range(len(tops)):
        for j in range(len(bottoms)):
            factor = common_factor(tops[i], bottoms[j], field.budget)
            if factor != one:
                tops[i], bottoms[j] = divided(tops[i], factor), divided(bottoms[j], factor)
    first, rest = _gathered(field, tops)
    last, others = _gathered(field, bottoms)
    if last.LC < 0:
        first, last = -first, -last
    return Ratio(field, (first, *rest), (last, *others))


def _without_known_sums(
    field: Field, above: Iterable[PolyElement], below: Iterable[PolyElement]
) -> tuple[list[PolyElement], list[PolyElement]]:
    """Two products without the sums of the field that divide both."""
    sides = []
    for factors in (above, below):
        known: Counter[PolyElement] = Counter()
        rest = []
        for factor in factors:
            sums, left = field.known_sums(factor)
            known.update(sums)
            rest.append(left)
        sides.append((known, rest))
    (tops, top_rest), (bottoms, bottom_rest) = sides
    return (
        [*top_rest, *(tops - bottoms).elements()],
        [*bottom_rest, *(bottoms - tops).elements()],
    )


def _gathered(
    field: Field, factors: Iterable[PolyElement]
) -> tuple[PolyElement, list[PolyElement]]:
    """Collect the integers and letters that divide some factors; return the other parts too."""
    simple, rest = field.ring.one, []
    for factor in factors:
        part, inner = split(factor)
        simple *= part
        if len(inner) > 1:
            rest.append(inner)
    return simple, rest


def _product(field: Field, factors: Sequence[PolyElement]) -> sympy.Expr:
    first, *rest = factors
    powers = Counter(rest)
    return sympy.Mul(
        field.expression(first), *(field.expression(p) ** count for p, count in powers.items())
    )


def _without(polynomial: PolyElement, letter: int) -> PolyElement:
    """The polynomial with zero for a letter."""
    return polynomial.ring.from_dict({e: v for e, v in polynomial.items() if not e[letter]})


def by_powers(polynomial: PolyElement, letter: int) -> list[PolyElement]:
    """The coefficients of a polynomial in one letter, highest power first."""
    degree = max((exponents[letter] for exponents in polynomial), default=0)
    terms: list[dict[tuple[int, ...], int]] = [{} for _ in range(degree + 1)]
    for exponents, value in polynomial.items():
        others = (*exponents[:letter], 0, *exponents[letter + 1 :])
        terms[degree - exponents[letter]][others] = value
    return [polynomial.ring.from_dict(found) for found in terms]


def evaluated(
    field: Field, polynomial: PolyElement, letter: int, values: Mapping[sympy.Expr, Fraction]
) -> list[Fraction]:
    """A polynomial in one letter, highest power first, with numbers for all others."""
    return [_number(field, p, values) for p in by_powers(polynomial, letter)]


def _number(
    field: Field, polynomial: PolyElement, values: Mapping[sympy.Expr, Fraction]
) -> Fraction:
    total = Fraction(0)
    for exponents, value in polynomial.items():
        term = Fraction(int(value))
        for letter, exponent in zip(field.letters, exponents, strict=False):
            if exponent:
                term *= values[letter] ** exponent
        total += term
    return total


def _multiplied(factors: Sequence[Sequence[Fraction]]) -> list[Fraction]:
    whole = [Fraction(1)]
    for factor in factors:
        product = [Fraction(0)] * (len(whole) + len(factor) - 1)
        for i, a in enumerate(whole):
            for j, b in enumerate(factor):
                product[i + j] += a * b
        whole = product
    return whole
