"""Polynomials and roots as text, in the language's spelling or as LaTeX.

Polynomials are written by falling powers of s, with the letters of a product in the order of the
model's file: `L*C*s^2 + R*C*s + 1`.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import sympy
from sympy.polys.rings import PolyElement
from sympy.printing.str import StrPrinter

from bgc.printing.align import Term, signed
from bgc.record_class import dataclass
from bgc.symbolic.factors import split
from bgc.symbolic.quotients import Field
from bgc.symbolic.ratios import by_powers


class _Plain(StrPrinter):  # type: ignore[misc]  # SymPy has no types
    """SymPy's text in the language's spelling."""

    def _print_Pow(self, expr: sympy.Expr, rational: bool = False) -> str:
        return str(super()._print_Pow(expr, rational)).replace("**", "^")

    def _print_Abs(self, expr: sympy.Expr) -> str:
        return f"abs({self._print(expr.args[0])})"

    def _print_ImaginaryUnit(self, expr: sympy.Expr) -> str:
        return "i"

    def _print_Piecewise(self, expr: sympy.Expr) -> str:
        *cases, (last, _) = expr.args
        chain = "".join(f"if {self._print(c)} then {self._print(e)} else " for e, c in cases)
        return f"({chain}{self._print(last)})"


@dataclass(frozen=True)
class Writer:
    """One way of writing formulas. `names` are the texts of letters, functions among them."""

    names: Mapping[sympy.Expr, str]
    latex: bool

    def expression(self, expression: sympy.Expr) -> str:
        """Any SymPy expression."""
        stand_ins = {
            x: sympy.Dummy() if self.latex else sympy.Symbol(text)
            for x, text in self.names.items()
            if not x.is_Symbol
        }
        renamed = _with_letters(expression, stand_ins)
        if not self.latex:
            return str(_Plain().doprint(renamed))
        texts = {stand_ins.get(x, x): text for x, text in self.names.items()}
        settings: dict[str, Any] = {"symbol_names": texts, "mul_symbol": r"\,"}
        return str(sympy.latex(renamed, **settings)).replace(r"\, ", r"\,")

    def power(self, text: str, exponent: int) -> str:
        """A letter or a bracket to a whole power."""
        if exponent == 1:
            return text
        if self.latex:
            base = self.bracketed(text) if "^" in text else text
            return f"{base}^{{{exponent}}}"
        base = self.bracketed(text) if set("^*/ ") & set(_outside(text)) else text
        return f"{base}^{exponent}"

    def bracketed(self, text: str) -> str:
        """A text in brackets."""
        return rf"\left({text}\right)" if self.latex else f"({text})"

    def product(self, texts: Sequence[str]) -> str:
        """Factors side by side."""
        return (r"\," if self.latex else "*").join(texts)

    def fraction(self, above: str, below: str) -> str:
        """A quotient on one line."""
        if below == "1":
            return above
        if self.latex:
            return rf"\frac{{{above}}}{{{below}}}"
        left = self.bracketed(above) if " " in _outside(above) else above
        right = self.bracketed(below) if set(" */") & set(_outside(below)) else below
        return f"{left}/{right}"

    # --- polynomials --------------------------------------------------------------------------

    def simple(self, field: Field, term: PolyElement) -> str:
        """One term with a positive integer; letter 0 stands last."""
        ((exponents, number),) = term.items()
        letters = sorted(field.powers(exponents), key=lambda item: item[0] == field.letters[0])
        powers = [self.power(self.names.get(x) or self.expression(x), n) for x, n in letters]
        return self.product(([str(number)] if number != 1 or not powers else []) + powers)

    def terms(self, field: Field, polynomial: PolyElement) -> list[Term]:
        """The terms by falling powers of letter 0; common factors of a coefficient stand first."""
        found: list[Term] = []
        coefficients = by_powers(polynomial, 0)
        for k, coefficient in enumerate(coefficients):
            if coefficient:
                found.append(self._term(field, coefficient, len(coefficients) - 1 - k))
        return found

    def named_terms(
        self, field: Field, polynomial: PolyElement, name: Callable[[int], str]
    ) -> tuple[list[Term], list[tuple[str, str]]]:
        """The terms with a name for each coefficient by its power; the coefficients."""
        terms: list[Term] = []
        coefficients: list[tuple[str, str]] = []
        for exponent, coefficient in enumerate(reversed(by_powers(polynomial, 0))):
            if coefficient:
                s = [self.power(self.names[field.letters[0]], exponent)] if exponent else []
                terms.append((False, self.product([name(exponent), *s])))
                coefficients.append((name(exponent), self.sum(field, coefficient)))
        return terms[::-1], coefficients[::-1]

    def _term(self, field: Field, coefficient: PolyElement, exponent: int) -> Term:
        outside, inside = split(coefficient)
        number = positive(outside)
        texts = [] if number == field.ring.one else [self.simple(field, number)]
        if len(inside) > 1:
            inner = joined([self._simple_term(field, e, c) for e, c in inside.terms()])
            texts.append(inner if not texts and exponent == 0 else self.bracketed(inner))
        if exponent:
            texts.append(self.power(self.names[field.letters[0]], exponent))
        return outside.LC < 0, self.product(texts or ["1"])

    def _simple_term(self, field: Field, exponents: tuple[int, ...], number: int) -> Term:
        return number < 0, self.simple(field, field.ring.from_dict({exponents: abs(number)}))

    def sum(self, field: Field, polynomial: PolyElement) -> str:
        """A polynomial on one line."""
        return joined(self.terms(field, polynomial))

    def factors(
        self, field: Field, factors: Sequence[PolyElement], named: Mapping[PolyElement, str]
    ) -> str:
        """A product, its first factor one term; long factors have names of their own."""
        first, *rest = factors
        sign = "-" if first.LC < 0 else ""
        number = positive(first)
        powers = Counter(rest)
        whole = [] if number == field.ring.one and powers else [self.simple(field, number)]
        alone = not whole and not sign and len(rest) == 1
        for polynomial, count in powers.items():
            text = named.get(polynomial) or self.sum(field, polynomial)
            bracketed = text if alone or polynomial in named else self.bracketed(text)
            whole.append(self.power(bracketed, count))
        return sign + self.product(whole)


def _with_letters(expression: sympy.Expr, letters: Mapping[sympy.Expr, sympy.Symbol]) -> sympy.Expr:
    """An expression with a symbol for each function that is a letter, and for powers of roots."""
    roots = {x.base: (x.exp, symbol) for x, symbol in letters.items() if x.is_Pow}

    def is_power(part: sympy.Basic) -> bool:
        return bool(part.is_Pow and part.base in roots and part.exp.is_Rational)

    def renamed(part: sympy.Expr) -> sympy.Expr:
        exponent, symbol = roots[part.base]
        return symbol ** (part.exp / exponent)

    return expression.replace(is_power, renamed).xreplace(dict(letters))


def positive(term: PolyElement) -> PolyElement:
    """A term with the modulus of its number."""
    return -term if term.LC < 0 else term


def joined(terms: Sequence[Term]) -> str:
    """A sum from its terms."""
    return " ".join(signed(terms))


def broken(text: str, width: int) -> list[str]:
    """A sum over lines of so many characters, broken before its signs.

    A term that does not fit begins a new line; continuations inside a bracket are indented.
    """
    lines: list[str] = []
    for term in _pieces(text, outside=True):
        if lines and len(lines[-1]) + 1 + len(term) <= width:
            lines[-1] += f" {term}"
            continue
        start = True
        for piece in _pieces(term, outside=False):
            if start or len(lines[-1]) + 1 + len(piece) > width:
                lines.append(" " * (0 if start else 3) + piece)
            else:
                lines[-1] += f" {piece}"
            start = False
    return lines


def terms_of(text: str) -> list[Term]:
    """The terms of a sum that is written already."""
    first, *rest = _pieces(text, outside=True)
    start = (first.startswith("-"), first.removeprefix("-"))
    return [start, *((piece.startswith("-"), piece[2:]) for piece in rest)]


def _pieces(text: str, *, outside: bool) -> list[str]:
    """The parts of a sum with their signs; those of its brackets too unless only `outside`."""
    parts: list[str] = []
    depth = 0
    for piece in re.split(r" (?=[+-] )", text):
        if parts and depth > 0 and outside:
            parts[-1] += f" {piece}"
        else:
            parts.append(piece)
        depth += piece.count("(") - piece.count(")")
    return parts


def _outside(text: str) -> str:
    """The characters of a text that are in no bracket."""
    depth, found = 0, []
    for character in text:
        depth -= character in ")]"
        if depth == 0:
            found.append(character)
        depth += character in "(["
    return "".join(found)
