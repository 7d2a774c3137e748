r"""State equations as LaTeX: `align*` environments that need the package amsmath only.

Products and quotients become fractions and powers, rates carry dots. What is long, or used more
than once and not short, is an auxiliary quantity of its own, defined before it is used; so the
text grows in proportion to the graph.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import partial

from bgc.algebra.dag import Dag, Op, Symbol
from bgc.algebra.infix import number
from bgc.algebra.operation import Operation
from bgc.ir.graph import Node
from bgc.ir.program import Program
from bgc.printing.latex_names import dotted, latex_names

_LINE = 80  # visible characters of a line, about
_LONG = 30  # operations after which an expression is cut
_DENOMINATOR = 12  # the largest of a number that is set as a fraction
_SHORT = 4  # operations below which a repeated expression stays where it is
_SUM, _PRODUCT, _POWER, _ATOM = 1, 2, 3, 4
_AUXILIARY = (r"\eta", r"\xi", r"\zeta", r"\chi")


def latex_equations(program: Program, name: Callable[[Symbol], str]) -> str:
    """The state equations with their start, and what the scene observes."""
    text = _symbols(program, name)
    symbols = [text[state.name] for state in program.states]
    spell = partial(_spelled, text, name)
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
    return "\n".join(_align(title, lines) for title, lines in blocks if lines)


def _symbols(program: Program, name: Callable[[Symbol], str]) -> dict[str, str]:
    """The LaTeX of all that is named, each different from the others."""
    states, observed = program.states, program.observations
    roots = [node for state in states for node in (state.initial, state.derivative)]
    roots += [o.node for o in observed] + [entry.value for entry in program.mass or ()]
    symbols = map(program.dag.symbol_of, program.dag.reachable(roots))
    read = [name(symbol) for symbol in symbols if symbol is not None]
    return latex_names([s.name for s in states] + [o.name for o in observed] + read)


def _spelled(text: Mapping[str, str], name: Callable[[Symbol], str], symbol: Symbol) -> str:
    return text[name(symbol)]


_Terms = list[str]  # of a sum, each but the first with its sign


def _align(title: str, equations: Sequence[tuple[str, _Terms]]) -> str:
    lines = " \\\\\n".join(f"  {left} &= {_broken(terms)}" for left, terms in equations)
    return f"% {title}\n\\begin{{align*}}\n{lines}\n\\end{{align*}}\n"


def _broken(terms: _Terms) -> str:
    """A sum over as many lines as it needs."""
    lines, width = [""], 0
    for term in terms:
        size = _visible(term)
        if width and width + size > _LINE:
            lines.append("")
            width = 0
        lines[-1] += term if not lines[-1] else f" {term}"
        width += size
    return " \\\\\n      &\\quad ".join(lines)


def _visible(text: str) -> int:
    """About how many characters wide a formula is; a fraction counts once."""
    return len(re.sub(r"\\(?:mathrm|mathit|frac|left|right|,|[a-z]+)|[{}_^\\ ]", "", text))


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
    """The text of nodes; what is named is in `auxiliaries`, in the order of its need."""

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
        for node in self._worth_a_name(order, roots):
            terms = self.terms(node)
            symbol = f"{letter}_{{{len(self.auxiliaries) + 1}}}"
            self.auxiliaries.append((symbol, terms))
            self._text[node] = (symbol, _ATOM)
            self._named.add(node)

    def _worth_a_name(self, order: Iterable[Node], roots: Sequence[Node]) -> list[Node]:
        """Nodes to name: long ones, repeated ones that are not short, choices; operands first."""
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
            if repeated or chosen or (size[node] > _LONG and node not in roots):
                named.append(node)
                size[node] = 0
        return named

    # --- sums -------------------------------------------------------------------------------

    def terms(self, node: Node) -> _Terms:
        """The terms of a sum as text, with their signs; equal ones together."""
        found: dict[Node, int] = {}
        self._collect(node, found)
        texts: _Terms = []
        for term, count in found.items():
            if count == 0:
                continue
            negative, text = self._times(count, term)
            if not texts:
                texts.append(f"-{text}" if negative else text)
            else:
                texts.append(f"- {text}" if negative else f"+ {text}")
        return texts or ["0"]

    def _collect(self, node: Node, found: dict[Node, int]) -> None:
        """Count the terms of a sum, in order; those taken away count negative."""
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
        """A term that is there `count` times: whether it is negative, and the rest."""
        return self._fraction(Fraction(count), *self._factors(node))

    # --- all else ---------------------------------------------------------------------------

    def bracketed(self, node: Node, needed: int) -> str:
        """The text of a node, in brackets where it binds less than needed."""
        text, strength = self._of(node)
        return text if strength >= needed else rf"\left({text}\right)"

    def _of(self, node: Node) -> tuple[str, int]:
        """Text and binding strength; the operands' are known, or are found first."""
        stack = [node]
        while stack:
            top = stack[-1]
            missing = [x for x in self._dag.operands(top) if x not in self._text]
            if top in self._text or not missing:
                stack.pop()
                if top not in self._text:
                    self._text[top] = self._make(top)
            else:
                stack.extend(missing)
        return self._text[node]

    def _make(self, node: Node) -> tuple[str, int]:
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
        texts = [self._text[x][0] for x in operands]
        if op is Op.POW:
            return f"{self.bracketed(operands[0], _ATOM)}^{{{texts[1]}}}", _POWER
        if op is Op.SELECT:
            return (
                rf"\begin{{cases}} {texts[1]} & \text{{if }} {texts[0]} \\ "
                rf"{texts[2]} & \text{{otherwise}} \end{{cases}}"
            ), _ATOM
        return self._function(op.row, operands)

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
        """A product as a number, and factors with their exponents, in order."""
        number_, exponents = Fraction(1), dict[Node, int]()
        stack = [(node, 1)]
        while stack:
            inner, sign = stack.pop()
            op, value = self._dag.op[inner], self._dag.value(inner)
            if value is not None and value != 0:
                number_ *= value**sign
            elif inner in self._named or op not in {Op.MUL, Op.DIV, Op.NEG}:
                exponents[inner] = exponents.get(inner, 0) + sign
            else:
                number_ *= -1 if op == Op.NEG else 1
                signs = [sign, -sign if op == Op.DIV else sign]
                operands = self._dag.operands(inner)
                stack.extend(reversed(list(zip(operands, signs, strict=False))))
        return number_, exponents

    def _fraction(
        self, times: Fraction, number_: Fraction, exponents: dict[Node, int]
    ) -> tuple[bool, str]:
        """Factors as one fraction: whether it is negative, and the rest."""
        number_ *= times
        size = abs(number_)
        split = size.denominator <= _DENOMINATOR
        above = Fraction(size.numerator) if split else size
        below = Fraction(size.denominator) if split else Fraction(1)
        top = self._powers(above, {x: n for x, n in exponents.items() if n > 0})
        bottom = self._powers(below, {x: -n for x, n in exponents.items() if n < 0})
        text = top if bottom == "1" else rf"\frac{{{top}}}{{{bottom}}}"
        return number_ < 0, text

    def _powers(self, number_: Fraction, factors: dict[Node, int]) -> str:
        """A number and factors side by side."""
        alone = number_ == 1 and list(factors.values()) == [1]
        texts = [] if number_ == 1 and factors else [_number(number_)[0]]
        for x, count in factors.items():
            text = self.bracketed(x, _SUM if alone else _PRODUCT if count == 1 else _ATOM)
            texts.append(text if count == 1 else f"{text}^{{{count}}}")
        return r"\,".join(texts)


def _number(value: Fraction) -> tuple[str, int]:
    """A number in decimals, or as a power of ten."""
    text = number(value)
    mantissa, _, exponent = text.partition("e")
    strength = _SUM if value < 0 else _ATOM
    if not exponent:
        return text, strength
    power = rf"10^{{{int(exponent)}}}"
    if mantissa in {"1.0", "-1.0"}:
        return mantissa[:-3] + power, min(strength, _POWER)
    return rf"{mantissa} \cdot {power}", min(strength, _PRODUCT)
