"""A transfer function in one spelling: names for its long parts, roots with their numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import count
from typing import TypeAlias

import sympy
from sympy.polys.rings import PolyElement

from bgc.diagnostics.diagnostic import BgError
from bgc.printing.align import LINE, Term, visible_width
from bgc.symbolic.letters import latex_letters
from bgc.symbolic.polynomial_text import Writer, terms_of
from bgc.symbolic.ratios import Ratio, evaluated
from bgc.symbolic.roots import Roots, numeric_roots
from bgc.symbolic.transfer import TransferFunction

LONG_FACTOR = 8_000  # characters of a polynomial, without --full

_LONG_LETTER = 24  # characters of a function of letters, beyond which it gets a name
_DIGITS = 15
_ALMOST_ZERO = 1e-12  # of a root: rounding

Values: TypeAlias = Mapping[str, float]


class Spelled:
    """A transfer function in one spelling, its long factors under names of their own."""

    def __init__(self, function: TransferFunction, *, latex: bool) -> None:
        self._function = function
        self._latex = latex
        self.field = function.ratio.field
        symbols = sorted(function.ratio.symbols - {function.laplace}, key=str)
        names = latex_letters(symbols) if latex else {x: x.name for x in symbols}
        names[function.laplace] = function.laplace.name
        self._taken = set(names.values())
        self.writer = Writer(names, latex)
        self.defined: list[tuple[str, str]] = []  # names of long functions of letters
        self._name_functions(names)
        self.factors: dict[PolyElement, str] = {}
        ratio = function.ratio
        for choices, side in ((("N", "Num"), ratio.above), (("D", "Den"), ratio.below)):
            different = list(dict.fromkeys(side[1:]))
            letter = self._fresh(choices)
            for k, polynomial in enumerate(different, 1):
                numbered = self._counted(letter, k)
                self.factors[polynomial] = letter if len(different) == 1 else numbered

    def _name_functions(self, names: dict[sympy.Expr, str]) -> None:
        """The texts of functions of letters; long ones get a name."""
        letter = self._fresh(("w", "fn"))
        for function in self._function.ratio.letters:
            if not function.is_Symbol:
                text = Writer(dict(names), self._latex).expression(function)
                if visible_width(text) > _LONG_LETTER:
                    name = self._counted(letter, len(self.defined) + 1)
                    self.defined.append((name, text))
                    text = name
                names[function] = text

    def _fresh(self, choices: Sequence[str]) -> str:
        """The first of some names that no name of the model begins with."""
        longer = (choice * length for length in count(1) for choice in choices)
        return next(c for c in longer if not any(text.startswith(c) for text in self._taken))

    def _counted(self, letter: str, count: int) -> str:
        return f"{letter}_{{{count}}}" if self._latex else f"{letter}{count}"

    def sides(self, *, named: bool) -> tuple[str, str]:
        """Numerator and denominator; with names for the factors, or with these in full."""
        return self.sides_of(self._function.ratio, self.factors if named else {})

    def sides_of(self, ratio: Ratio, named: Mapping[PolyElement, str]) -> tuple[str, str]:
        """Numerator and denominator of any ratio of the field."""
        if ratio.is_zero:
            return "0", "1"
        above, below = (
            self.writer.factors(self.field, side, named) for side in (ratio.above, ratio.below)
        )
        return above, below

    def static_gain(self) -> str:
        """The static gain on one line; empty of an infinite one."""
        ratio = self._function.static_ratio
        return "" if ratio is None else self.writer.fraction(*self.sides_of(ratio, {}))

    def definitions(self) -> Iterator[tuple[str, str]]:
        """The names of the factors, with these."""
        for polynomial, name in self.factors.items():
            yield name, self.writer.sum(self.field, polynomial)

    def long_definitions(self) -> Iterator[tuple[str, list[Term]]]:
        """The same for a page: factors with long coefficients have names for these."""
        letters = ["a", "b", "c", "d"]
        for polynomial, name in self.factors.items():
            terms = self.writer.terms(self.field, polynomial)
            if all(visible_width(text) <= LINE for _, text in terms):
                yield name, terms
                continue
            letter = self._fresh(letters)
            self._taken.add(letter)
            terms, coefficients = self.writer.named_terms(
                self.field, polynomial, partial(self._counted, letter)
            )
            yield name, terms
            for left, text in coefficients:
                yield left, terms_of(text)


def static_number(function: TransferFunction, values: Values) -> str:
    """The static gain with six digits, or `infinite` or `undefined`."""
    try:
        above, below = function.numbers(values)
    except BgError:
        return "undefined"
    if below[-1]:
        return short(float(above[-1] / below[-1]))
    return "infinite" if above[-1] else "undefined"


def described(
    function: TransferFunction, writer: Writer, roots: Roots, values: Values
) -> Iterator[tuple[str, list[complex]]]:
    """Formulas of one root or of two, `a +- b`, each with its numbers where they are defined.

    Of a factor without formulas: empty texts, each with one root or two conjugate ones.
    """
    if roots.pairs is None:
        yield from (("", found) for found in _numeric(function, roots, values))
        return
    symbols = function.symbol_numbers(values)
    for centre, offset in roots.pairs:
        text = writer.expression(centre)
        if offset is None:
            yield text, _values([centre], symbols)
            continue
        sign = r"\pm " if writer.latex else "+- "
        before = "" if centre == 0 else f"{text} "
        both = _values([centre + offset, centre - offset], symbols)
        yield f"{before}{sign}{writer.expression(offset)}", both


def _numeric(function: TransferFunction, roots: Roots, values: Values) -> list[list[complex]]:
    """Real roots and pairs of conjugate ones; one empty list where they are undefined."""
    try:
        numbers = function.letter_numbers(values)
    except BgError:
        return [[]]
    found = numeric_roots(evaluated(function.ratio.field, roots.factor, 0, numbers))
    return [[x, x.conjugate()] if x.imag else [x] for x in found if x.imag >= 0] or [[]]


def _values(
    expressions: Sequence[sympy.Expr], numbers: Mapping[sympy.Symbol, sympy.Rational]
) -> list[complex]:
    """The numbers of some expressions by rising real part; none where one is undefined."""
    found = [expression.xreplace(dict(numbers)).evalf(_DIGITS) for expression in expressions]
    if not all(value.is_number and value.is_finite for value in found):
        return []
    return sorted(map(complex, found), key=lambda x: (x.real, x.imag))


def pair_texts(roots: Sequence[complex], sign: str = "+-") -> list[str]:
    """Roots with six digits, two conjugate ones together."""
    found = []
    for root in roots:
        size = _ALMOST_ZERO * abs(root)
        real = root.real if abs(root.real) > size else 0.0
        if abs(root.imag) <= size:
            found.append(short(real))
        elif root.imag > 0:
            before = f"{short(real)} " if real else ""
            found.append(f"{before}{sign} {short(root.imag)}i")
    return found


def short(value: float) -> str:
    """A number with six digits."""
    return f"{value:.6g}"
