"""Transform the expressions of the parse tree into those of the syntax tree."""

from __future__ import annotations

import re
import sys
from fractions import Fraction
from typing import Any

from lark import Token, Tree

from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.mistaken_values import power_of_unit
from bgc.grammar.tokens import ParseTree, end_of, span_of, start_of
from bgc.record_class import replace

MAX_DEPTH = 200
"""The deepest nesting of an expression; `a + b + c` is two deep, as `(a + b) + c`."""

_MAX_DIGITS = 1000
_LARGEST_DOUBLE = Fraction(sys.float_info.max)
_NUMBER = re.compile(r"(?P<mantissa>[0-9.]+)(?:[eE](?P<exponent>[+-]?[0-9]+))?(?: (?P<unit>.+))?")


class ExpressionTransform:
    """The transformation of expressions and arguments; collects diagnostics."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.diagnostics: list[Diagnostic] = []

    def report(self, diagnostic: Diagnostic) -> None:
        """Record a diagnostic."""
        self.diagnostics.append(diagnostic)

    # --- places ---------------------------------------------------------------------------

    def token_span(self, token: Token) -> Span:
        """Return the place of a token."""
        return span_of(self.source, token)

    def span(self, node: ParseTree | Token) -> Span:
        """Return the place of a rule, from the first to the last token in its tree."""
        first: Any = node
        while isinstance(first, Tree):
            first = next(child for child in first.children if child is not None)
        last: Any = node
        while isinstance(last, Tree):
            last = next(child for child in reversed(last.children) if child is not None)
        return Span(self.source, start_of(first), end_of(last))

    # --- expressions ------------------------------------------------------------------------

    def expression(self, node: ParseTree | Token, depth: int = 0) -> syntax.Expr:
        """Transform an expression; report one that is nested too deep, and return 0 for it."""
        if depth > MAX_DEPTH:
            return self._too_deep(node)
        if isinstance(node, Token):
            return self._leaf(node)
        children: list[Any] = node.children
        match node.data:
            case "group":
                return self.expression(children[1], depth + 1)
            case "sum" | "product" | "conjunction" | "disjunction" | "comparison":
                return self._chain_of_operators(children, depth)
            case "power":
                return self._chain_of_operators(children, depth + 1)
            case "sign" | "negation":
                operator, operand = children
                inner = self.expression(operand, depth + 1)
                return syntax.Unary(str(operator), inner, self.token_span(operator).to(inner.span))
            case "postfix" | "path":
                return self._postfix(children, depth)
            case "vector":
                return self._vector(node, depth)
            case "conditional":
                return self._conditional(children, depth)
        raise AssertionError(node.data)

    def _too_deep(self, node: ParseTree | Token) -> syntax.Expr:
        """Report an expression that is nested too deep, and return 0 in its place."""
        span = self.span(node)
        self.report(wrong.too_deep(span))
        return syntax.Number(Fraction(0), None, span)

    def _leaf(self, token: Token) -> syntax.Expr:
        span = self.token_span(token)
        match token.type:
            case "NUMBER":
                return self._number(token, span)
            case "TEXT":
                return syntax.Text(unquoted(token), span)
            case "DER":
                self.report(wrong.derivative_of_nothing(span))
        return syntax.Name(str(token), span)

    def _number(self, token: Token, span: Span) -> syntax.Number:
        parts = _NUMBER.fullmatch(token)
        assert parts is not None
        mantissa, exponent, unit = parts.group("mantissa", "exponent", "unit")
        value = None
        if len(mantissa) <= _MAX_DIGITS and len(exponent or "") <= 5:
            value = Fraction(mantissa) * Fraction(10) ** int(exponent or 0)
        if value is None or value > _LARGEST_DOUBLE:
            self.report(wrong.number_out_of_range(span))
            value = Fraction(0)
        return syntax.Number(value, unit, span)

    def _chain_of_operators(self, children: list[Any], depth: int) -> syntax.Expr:
        """Nest `a - b + c` to the left, as deep as it is long: visitors loop over its links."""
        operators = children[1::2]
        made = self.expression(children[0], depth + 1)
        for operator, operand in zip(operators, children[2::2], strict=True):
            right = self.expression(operand, depth + 1)
            span = self.span(children[0]).to(self.span(operand))
            if power := _GLUED_POWER.search(span.text if operator == "-" else ""):
                self.report(power_of_unit(span, power[1], power[2]))
            made = syntax.Binary(str(operator), made, right, span)
        return made

    def _conditional(self, children: list[Any], depth: int) -> syntax.Expr:
        """Nest the branches of `if a then b else if c then d else e` from the last."""
        conditions, values = children[1::5], children[3::5]
        if depth + len(values) > MAX_DEPTH:
            return self._too_deep(children[5 * (MAX_DEPTH - depth)])
        made = self.expression(children[-1], depth + len(values))
        end = made.span
        for at in range(len(values) - 1, -1, -1):
            made = syntax.Conditional(
                self.expression(conditions[at], depth + at + 1),
                self.expression(values[at], depth + at + 1),
                made,
                self.token_span(children[5 * at]).to(end),
            )
        return made

    def _vector(self, tree: ParseTree, depth: int) -> syntax.Vector:
        children: list[Any] = tree.children
        *elements, _, unit = children[1:]
        span = self.span(tree)
        made = tuple(self.expression(e, depth + 1) for e in elements if e is not None)
        if not made:
            self.report(wrong.empty_vector(span))
        vector = syntax.Vector(made, span)
        return vector if unit is None else self._with_unit(vector, unit)

    def _with_unit(self, vector: syntax.Vector, unit: Token) -> syntax.Vector:
        """Give the numbers of a vector its unit: `[1, -2] m` is `[1 m, -2 m]`."""
        elements: list[syntax.Expr] = []
        for element in vector.elements:
            match element:
                case syntax.Vector():
                    elements.append(self._with_unit(element, unit))
                case syntax.Number(unit=None):
                    elements.append(replace(element, unit=str(unit)))
                case syntax.Unary(operand=syntax.Number(unit=None) as number):
                    elements.append(replace(element, operand=replace(number, unit=str(unit))))
                case _:
                    message = "a unit behind a vector goes with numbers that have none"
                    help = f"write the unit behind each number, or multiply by `1 {unit}`"
                    self.report(wrong.misspelt_number(element.span, message, help))
                    elements.append(element)
        return replace(vector, elements=tuple(elements))

    # --- `.name`, `[index]` and `(arguments)` -------------------------------------------------

    def _postfix(self, children: list[Any], depth: int) -> syntax.Expr:
        """Nest `a.b[i](c)` to the left."""
        first, *suffixes = children
        if depth + len(suffixes) > MAX_DEPTH:
            return self._too_deep(suffixes[MAX_DEPTH - depth])
        start = self.span(first)
        if isinstance(first, Token) and first.type == "DER":
            return self._derivative(start, suffixes, depth)
        if isinstance(first, Token) and first.type != "NAME" and suffixes[0].data != "call":
            self.report(wrong.part_of_literal(self.span(suffixes[0]), str(first)))
        made = self.expression(first, depth + len(suffixes))
        for suffix in suffixes:
            span = start.to(self.span(suffix))
            match suffix.data:
                case "member":
                    made = syntax.Member(made, str(suffix.children[0]), span)
                case "indices":
                    made = syntax.Index(made, self._indices(suffix, depth), span)
                case "call":
                    made = self._call(made, suffix, span, depth)
                case _:
                    raise AssertionError(suffix.data)
        return made

    def _derivative(self, start: Span, suffixes: list[Any], depth: int) -> syntax.Expr:
        """Make `der(x)`, which takes one argument and nothing behind it."""
        span = start.to(self.span(suffixes[-1]))
        arguments: tuple[syntax.Argument, ...] = ()
        if len(suffixes) == 1 and suffixes[0].data == "call":
            arguments = self.arguments(suffixes[0].children[1], depth)
        if len(arguments) != 1 or arguments[0].name is not None:
            self.report(wrong.derivative_of_nothing(start))
        return syntax.Call("der", tuple(argument.value for argument in arguments), span)

    def _indices(self, tree: ParseTree, depth: int) -> tuple[syntax.Expr | syntax.Range, ...]:
        indices: list[syntax.Expr | syntax.Range] = []
        for index in tree.children[1:-1]:
            assert isinstance(index, Tree)
            first, last = children_of(index)
            if last is None:
                indices.append(self.expression(first, depth + 1))
            else:
                ends = self.expression(first, depth + 1), self.expression(last, depth + 1)
                indices.append(syntax.Range(*ends, self.span(index)))
        return tuple(indices)

    def plain_indices(self, tree: ParseTree) -> tuple[syntax.Expr, ...]:
        """Transform indices among which ranges are not allowed."""
        return self._without_ranges(self._indices(tree, 0))

    def _without_ranges(
        self, indices: tuple[syntax.Expr | syntax.Range, ...]
    ) -> tuple[syntax.Expr, ...]:
        plain: list[syntax.Expr] = []
        for index in indices:
            if isinstance(index, syntax.Range):
                self.report(wrong.range_of_widths(index.span))
                plain.append(index.last)
            else:
                plain.append(index)
        return tuple(plain)

    def _call(self, callee: syntax.Expr, tree: ParseTree, span: Span, depth: int) -> syntax.Expr:
        """Make the call of a function, or the use of a type where an argument has a name."""
        arguments = self.arguments(tree.children[1], depth)
        match callee:
            case syntax.Name("interpolate"):
                options = tuple((a.name, a.value) for a in arguments if a.name is not None)
                plain = tuple(a.value for a in arguments if a.name is None)
                return syntax.Call("interpolate", plain, span, options)
            case syntax.Name(name, name_span) if name != "time":
                if any(argument.name is not None for argument in arguments):
                    return syntax.TypeUse(name, (), arguments, span, name_span)
                return syntax.Call(name, tuple(argument.value for argument in arguments), span)
            case syntax.Index(syntax.Name(name, name_span), indices):
                return syntax.TypeUse(
                    name, self._without_ranges(indices), arguments, span, name_span
                )
        self.report(wrong.not_callable(callee.span, _spaced(callee)))
        return callee

    def arguments(self, tree: Any, depth: int = 0) -> tuple[syntax.Argument, ...]:
        """Transform the arguments of a call or a type; `tree` is None where there are none."""
        if tree is None:
            return ()
        made: list[syntax.Argument] = []
        for argument in tree.children:
            name, value = argument.children
            made.append(
                syntax.Argument(
                    None if name is None else str(name),
                    self.expression(value, depth + 1),
                    self.span(argument),
                )
            )
        return tuple(made)


_GLUED_POWER = re.compile(r"(?<![\w.])([0-9.]+(?:[eE][+-]?[0-9]+)? [A-Za-z][\w*/]*)-([0-9]+)$")


def children_of(tree: ParseTree) -> list[Any]:
    """The subtrees and tokens of a tree; those that are absent are None."""
    return tree.children


def unquoted(token: object) -> str:
    """Return the characters between the quotes of a text."""
    return str(token)[1:-1]


def _spaced(callee: syntax.Expr) -> str:
    """Spell `10 V*sin`, where `sin` is read as a unit, as `10 V * sin`; otherwise return ""."""
    if not isinstance(callee, syntax.Number) or callee.unit is None:
        return ""
    found = re.fullmatch(r"(.+)([*/])([A-Za-z_]\w*)", callee.span.text)
    return f"{found[1]} {found[2]} {found[3]}" if found else ""
