"""A transfer function in letters: poles, zeros, static gain, sensitivities, numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cached_property

import sympy

from bgc.diagnostics.catalogue import symbolic as catalogue
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.symbolic.quotients import Field
from bgc.symbolic.ratios import Ratio, lowest
from bgc.symbolic.roots import Roots, numeric_roots, roots_of
from bgc.symbolic.system import derivative, exact

_DIGITS = 30  # of functions of letters, as numbers


@dataclass(frozen=True)
class TransferFunction:
    """`output = G(s) input` for deviations from an operating point, in the model's letters.

    Attributes
    ----------
    output, input
        Their names.
    unit
        SI unit of the output per that of the input.
    laplace
        The symbol `s`, 1/s.
    values, units
        The scene's number for each letter, SI (states are as at the start), and its unit.
    dependent, follows
        Formulas of parameters that follow from others; the same with sources and initial states.
    ratio
        The polynomials, for printing.

    Examples
    --------
    >>> G = sym.transfer_function("capacitor.e", "supply.e")  # doctest: +SKIP
    >>> G.expression, G.static_gain, G.poles()  # doctest: +SKIP
    >>> G.sensitivity("R")  # doctest: +SKIP
    -C*s/(C*L*s**2 + C*R*s + 1)**2
    >>> G.numeric_poles({"R": 10.0})  # doctest: +SKIP
    """

    output: str
    input: str
    unit: str
    laplace: sympy.Symbol
    values: Mapping[sympy.Symbol, float]
    units: Mapping[sympy.Symbol, str]
    dependent: Mapping[sympy.Symbol, sympy.Expr]
    follows: Mapping[sympy.Symbol, sympy.Expr]
    ratio: Ratio

    @cached_property
    def expression(self) -> sympy.Expr:
        """G(s), in lowest terms."""
        return self.numerator / self.denominator

    @cached_property
    def numerator(self) -> sympy.Expr:
        """The numerator of `expression`, a polynomial in s."""
        return self.ratio.numerator

    @cached_property
    def denominator(self) -> sympy.Expr:
        """The denominator of `expression`, a polynomial in s."""
        return self.ratio.denominator

    @property
    def order(self) -> int:
        """The number of poles."""
        return sum(p.degrees()[0] for p in self.ratio.below)

    @cached_property
    def static_gain(self) -> sympy.Expr:
        """G(0), in `unit`; `zoo` (infinite) where the output integrates the input."""
        found = self.static_ratio
        return sympy.zoo if found is None else found.expression

    @cached_property
    def static_ratio(self) -> Ratio | None:
        """The polynomials of `static_gain`, None of an infinite one."""
        return self.ratio.at_zero(0)

    # --- poles and zeros ----------------------------------------------------------------------

    @cached_property
    def pole_factors(self) -> list[Roots]:
        """The irreducible factors of the denominator with their roots."""
        return roots_of(self.ratio.field, self.ratio.below, 0)

    @cached_property
    def zero_factors(self) -> list[Roots]:
        """The irreducible factors of the numerator with their roots."""
        return [] if self.ratio.is_zero else roots_of(self.ratio.field, self.ratio.above, 0)

    def poles(self) -> tuple[sympy.Expr, ...]:
        """The poles in closed form, 1/s, a multiple one as often as it counts.

        Raises
        ------
        BgError
            BG095 where a factor of the denominator has no closed form.
        """
        return self._closed("poles", self.pole_factors)

    def zeros(self) -> tuple[sympy.Expr, ...]:
        """The zeros in closed form, 1/s, a multiple one as often as it counts.

        Raises
        ------
        BgError
            BG095 where a factor of the numerator has no closed form.
        """
        return self._closed("zeros", self.zero_factors)

    def _closed(self, what: str, factors: Sequence[Roots]) -> tuple[sympy.Expr, ...]:
        found: list[sympy.Expr] = []
        for roots in factors:
            if roots.closed is None:
                degree = roots.factor.degrees()[0]
                raise BgError([catalogue.no_closed_form(what, self.output, self.input, degree)])
            found += [root for root in roots.closed for _ in range(roots.count)]
        return tuple(found)

    # --- sensitivities ------------------------------------------------------------------------

    def sensitivity(self, parameter: str) -> sympy.Expr:
        """The derivative dG/dp, a rational function of s in lowest terms.

        Its unit is `unit` over that of the parameter.
        Parameters that follow from `parameter` change with it.

        Raises
        ------
        BgError
            BG079 where there is no such letter.
        """
        by = self._letter(parameter)
        above, below = self.numerator, self.denominator
        change = derivative(above, by, self.dependent), derivative(below, by, self.dependent)
        field = Field((above, below, *change, self.laplace), (self.laplace, *self.values), None)
        top, bottom, top_change, bottom_change = map(field.of, (above, below, *change))
        # d(a/b) = (a' b - a b')/b^2; a and b are polynomials, a' and b' may be quotients
        difference = field.sum(
            [field.product(top_change, bottom), field.negative(field.product(bottom_change, top))]
        )
        once = [field.of(self.ratio.field.expression(p)).above for p in self.ratio.below]
        square = [*field.factors(difference.below), *once, *once]
        return lowest(field, [difference.above], square).expression

    def static_sensitivity(self, parameter: str) -> sympy.Expr:
        """The derivative of the static gain by a parameter; 0 of an infinite one.

        Raises
        ------
        BgError
            BG079 where there is no such letter.
        """
        by = self._letter(parameter)
        if self.static_gain is sympy.zoo:
            return sympy.S.Zero
        return sympy.cancel(derivative(self.static_gain, by, self.dependent))

    def pole_sensitivity(self, parameter: str) -> sympy.Expr:
        """The derivative of a pole by a parameter, as a function of the pole s: -D_p/D_s.

        Put a simple pole in for s: `G.pole_sensitivity("R").subs(G.laplace, G.poles()[0])`. With
        several factors, it holds for the poles of each.

        Raises
        ------
        BgError
            BG079 where there is no such letter.
        """
        by = self._letter(parameter)
        by_parameter = derivative(self.denominator, by, self.dependent)
        return sympy.cancel(-by_parameter / self.denominator.diff(self.laplace))

    def _letter(self, name: str) -> sympy.Symbol:
        known = [symbol.name for symbol in self.values]
        if name not in known:
            raise BgError([catalogue.unknown_letter(name, known)])
        return sympy.Symbol(name)

    # --- numbers ------------------------------------------------------------------------------

    def numbers(
        self, values: Mapping[str, float] | None = None
    ) -> tuple[list[Fraction], list[Fraction]]:
        """The coefficients of numerator and denominator, highest power of s first.

        They are exact for the scene's doubles; `values` are others for some letters, SI, by name.

        Raises
        ------
        BgError
            BG076 where a letter has no number, BG079 where there is no such letter, BG097 where a
            function of letters is not defined at their values.
        """
        return self.ratio.coefficients(0, self.letter_numbers(values))

    def letter_numbers(
        self, values: Mapping[str, float] | None = None
    ) -> dict[sympy.Expr, Fraction]:
        """A number for each letter of the polynomials, functions of letters among them."""
        numbers = self.symbol_numbers(values)
        found = {}
        for letter in self.ratio.letters:
            if letter != self.laplace:
                number = self.number(letter, numbers)
                if number is None:
                    name = f"the transfer function of `{self.output}` by `{self.input}`"
                    raise BgError([catalogue.undefined_at(name)])
                found[letter] = number
        return found

    def symbol_numbers(
        self, values: Mapping[str, float] | None = None
    ) -> dict[sympy.Symbol, sympy.Rational]:
        """A number for each symbol: those given, those that follow from them, the scene's."""
        letters = self.ratio.symbols
        known = {symbol.name: symbol for symbol in (*self.values, *letters)}
        for name in values or ():
            if name not in known:
                raise BgError([catalogue.unknown_letter(name, list(known))])
        given = {known[name]: exact(value) for name, value in (values or {}).items()}
        numbers = {**{x: exact(value) for x, value in self.values.items()}, **given}
        missing = sorted(x.name for x in letters - numbers.keys() if x != self.laplace)
        if missing:
            raise BgError([catalogue.no_number(missing[0])])
        self._follow(numbers, given)
        return numbers

    def _follow(
        self,
        numbers: dict[sympy.Symbol, sympy.Rational],
        given: Mapping[sympy.Symbol, sympy.Rational],
    ) -> None:
        """Recompute all numbers that follow, directly or not, from given ones."""
        changed = set(given)
        waiting = {x: e for x, e in self.follows.items() if x not in given}
        while ready := [x for x, e in waiting.items() if e.free_symbols & changed]:
            changed = set(ready)
            for letter in ready:
                number = self.number(waiting[letter], numbers)
                if number is not None:
                    numbers[letter] = exact(number)
            waiting = {x: e for x, e in waiting.items() if x not in changed}

    @staticmethod
    def number(
        expression: sympy.Expr, numbers: Mapping[sympy.Symbol, sympy.Rational]
    ) -> Fraction | None:
        """The value of an expression, None where it has no finite real one."""
        constant = expression.xreplace(dict(numbers))
        if not constant.is_Rational:
            value = constant.evalf(_DIGITS)
            if not (value.is_Float and value.is_finite):
                return None
            constant = sympy.Rational(str(value))
        return Fraction(int(constant.p), int(constant.q))

    def numeric_poles(self, values: Mapping[str, float] | None = None) -> list[complex]:
        """The poles, 1/s, by rising real part; `values` are as in `numbers`."""
        return numeric_roots(self.numbers(values)[1])

    def numeric_zeros(self, values: Mapping[str, float] | None = None) -> list[complex]:
        """The zeros, 1/s, by rising real part; `values` are as in `numbers`."""
        return numeric_roots(self.numbers(values)[0])

    def at(self, s: complex, values: Mapping[str, float] | None = None) -> complex:
        """G at a complex frequency in 1/s; `values` are as in `numbers`."""
        above, below = self.numbers(values)
        return _horner(above, s) / _horner(below, s)


def _horner(coefficients: Sequence[Fraction], s: complex) -> complex:
    total = 0j
    for coefficient in coefficients:
        total = total * s + float(coefficient)
    return total
