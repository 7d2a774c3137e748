"""Roots of polynomials in one letter: in closed form where that is short, and as numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from math import gcd

import sympy
from sympy.polys.rings import PolyElement

from bgc.record_class import dataclass
from bgc.symbolic.factors import divided
from bgc.symbolic.quotients import Field
from bgc.symbolic.ratios import Ratio, by_powers, lowest

_FACTORED = 300  # terms of a polynomial that is still searched for factors
_DIGITS = 15


@dataclass(frozen=True, slots=True)
class Roots:
    """The roots of one irreducible factor, each of which counts `count` times.

    `pairs` are their formulas as `centre +- offset`, or `centre` alone where the offset is None;
    without formulas (a factor of degree three or more that is not one of degree two in s^2) it is
    None.
    """

    factor: PolyElement
    count: int
    pairs: tuple[tuple[sympy.Expr, sympy.Expr | None], ...] | None

    @property
    def closed(self) -> tuple[sympy.Expr, ...] | None:
        """The formulas of the single roots."""
        if self.pairs is None:
            return None
        return tuple(
            root
            for centre, offset in self.pairs
            for root in ((centre,) if offset is None else (centre + offset, centre - offset))
        )


def factored(ratio: Ratio) -> Ratio:
    """The same function with its factors in letter 0 split into irreducible ones."""
    above, below = (
        [part for p in side for part in _split(p)] for side in (ratio.above, ratio.below)
    )
    return lowest(ratio.field, above, below) if not ratio.is_zero else ratio


def _split(polynomial: PolyElement) -> list[PolyElement]:
    parts = _irreducible(polynomial, 0) if len(polynomial) > 1 else []
    if len(parts) < 2 and all(count == 1 for _, count in parts):
        return [polynomial]
    found = [part for part, count in parts for _ in range(count)]
    for part in found:
        polynomial = divided(polynomial, part)
    return [polynomial, *found]


def roots_of(field: Field, factors: Sequence[PolyElement], letter: int) -> list[Roots]:
    """The roots of a product of polynomials in one letter, factor by factor; low degrees first."""
    found: Counter[PolyElement] = Counter()
    for factor in factors:
        powers = min(e[letter] for e in factor)
        if powers:  # a product of letters: a root at zero
            found[field.ring.gens[letter]] += powers
        rest = field.ring.from_dict(
            {(*e[:letter], e[letter] - powers, *e[letter + 1 :]): v for e, v in factor.items()}
        )
        for part, count in _irreducible(rest, letter):
            found[part] += count
    ordered = sorted(found.items(), key=lambda item: item[0].degrees()[letter])
    return [Roots(p, count, _pairs(field, p, letter)) for p, count in ordered]


def _irreducible(polynomial: PolyElement, letter: int) -> list[tuple[PolyElement, int]]:
    """Factors that hold the letter. Long polynomials are taken for irreducible."""
    degree = polynomial.degrees()[letter]
    if degree == 0:
        return []
    if degree == 1 or len(polynomial) > _FACTORED or _is_irreducible(polynomial, letter):
        return [(polynomial, 1)]
    _, factors = polynomial.factor_list()
    return [(p, count) for p, count in factors if p.degrees()[letter] > 0]


def _is_irreducible(polynomial: PolyElement, letter: int) -> bool:
    """Prove irreducibility by integers for all other letters; False where that fails."""
    s = sympy.Dummy()
    for start in (2, 11):
        coefficients = []
        for part in by_powers(polynomial, letter):
            total = 0
            for exponents, value in part.items():
                term = int(value)
                for k, exponent in enumerate(exponents):
                    term *= sympy.prime(start + k) ** exponent
                total += term
            coefficients.append(total)
        if coefficients[0] and sympy.Poly(coefficients, s).is_irreducible:
            return True
    return False


def _pairs(
    field: Field, polynomial: PolyElement, letter: int
) -> tuple[tuple[sympy.Expr, sympy.Expr | None], ...] | None:
    """The roots of a polynomial of degree one or two in the letter or in its square."""
    coefficients = by_powers(polynomial, letter)
    degree = len(coefficients) - 1
    step = gcd(*(degree - k for k, c in enumerate(coefficients) if c))
    if step > 2 or degree // step > 2:
        return None
    centre, offset = _low_degree(field, coefficients[::step])
    if step == 1:
        return ((centre, offset),)
    squares = (centre,) if offset is None else (centre + offset, centre - offset)
    return tuple((sympy.S.Zero, _root_up_to_sign(square)) for square in squares)


def _root_up_to_sign(square: sympy.Expr) -> sympy.Expr:
    """One of the two roots of an expression; `i sqrt(k/m)` for that of `-k/m`."""
    if square.could_extract_minus_sign():
        return sympy.I * sympy.sqrt(-square)
    return sympy.sqrt(square)


def _low_degree(
    field: Field, coefficients: Sequence[PolyElement]
) -> tuple[sympy.Expr, sympy.Expr | None]:
    if len(coefficients) == 2:
        a, b = coefficients
        return lowest(field, [-b], [a]).expression, None
    a, b, c = coefficients
    centre = lowest(field, [-b], [2 * a]).expression
    ratio, inside = _under_root(field, b**2 - 4 * a * c, 2 * a)
    return centre, ratio * sympy.sqrt(inside)


def _under_root(
    field: Field, discriminant: PolyElement, below: PolyElement
) -> tuple[sympy.Expr, sympy.Expr]:
    """Write `sqrt(discriminant)/below` as a factor and a radicand.

    Squares of letters leave the root. Their sign is of no account: both signs of a root are roots.
    """
    ring = field.ring
    if not discriminant:
        return sympy.Integer(0), sympy.Integer(0)
    content = abs(int(discriminant.content()))
    number = sympy.integer_nthroot(_square_part(content), 2)[0]
    low = tuple(map(min, zip(*discriminant, strict=True)))
    outside = ring.from_dict({tuple(n // 2 for n in low): ring.domain(number)})
    inside = discriminant.exquo(outside**2)
    ratio = lowest(field, [outside], [below]).expression
    return ratio, sympy.factor_terms(field.expression(inside))


def _square_part(number: int) -> int:
    """The largest square of small primes that divides a number."""
    square = 1
    for prime, exponent in sympy.factorint(number, limit=1000).items():
        square *= prime ** (exponent - exponent % 2)
    return square


def numeric_roots(coefficients: Sequence[Fraction]) -> list[complex]:
    """The roots of a polynomial with exact coefficients, highest power first.

    Multiple roots are found as such: the polynomial is split into square-free ones beforehand.
    """
    s = sympy.Dummy()
    rationals = [sympy.Rational(c.numerator, c.denominator) for c in coefficients]
    polynomial = sympy.Poly(rationals, s, domain=sympy.QQ)
    if polynomial.degree() < 1:
        return []
    found: list[complex] = []
    for factor, count in polynomial.sqf_list()[1]:
        roots = [complex(root) for root in factor.nroots(n=_DIGITS, maxsteps=200)]
        found += [root for root in roots for _ in range(count)]
    return sorted(found, key=lambda root: (root.real, root.imag))
