r"""Typeset state equations in LaTeX: `align*` environments, which require only amsmath.

Products and quotients become fractions and powers, rates have dots. An expression that is long, or
not short and used repeatedly, becomes an auxiliary quantity, defined before it is used. The length
of the text is therefore proportional to the size of the DAG.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import partial

from bgc.algebra.dag import TABLE_OPS, Dag, Op, Symbol
from bgc.algebra.discontinuities import is_segment
from bgc.algebra.infix import number
from bgc.algebra.operation import Operation
from bgc.ir.graph import Node
from bgc.ir.program import Program
from bgc.printing.align import aligned, broken_sum, signed
from bgc.printing.latex_names import dotted, latex_names

_LONG = 30  # operations above which an expression becomes an auxiliary quantity
_DENOMINATOR = 12  # largest denominator of a number that is typeset as a fraction
_SHORT = 4  # operations below which a repeated expression is written out
_SUM, _PRODUCT, _POWER, _ATOM = 1, 2, 3, 4
_AUXILIARY = (r"\eta", r"\xi", r"\zeta", r"\chi")


def latex_equations(program: Program, name: Callable[[Symbol], str]) -> str:
    """Typeset the initial values, the state equations and the observations of the scene."""
    text = _symbols(program, name)
    symbols = [text[state.name] for state in program.states]
    spell = partial(_symbol_text, text, name)
    left = _left_sides(program, symbols, spell)
    equations = [
        *zip(left, (state.derivative for state in program.states), strict=True),
        *((text[o.name], o.node) for o in program.observations),
    ]
    start = [
        (f"{symbol}(0)", state.initial)
        for symbol, state in zip(symbols, program.states, strict=True)
        if state.initial != program.dag.zero
    ]
    printer = _Printer(program.dag, spell, [node for _, node in (*start, *equations)])
    bodies = [(left_side, printer.terms(node)) for left_side, node in (*start, *equations)]
    first, second = len(start), len(start) + len(left)
    blocks = (
        ("auxiliary quantities", printer.auxiliaries),
        ("start; states that are not listed start at zero", bodies[:first]),
        ("equations", bodies[first:second]),
        ("observed", bodies[second:]),
    )
    return "\n".join(
        aligned(title, [(left_side, broken_sum(terms)) for left_side, terms in lines])
        for title, lines in blocks
        if lines
    )


def _symbols(program: Program, name: Callable[[Symbol], str]) -> dict[str, str]:
    """Distinct LaTeX symbols of all names in the equations."""
    states, observed = program.states, program.observations
    roots = [node for state in states for node in (state.initial, state.derivative)]
    roots += [o.node for o in observed] + [entry.value for entry in program.mass or ()]
    symbols = map(program.dag.symbol_of, program.dag.reachable(roots))
    read = [name(symbol) for symbol in symbols if symbol is not None]
    return latex_names([s.name for s in states] + [o.name for o in observed] + read)


def _symbol_text(text: Mapping[str, str], name: Callable[[Symbol], str], symbol: Symbol) -> str:
    return text[name(symbol)]


_Terms = list[str]  # terms of a sum, each except the first with its sign


def _left_sides(
    program: Program, symbols: Sequence[str], name: Callable[[Symbol], str]
) -> list[str]:
    rates = [dotted(symbol) for symbol in symbols]
    if program.mass is None:
        return rates
    rows: list[list[str]] = [[] for _ in program.states]
    for entry in program.mass:
        factor = _Printer(program.dag, name, []).bracketed(entry.value, _PRODUCT)
        rate = rates[entry.column]
        rows[entry.row].append(rate if factor == "1" else rf"{factor}\,{rate}")
    return [" + ".join(row) or "0" for row in rows]


class _Printer:
    """Typesets nodes; `auxiliaries` are the auxiliary quantities, operands first."""

    def __init__(self, dag: Dag, name: Callable[[Symbol], str], roots: Sequence[Node]) -> None:
        self._dag = dag
        self._name = name
        self._text: dict[Node, tuple[str, int]] = {}
        self._named: set[Node] = set()
        self.auxiliaries: list[tuple[str, _Terms]] = []
        order = dag.reachable(roots)
        taken = {name(s) for s in map(dag.symbol_of, order) if s is not None}
        free = (a for a in _AUXILIARY if not any(text.startswith(a) for text in taken))
        letter = next(free, r"\mathcal{A}")
        for node in self._nodes_to_name(order, roots):
            terms = self.terms(node)
            symbol = f"{letter}_{{{len(self.auxiliaries) + 1}}}"
            self.auxiliaries.append((symbol, terms))
            self._text[node] = (symbol, _ATOM)
            self._named.add(node)

    def _nodes_to_name(self, order: Iterable[Node], roots: Sequence[Node]) -> list[Node]:
        """Long nodes, repeated nodes that are not short, and choices, operands first."""
        dag = self._dag
        order = list(order)
        uses = Counter(operand for node in order for operand in dag.operands(node))
        uses.update(roots)
        size: dict[Node, int] = {}
        named = []
        for node in order:
            operands = dag.operands(node)
            size[node] = 1 + sum(size[x] for x in operands) if operands else 0
            if dag.op[node] == Op.NEG:
                size[node] -= 1
            repeated = uses[node] > 1 and size[node] >= _SHORT and dag.op[node] != Op.NEG
            chosen = dag.op[node] == Op.SELECT and node not in roots
            if dag.op[node] in (Op.PLACE, Op.LISTED) or is_segment(dag, node):
                size[node] = 0  # of a table, or a matrix, which prints its argument alone
            elif repeated or chosen or (size[node] > _LONG and node not in roots):
                named.append(node)
                size[node] = 0
        return named

    # --- sums -------------------------------------------------------------------------------

    def terms(self, node: Node) -> _Terms:
        """The terms of a sum as text with their signs; equal terms are combined."""
        found: dict[Node, int] = {}
        self._collect(node, found)
        return signed(self._times(count, term) for term, count in found.items() if count) or ["0"]

    def _collect(self, node: Node, found: dict[Node, int]) -> None:
        """Count the terms of a sum, in order; subtracted terms count as negative."""
        stack = [(node, 1)]
        while stack:
            inner, sign = stack.pop()
            op = self._dag.op[inner]
            if op not in {Op.ADD, Op.SUB, Op.NEG} or inner in self._named:
                found[inner] = found.get(inner, 0) + sign
                continue
            operands = self._dag.operands(inner)
            signs = [-sign if op == Op.NEG else sign, -sign if op == Op.SUB else sign]
            stack.extend(reversed(list(zip(operands, signs, strict=False))))

    def _times(self, count: int, node: Node) -> tuple[bool, str]:
        """A term times `count`: True if it is negative, and its text without the sign."""
        return self._fraction(Fraction(count), *self._factors(node))

    # --- other operations -------------------------------------------------------------------

    def bracketed(self, node: Node, needed: int) -> str:
        """The text of a node, in brackets if its precedence is below `needed`."""
        text, strength = self._text_of(node)
        return text if strength >= needed else rf"\left({text}\right)"

    def _text_of(self, node: Node) -> tuple[str, int]:
        """The text and precedence of a node, without recursion: operands are composed first."""
        stack = [node]
        while stack:
            top = stack[-1]
            missing = [x for x in self._dag.operands(top) if x not in self._text]
            if top in self._text or not missing:
                stack.pop()
                if top not in self._text:
                    self._text[top] = self._compose(top)
            else:
                stack.extend(missing)
        return self._text[node]

    def _compose(self, node: Node) -> tuple[str, int]:
        dag = self._dag
        value, symbol = dag.value(node), dag.symbol_of(node)
        if value is not None:
            return _number(value)
        if symbol is not None:
            return self._name(symbol), _ATOM
        op, operands = Op(dag.op[node]), dag.operands(node)
        if op in {Op.ADD, Op.SUB, Op.NEG}:
            return " ".join(self.terms(node)), _SUM
        if op in {Op.MUL, Op.DIV}:
            return self._product(node)
        if op in TABLE_OPS:
            return self._look_up(node), _POWER
        if op is Op.LISTED:
            return "", _ATOM  # shown by its first entry
        if op is Op.INVERTED:
            entry, (row, column) = dag.shown_inverse(node)
            matrix = rf"\begin{{bmatrix}} {self._text_of(entry)[0]} & \cdots \end{{bmatrix}}"
            return rf"\left({matrix}^{{-1}}\right)_{{{row},{column}}}", _ATOM
        texts = [self._text[x][0] for x in operands]
        if op is Op.POW:
            return f"{self.bracketed(operands[0], _ATOM)}^{{{texts[1]}}}", _POWER
        if op is Op.SELECT:
            return (
                rf"\begin{{cases}} {texts[1]} & \text{{if }} {texts[0]} \\ "
                rf"{texts[2]} & \text{{otherwise}} \end{{cases}}"
            ), _ATOM
        return self._function(op.row, operands)

    def _look_up(self, node: Node) -> str:
        """A table of data: its name, then its arguments."""
        source, marks, arguments = self._dag.shown_look_up(node)
        plain = re.sub(r"([&%$#_{}])", r"\\\1", re.sub(r"[\\^~]", " ", source))
        suffix = f"_{{{marks}}}" if marks.strip("'") else marks
        texts = [rf"\text{{{plain}}}", *(self._text[x][0] for x in arguments)]
        return rf"\operatorname{{interpolate}}{suffix}\left({', '.join(texts)}\right)"

    def _function(self, row: Operation, operands: Sequence[Node]) -> tuple[str, int]:
        """A function or relation in the notation of its row."""
        if "#" not in row.latex:
            arguments = ", ".join(self._text[x][0] for x in operands)
            return rf"{row.latex}\left({arguments}\right)", _POWER
        is_open = row.latex.endswith("#")  # a relation or a negation
        needed = 0 if not is_open else _ATOM if row.arity == 1 else _SUM
        first, *rest = row.latex.split("#")
        texts = (self.bracketed(x, needed) + after for x, after in zip(operands, rest, strict=True))
        return first + "".join(texts), 0 if is_open else _ATOM

    def _product(self, node: Node) -> tuple[str, int]:
        """A product or quotient as one fraction of powers."""
        negative, text = self._fraction(Fraction(1), *self._factors(node))
        return (f"-{text}", _SUM) if negative else (text, _PRODUCT)

    def _factors(self, node: Node) -> tuple[Fraction, dict[Node, int]]:
        """A product as a coefficient, and factors with their exponents, in order."""
        coefficient, exponents = Fraction(1), dict[Node, int]()
        stack = [(node, 1)]
        while stack:
            inner, sign = stack.pop()
            op, value = self._dag.op[inner], self._dag.value(inner)
            if value is not None and value != 0:
                coefficient *= value**sign
            elif inner in self._named or op not in {Op.MUL, Op.DIV, Op.NEG}:
                exponents[inner] = exponents.get(inner, 0) + sign
            else:
                coefficient *= -1 if op == Op.NEG else 1
                signs = [sign, -sign if op == Op.DIV else sign]
                operands = self._dag.operands(inner)
                stack.extend(reversed(list(zip(operands, signs, strict=False))))
        return coefficient, exponents

    def _fraction(
        self, times: Fraction, coefficient: Fraction, exponents: dict[Node, int]
    ) -> tuple[bool, str]:
        """Factors as one fraction: True if it is negative, and its text without the sign."""
        coefficient *= times
        size = abs(coefficient)
        split = size.denominator <= _DENOMINATOR
        above = Fraction(size.numerator) if split else size
        below = Fraction(size.denominator) if split else Fraction(1)
        top = self._powers(above, {x: n for x, n in exponents.items() if n > 0})
        bottom = self._powers(below, {x: -n for x, n in exponents.items() if n < 0})
        text = top if bottom == "1" else rf"\frac{{{top}}}{{{bottom}}}"
        return coefficient < 0, text

    def _powers(self, coefficient: Fraction, factors: dict[Node, int]) -> str:
        """A coefficient and factors in a row; the coefficient one is omitted."""
        alone = coefficient == 1 and list(factors.values()) == [1]
        texts = [] if coefficient == 1 and factors else [_number(coefficient)[0]]
        for x, count in factors.items():
            text = self.bracketed(x, _SUM if alone else _PRODUCT if count == 1 else _ATOM)
            texts.append(text if count == 1 else f"{text}^{{{count}}}")
        return r"\,".join(texts)


def _number(value: Fraction) -> tuple[str, int]:
    """A number in decimals or scientific notation, and its precedence."""
    text = number(value)
    mantissa, _, exponent = text.partition("e")
    strength = _SUM if value < 0 else _ATOM
    if not exponent:
        return text, strength
    power = rf"10^{{{int(exponent)}}}"
    if mantissa in {"1.0", "-1.0"}:
        return mantissa[:-3] + power, min(strength, _POWER)
    return rf"{mantissa} \cdot {power}", min(strength, _PRODUCT)
