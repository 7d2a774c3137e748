"""Nodes as text for messages: equal terms and factors collected, nothing abbreviated.

Shared nodes are written out each time, so this is for short expressions: the text is None where it
would be longer than a limit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction

from bgc.algebra.dag import Dag, Op, Symbol
from bgc.algebra.infix import number
from bgc.algebra.nodes import Node

_SUM, _PRODUCT, _ATOM = range(3)


class _TooLongError(Exception):
    """The text would exceed the limit."""


def expanded_text(
    dag: Dag, node: Node, name: Callable[[Symbol], str], limit: int = 300
) -> str | None:
    """A node in the notation of the language; None if it is longer than `limit` characters.

    `x*v + v*x` is written `2*x*v`, and `x*x` is written `x^2`.
    """
    if _is_longer(dag, node, limit):
        return None
    try:
        text = _Writer(dag, name, limit).write(node)[0]
    except _TooLongError:
        return None
    return text if len(text) <= limit else None


def _is_longer(dag: Dag, node: Node, limit: int) -> bool:
    """Return whether a node needs more than `limit` others, each a character at least."""
    seen, stack = {node}, [node]
    while stack and len(seen) <= limit:
        new = set(dag.operands(stack.pop())) - seen
        seen |= new
        stack += new
    return len(seen) > limit


class _Writer:
    def __init__(self, dag: Dag, name: Callable[[Symbol], str], limit: int) -> None:
        self._dag = dag
        self._name = name
        self._left = limit  # characters of names and numbers

    def write(self, node: Node) -> tuple[str, int]:
        """The text, and how tightly it binds."""
        terms: dict[tuple[tuple[Node, int], ...], Fraction] = {}
        for sign, term in self._terms(node, 1):
            factors: dict[Node, int] = {}
            weight = self._multiply(term, 1, factors) * sign
            key = tuple(sorted((k, n) for k, n in factors.items() if n))
            terms[key] = terms.get(key, Fraction(0)) + weight
        found = [(key, weight) for key, weight in terms.items() if weight]
        if not found:
            return "0", _ATOM
        found.sort(key=lambda item: item[1] < 0)  # a sum begins with a positive term, if any
        texts = [self._term(key, abs(weight)) for key, weight in found]
        if len(found) == 1 and found[0][1] > 0:
            return texts[0]
        signs = ["-" if weight < 0 else "+" for _, weight in found]
        lead = "-" if signs[0] == "-" else ""
        rest = (f" {sign} {text}" for sign, (text, _) in zip(signs[1:], texts[1:], strict=True))
        return lead + texts[0][0] + "".join(rest), _SUM

    def _terms(self, node: Node, sign: int) -> Iterator[tuple[int, Node]]:
        dag = self._dag
        match Op(dag.op[node]):
            case Op.ADD:
                yield from self._terms(dag.a[node], sign)
                yield from self._terms(dag.b[node], sign)
            case Op.SUB:
                yield from self._terms(dag.a[node], sign)
                yield from self._terms(dag.b[node], -sign)
            case Op.NEG:
                yield from self._terms(dag.a[node], -sign)
            case _:
                yield sign, node

    def _multiply(self, node: Node, power: int, factors: dict[Node, int]) -> Fraction:
        """Add the factors of a node to the others; the constant among them."""
        dag = self._dag
        self._spend(1)
        value = dag.value(node)
        if value is not None and value != 0:
            return Fraction(value**power)
        match Op(dag.op[node]):
            case Op.MUL | Op.DIV as op:
                second = power if op is Op.MUL else -power
                left = self._multiply(dag.a[node], power, factors)
                return left * self._multiply(dag.b[node], second, factors)
            case Op.NEG:
                return Fraction(-1) ** power * self._multiply(dag.a[node], power, factors)
            case _:
                factors[node] = factors.get(node, 0) + power
                return Fraction(1)

    def _term(self, key: tuple[tuple[Node, int], ...], weight: Fraction) -> tuple[str, int]:
        above = [self._factor(node, power) for node, power in key if power > 0]
        below = [self._factor(node, -power) for node, power in key if power < 0]
        if weight != 1 or not above:
            above.insert(0, number(weight))
        text = "*".join(above) + "".join(f"/{factor}" for factor in below)
        return text, _ATOM if len(above) + len(below) == 1 else _PRODUCT

    def _factor(self, node: Node, power: int) -> str:
        text, binding = self._atom(node)
        bracketed = text if binding == _ATOM else f"({text})"
        return bracketed if power == 1 else f"{bracketed}^{power}"

    def _atom(self, node: Node) -> tuple[str, int]:
        dag = self._dag
        value, symbol = dag.value(node), dag.symbol_of(node)
        if value is not None or symbol is not None:
            text = number(value) if value is not None else self._name(dag.symbols[dag.a[node]])
            self._spend(len(text))
            return text, _ATOM
        row = Op(dag.op[node]).row
        if dag.op[node] == Op.INVERTED:
            entry, column = dag.shown_inverse(node)
            return f"inv([{self.write(entry)[0]}, ..]){list(column)}", _ATOM
        if Op(dag.op[node]) in {Op.ADD, Op.SUB, Op.NEG}:
            return self.write(node)
        operands = [self.write(operand) for operand in dag.operands(node)]
        if row.infix is None and row.name:
            return f"{row.name}({', '.join(text for text, _ in operands)})", _ATOM
        if Op(dag.op[node]) is Op.SELECT:
            condition, yes, no = (text for text, _ in operands)
            return f"if {condition} then {yes} else {no}", _SUM
        assert row.infix is not None
        sides = [text if binding == _ATOM else f"({text})" for text, binding in operands]
        if len(sides) == 1:
            return f"{row.infix.symbol} {sides[0]}", _SUM
        return f" {row.infix.symbol} ".join(sides), _SUM

    def _spend(self, characters: int) -> None:
        self._left -= characters
        if self._left < 0:
            raise _TooLongError
