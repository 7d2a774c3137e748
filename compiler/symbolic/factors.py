"""Common factors of integer polynomials in many letters, few of which a factor holds.

SymPy's own algorithm evaluates all letters one inside the other, which takes time exponential in
their number. A common factor of polynomials that come from an engineering model holds few of them:
which ones is found first, from greatest common divisors in one letter modulo a large prime, with
random numbers for all others. A letter in which such an image has degree zero is proved to be in no
common factor, for the image of the factor divides the greatest common divisor of the images; a bad
random number can only cost time. What remains is the greatest common divisor of the coefficients
by the other letters, polynomials in these few (Brown 1971 evaluates in the same way).
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import TypeAlias

from sympy import ZZ
from sympy.polys.galoistools import gf_gcd, gf_rem, gf_strip, gf_trunc
from sympy.polys.polyerrors import ExactQuotientFailed, HeuristicGCDFailed
from sympy.polys.polytools import Poly
from sympy.polys.rings import PolyElement, PolyRing

from bgc.algebra.fingerprint import PRIME
from bgc.symbolic.determinants import Budget

Exponents: TypeAlias = tuple[int, ...]


class Trials:
    """Trial division of polynomials of one ring, by their images in one letter modulo a prime."""

    def __init__(self, ring: PolyRing) -> None:
        rng = random.Random(1)
        self._points = [rng.randrange(2, PRIME) for _ in range(ring.ngens)]
        self._powers: list[list[int]] = [[1] for _ in range(ring.ngens)]

    def divided_out(
        self, polynomial: PolyElement, divisor: PolyElement, most: int | None = None
    ) -> tuple[PolyElement, int]:
        """A polynomial without the powers of a divisor, up to `most`, and how many these are."""
        count = 0
        while count != most and self._may_divide(divisor, polynomial):
            try:
                polynomial = divided(polynomial, divisor)
            except ExactQuotientFailed:
                break
            count += 1
        return polynomial, count

    def _may_divide(self, divisor: PolyElement, polynomial: PolyElement) -> bool:
        """Test divisibility of the images; a negative answer is proved."""
        degrees, others = divisor.degrees(), polynomial.degrees()
        if len(polynomial) < 2 or any(a > b for a, b in zip(degrees, others, strict=True)):
            return False
        letter = min((d, k) for k, d in enumerate(degrees) if d > 0)[1]
        return not gf_rem(self.image(polynomial, letter), self.image(divisor, letter), PRIME, ZZ)

    def shared_letters(self, first: PolyElement, second: PolyElement) -> list[int]:
        """The letters that a common factor may hold; it is proved to hold no others."""
        degrees = first.degrees(), second.degrees()
        found = []
        for k, pair in enumerate(zip(*degrees, strict=True)):
            if min(pair) > 0:
                images = self.image(first, k), self.image(second, k)
                dropped = any(len(i) <= d for i, d in zip(images, pair, strict=True))
                if dropped or len(gf_gcd(*images, PRIME, ZZ)) > 1:
                    found.append(k)
        return found

    def image(self, polynomial: PolyElement, letter: int) -> list[int]:
        """The polynomial in one letter that numbers for the others leave, highest power first."""
        degree = max(exponents[letter] for exponents in polynomial)
        coefficients = [0] * (degree + 1)
        for exponents, value in polynomial.items():
            product = int(value)
            for k, exponent in enumerate(exponents):
                if exponent and k != letter:
                    product = product * self._power(k, exponent) % PRIME
            coefficients[degree - exponents[letter]] += product
        return list(gf_strip(gf_trunc(coefficients, PRIME)))

    def _power(self, letter: int, exponent: int) -> int:
        row = self._powers[letter]
        while len(row) <= exponent:
            row.append(row[-1] * self._points[letter] % PRIME)
        return row[exponent]


def common_factor(
    first: PolyElement, second: PolyElement, budget: Budget | None = None
) -> PolyElement:
    """The greatest common divisor of two polynomials of one ring, with its integer content."""
    ring = first.ring
    if not first or not second:
        return first or second
    number = math.gcd(*map(int, first.values()), *map(int, second.values()))
    lowest = _lowest(first), _lowest(second)
    factor = ring.from_dict({tuple(map(min, *lowest)): ZZ(number)})
    if len(first) == 1 or len(second) == 1:
        return factor
    a, b = (_lowered(p, low) for p, low in zip((first, second), lowest, strict=True))
    trials = Trials(ring)
    letters = trials.shared_letters(a, b)
    if not letters:
        return factor
    for divisor, other in ((a, b), (b, a)):
        primitive = divisor.primitive()[1]
        if trials.divided_out(other.primitive()[1], primitive, 1)[1]:
            return factor * primitive
    return factor * _factor_in((a, b), letters, budget)


def divided(polynomial: PolyElement, factor: PolyElement) -> PolyElement:
    """The exact quotient by a factor, coefficient by coefficient of the letters it lacks.

    Raises
    ------
    ExactQuotientFailed
        The factor does not divide the polynomial.
    """
    ring = polynomial.ring
    if factor == ring.one:
        return polynomial
    if len(factor) == 1:
        ((low, number),) = factor.items()
        return ring.from_dict({_minus(e, low): value // number for e, value in polynomial.items()})
    letters = [k for k, degree in enumerate(factor.degrees()) if degree > 0]
    inner = _ring_of(ring, letters)
    (divisor,) = _by_other_letters(factor, letters, inner).values()
    quotient = {}
    for others, coefficient in _by_other_letters(polynomial, letters, inner).items():
        for exponents, value in coefficient.exquo(divisor).items():
            quotient[_placed(exponents, letters, others)] = value
    return ring.from_dict(quotient)


def split(polynomial: PolyElement) -> tuple[PolyElement, PolyElement]:
    """Split off the sign, the integer and the letters that divide a polynomial, as one term."""
    number = ZZ(math.gcd(*map(int, polynomial.values())))
    simple = polynomial.ring.from_dict(
        {_lowest(polynomial): -number if polynomial.LC < 0 else number}
    )
    return simple, divided(polynomial, simple)


def _lowest(polynomial: PolyElement) -> Exponents:
    """The exponents of the largest product of letters that divides a polynomial."""
    return tuple(map(min, zip(*polynomial, strict=True)))


def _lowered(polynomial: PolyElement, low: Exponents) -> PolyElement:
    if not any(low):
        return polynomial
    return polynomial.ring.from_dict({_minus(e, low): value for e, value in polynomial.items()})


def _minus(exponents: Exponents, low: Exponents) -> Exponents:
    return tuple(a - b for a, b in zip(exponents, low, strict=True))


def _factor_in(
    pair: Sequence[PolyElement], letters: Sequence[int], budget: Budget | None
) -> PolyElement:
    """The common factor, primitive, which holds some given letters only."""
    ring = pair[0].ring
    inner = _ring_of(ring, letters)
    coefficients = [c for p in pair for c in _by_other_letters(p, letters, inner).values()]
    factor = inner.zero
    for coefficient in sorted(coefficients, key=len):
        if budget is not None:
            budget.spend(_EVALUATION * (len(factor) + len(coefficient)) * 2 ** len(letters))
        factor = _small_gcd(factor, coefficient)
        if factor.is_ground:
            return ring.one
    zeros = (0,) * ring.ngens
    terms = factor.primitive()[1].items()
    return ring.from_dict({_placed(e, letters, zeros): value for e, value in terms})


_EVALUATION = 8  # products of terms that take as long as SymPy takes for a term and a letter


def _small_gcd(first: PolyElement, second: PolyElement) -> PolyElement:
    """SymPy's greatest common divisor of two polynomials in few letters."""
    try:
        return first.gcd(second)
    except HeuristicGCDFailed:
        ring = first.ring
        a, b = (Poly(p.as_expr(), *ring.symbols, domain=ZZ) for p in (first, second))
        return ring.from_dict(a.gcd(b).as_dict())


def _ring_of(ring: PolyRing, letters: Sequence[int]) -> PolyRing:
    return ring.clone(symbols=tuple(ring.symbols[k] for k in letters))


def _placed(exponents: Exponents, letters: Sequence[int], others: Exponents) -> Exponents:
    """Exponents of some letters among those of all others."""
    whole = list(others)
    for k, exponent in zip(letters, exponents, strict=True):
        whole[k] = exponent
    return tuple(whole)


def _by_other_letters(
    polynomial: PolyElement, letters: Sequence[int], inner: PolyRing
) -> dict[Exponents, PolyElement]:
    """The coefficients, polynomials in some letters, by the exponents of all others."""
    chosen = set(letters)
    found: dict[Exponents, dict[Exponents, int]] = {}
    for exponents, value in polynomial.items():
        others = tuple(0 if k in chosen else e for k, e in enumerate(exponents))
        within = tuple(exponents[k] for k in letters)
        found.setdefault(others, {})[within] = value
    return {others: inner.from_dict(terms) for others, terms in found.items()}
