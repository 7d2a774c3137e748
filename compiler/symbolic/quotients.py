"""Quotients of integer polynomials for SymPy expressions.

A part that is not a sum, product or integer power (a cosine, a root, a choice) is one more letter,
so all rational structure of an expression is handled exactly.

Denominators are kept as products. A model divides by few different sums (a reduced mass, the pivot
of an algebraic loop), each many times: a common denominator of two quotients then needs no greatest
common divisor, and a sum is tried as a divisor of a numerator, which takes an image modulo a prime.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import reduce
from math import lcm

import sympy
from sympy import ZZ
from sympy.polys.orderings import lex
from sympy.polys.rings import PolyElement, PolyRing

from bgc.record_class import dataclass, field
from bgc.symbolic.determinants import Budget
from bgc.symbolic.factors import Trials, common_factor, divided, split


@dataclass(frozen=True, slots=True)
class Denominator:
    """The product of `simple`, one term with a positive integer, and of powers of sums."""

    simple: PolyElement
    sums: Mapping[PolyElement, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Quotient:
    """`above / below`; no letter, and no sum that stands below, divides both."""

    above: PolyElement
    below: Denominator


class Field:
    """The quotients of polynomials in the letters of some expressions.

    Parameters
    ----------
    expressions
        The expressions to convert, in which all letters are found.
    first
        Symbols that come first among the letters, in this order.
    budget
        The work that all products together may take; None for no limit.
    """

    def __init__(
        self,
        expressions: Iterable[sympy.Expr],
        first: Iterable[sympy.Symbol],
        budget: Budget | None,
    ) -> None:
        self.budget = budget
        found = _letters(expressions)
        known = [symbol for symbol in first if symbol in found]
        others = sorted(found - set(known), key=sympy.default_sort_key)
        self.letters: tuple[sympy.Expr, ...] = (*known, *others)
        self.ring = PolyRing(sympy.symbols(f"x:{max(1, len(self.letters))}"), ZZ, lex)
        self.trials = Trials(self.ring)
        self._signs = [k for k, letter in enumerate(self.letters) if isinstance(letter, sympy.sign)]
        self._one = Denominator(self.ring.one)
        generators = zip(self.letters, self.ring.gens, strict=False)
        self._known = {letter: Quotient(x, self._one) for letter, x in generators}
        self.sums: dict[PolyElement, None] = {}  # all denominators found so far

    # --- conversion ---------------------------------------------------------------------------

    def of(self, expression: sympy.Expr) -> Quotient:
        """The quotient for an expression; each part of it is converted once.

        Raises
        ------
        ZeroDivisionError
            The expression divides by zero.
        """
        stack = [expression]
        while stack:
            top = stack[-1]
            missing = [part for part in _parts(top) if part not in self._known]
            if top in self._known or not missing:
                stack.pop()
                if top not in self._known:
                    self._known[top] = self._made(top)
            else:
                stack.extend(missing)
        return self._known[expression]

    def _made(self, expression: sympy.Expr) -> Quotient:
        if expression.is_Rational:
            below = Denominator(self.ring(int(expression.q)))
            return Quotient(self.ring(int(expression.p)), below)
        parts = [self._known[part] for part in _parts(expression)]
        if expression.is_Add:
            return self._simple_signs(self.sum(parts))
        if expression.is_Mul or isinstance(expression, sympy.Abs):
            return self._simple_signs(reduce(self.product, parts))
        (base,) = parts
        exponent = _exponent(expression)
        power = reduce(self.product, [base] * abs(exponent))
        return self._simple_signs(self._inverse(power) if exponent < 0 else power)

    def expression(self, polynomial: PolyElement) -> sympy.Expr:
        """The SymPy expression of a polynomial."""
        terms = []
        for exponents, value in polynomial.terms():
            powers = [x**n for x, n in self.powers(exponents)]
            terms.append(sympy.Mul(int(value), *powers))
        return sympy.Add(*terms)

    def powers(self, exponents: Sequence[int]) -> list[tuple[sympy.Expr, int]]:
        """The letters of a product with their exponents; `x sign(x)` is the modulus of x."""
        found = dict(zip(self.letters, exponents, strict=False))
        for k in self._signs:
            (inner,) = self.letters[k].args
            if found[self.letters[k]] == 1 and found.get(inner):
                found[self.letters[k]], found[inner] = 0, found[inner] - 1
                found[sympy.Abs(inner)] = 1
        return [(x, n) for x, n in found.items() if n]

    # --- arithmetic ---------------------------------------------------------------------------

    def sum(self, parts: Sequence[Quotient]) -> Quotient:
        """The sum, over a common denominator."""
        below = self.multiple(part.below for part in parts)
        above = self.ring.zero
        for part in parts:
            above += self._times(part.above, self._expanded(self.ratio(below, part.below)))
        if self.budget is not None:
            self.budget.check(len(above))
        return self._cancelled(above, below)

    def product(self, a: Quotient, b: Quotient) -> Quotient:
        """The product."""
        left, right = self._cancelled(a.above, b.below), self._cancelled(b.above, a.below)
        sums = Counter(left.below.sums)
        sums.update(right.below.sums)
        below = Denominator(left.below.simple * right.below.simple, sums)
        return Quotient(self._times(left.above, right.above), below)

    def negative(self, a: Quotient) -> Quotient:
        """The opposite."""
        return Quotient(-a.above, a.below)

    def _inverse(self, quotient: Quotient) -> Quotient:
        if not quotient.above:
            raise ZeroDivisionError
        simple, rest = split(quotient.above)
        ((exponents, number),) = simple.items()
        above = self._expanded(quotient.below) * (1 if number > 0 else -1)
        known, rest = self.known_sums(rest)
        if rest != self.ring.one:
            known[rest] += 1
            self.sums.setdefault(rest)
        below = Denominator(self.ring.from_dict({exponents: abs(number)}), known)
        return self._cancelled(above, below)

    def known_sums(self, polynomial: PolyElement) -> tuple[Counter[PolyElement], PolyElement]:
        """Divide a polynomial by the known denominators; return these and the remaining factor."""
        found: Counter[PolyElement] = Counter()
        for divisor in self.sums:
            polynomial, count = self.trials.divided_out(polynomial, divisor)
            if count:
                found[divisor] += count
        return found, polynomial

    def multiple(self, denominators: Iterable[Denominator]) -> Denominator:
        """A common multiple, the least one as far as the sums have no factor in common."""
        number, exponents = 1, [0] * self.ring.ngens
        sums: dict[PolyElement, int] = {}
        for denominator in denominators:
            ((powers, value),) = denominator.simple.items()
            number, exponents = lcm(number, int(value)), list(map(max, exponents, powers))
            for polynomial, count in denominator.sums.items():
                sums[polynomial] = max(count, sums.get(polynomial, 0))
        return Denominator(self.ring.from_dict({tuple(exponents): ZZ(number)}), sums)

    def ratio(self, whole: Denominator, part: Denominator) -> Denominator:
        """The quotient of a common multiple and one of its denominators."""
        sums = {p: count - part.sums.get(p, 0) for p, count in whole.sums.items()}
        return Denominator(divided(whole.simple, part.simple), {p: n for p, n in sums.items() if n})

    def over(self, quotient: Quotient, factor: Denominator) -> Quotient:
        """A quotient times a product that is written as a denominator."""
        common = self.multiple([quotient.below, factor])
        above = self._expanded(self.ratio(common, quotient.below))
        left = self.ratio(common, factor)
        return self._cancelled(self._times(quotient.above, above), left)

    def factors(self, denominator: Denominator) -> list[PolyElement]:
        """Polynomials whose product a denominator is."""
        sums = denominator.sums.items()
        return [denominator.simple, *(p for p, count in sums for _ in range(count))]

    def _expanded(self, denominator: Denominator) -> PolyElement:
        return reduce(self._times, self.factors(denominator))

    def _times(self, a: PolyElement, b: PolyElement) -> PolyElement:
        return a * b if self.budget is None else self.budget.product(a, b)

    def _cancelled(self, above: PolyElement, below: Denominator) -> Quotient:
        """Cancel the letters and sums of a denominator that divide the numerator."""
        if not above:
            return Quotient(above, self._one)
        common = common_factor(above, below.simple)
        above, simple = divided(above, common), divided(below.simple, common)
        sums = dict(below.sums)
        for polynomial, most in below.sums.items():
            above, count = self.trials.divided_out(above, polynomial, most)
            sums[polynomial] = most - count
        return Quotient(above, Denominator(simple, {p: n for p, n in sums.items() if n}))

    def _simple_signs(self, quotient: Quotient) -> Quotient:
        """Replace squares of signs by 1 (true except at zero); move signs to the numerator."""
        if not self._signs:
            return quotient
        ((exponents, number),) = quotient.below.simple.items()
        inverse, rest = [0] * len(exponents), list(exponents)
        for k in self._signs:
            inverse[k], rest[k] = rest[k] % 2, 0
        above = quotient.above * self.ring.from_dict({tuple(inverse): ZZ(1)})
        simple = self.ring.from_dict({tuple(rest): number})
        below = Denominator(simple, quotient.below.sums)
        return self._cancelled(self._without_squares(above), below)

    def _without_squares(self, polynomial: PolyElement) -> PolyElement:
        simple: dict[tuple[int, ...], int] = {}
        for exponents, value in polynomial.items():
            small = list(exponents)
            for k in self._signs:
                small[k] %= 2
            simple[tuple(small)] = simple.get(tuple(small), 0) + value
        return self.ring.from_dict(simple)


def _parts(expression: sympy.Expr) -> tuple[sympy.Expr, ...]:
    """The operands of a sum, a product or an integer power; none of any other expression.

    The base of a power with a fraction as exponent is a root: `x**(3/2)` is the cube of `sqrt(x)`.
    A modulus is the product of its operand and the operand's sign.
    """
    if expression.is_Add or expression.is_Mul:
        return tuple(expression.args)
    if isinstance(expression, sympy.Abs):
        (inner,) = expression.args
        return inner, sympy.sign(inner)
    if expression.is_Pow and expression.exp.is_Rational and _exponent(expression) != 1:
        return (expression.base ** sympy.Rational(1, expression.exp.q),)
    return ()


def _exponent(expression: sympy.Expr) -> int:
    return int(expression.exp.p)


def _letters(expressions: Iterable[sympy.Expr]) -> set[sympy.Expr]:
    """The letters: symbols, and functions that are treated as symbols."""
    seen: set[sympy.Expr] = set()
    found: set[sympy.Expr] = set()
    stack = list(expressions)
    while stack:
        top = stack.pop()
        if top in seen:
            continue
        seen.add(top)
        parts = _parts(top)
        if not parts and not top.is_Rational:
            found.add(top)
        stack.extend(parts)
    return found
