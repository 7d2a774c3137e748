"""Expressions of the graph as C text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from bgc.algebra.dag import Dag, Kind, Op
from bgc.graph import Node

# How tightly a piece of text binds, as in C.
_CHOICE, _OR, _AND, _COMPARE, _SUM, _PRODUCT, _UNARY, _ATOM = range(8)

_FUNCTION: dict[int, str] = {
    Op.POW: "pow",
    Op.SIN: "sin",
    Op.COS: "cos",
    Op.TAN: "tan",
    Op.ASIN: "asin",
    Op.ACOS: "acos",
    Op.ATAN: "atan",
    Op.ATAN2: "atan2",
    Op.SINH: "sinh",
    Op.COSH: "cosh",
    Op.TANH: "tanh",
    Op.EXP: "exp",
    Op.LOG: "log",
    Op.SQRT: "sqrt",
    Op.ABS: "fabs",
    Op.SIGN: "model_sign",
    Op.MIN: "model_min",
    Op.MAX: "model_max",
    Op.FLOOR: "floor",
    Op.CEIL: "ceil",
    Op.FMOD: "fmod",
    Op.HYPOT: "hypot",
    Op.ASINH: "asinh",
    Op.ACOSH: "acosh",
    Op.ATANH: "atanh",
    Op.CBRT: "cbrt",
    Op.ERF: "erf",
    Op.LOG10: "log10",
    Op.EXPM1: "expm1",
    Op.LOG1P: "log1p",
}

# Functions that C lacks. A NaN goes through them: it must not turn into a plausible number.
HELPERS: dict[str, str] = {
    "model_max": (
        "static inline double model_max(double a, double b)\n"
        "{\n    return a > b || a != a ? a : b;\n}\n"
    ),
    "model_min": (
        "static inline double model_min(double a, double b)\n"
        "{\n    return a < b || a != a ? a : b;\n}\n"
    ),
    "model_sign": (
        "static inline double model_sign(double a)\n"
        "{\n    return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : a;\n}\n"
    ),
}

_ARRAY = {Kind.PARAM: "p", Kind.INPUT: "u", Kind.STATE: "x"}
_TRUTH = frozenset(map(int, (Op.LT, Op.LE, Op.EQ, Op.AND, Op.OR, Op.NOT)))

# As plain ints: comparing with a member of an enumeration takes several times longer.
_CONST, _SYMBOL, _ADD, _SUB, _MUL, _DIV, _NEG, _SELECT = map(
    int, (Op.CONST, Op.SYMBOL, Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.SELECT)
)


def literal(value: Fraction) -> str:
    """The double nearest to an exact value, in the fewest digits that read back as it."""
    try:
        return repr(float(value))
    except OverflowError:
        return "INFINITY" if value > 0 else "-INFINITY"


class Printer:
    """Text of nodes. Nodes that have a name are referred to, all others are written out.

    `used` collects the arrays (and `t`) that the text refers to, `helpers` the functions of
    `HELPERS` that it calls.
    """

    def __init__(self, dag: Dag, names: Mapping[Node, str]) -> None:
        self._dag = dag
        self._op, self._a, self._b, self._c = dag.op, dag.a, dag.b, dag.c
        self._names: dict[Node, str] = dict(names)
        self.used: set[str] = set()
        self.helpers: set[str] = set()

    def name(self, node: Node, text: str) -> None:
        """From here on, write `text` for the node."""
        self._names[node] = text

    def expression(self, node: Node) -> str:
        """The node's operation written out, even where the node has a name."""
        return self._write(node)[0]

    def leaf(self, node: Node) -> str:
        """A constant, a symbol or a node with a name."""
        return self._operand(node)[0]

    def _operand(self, node: Node) -> tuple[str, int]:
        name = self._names.get(node)
        if name is not None:
            if name[0] != "v":
                self.used.add(name[0])
            return name, _ATOM
        op = self._op[node]
        if op > _SYMBOL:
            return self._write(node)
        if op == _CONST:
            return self._constant(literal(self._dag.constants[self._a[node]]))
        symbol = self._dag.symbols[self._a[node]]
        if symbol.kind is Kind.TIME:
            self.used.add("t")
            return "t", _ATOM
        array = _ARRAY[symbol.kind]
        self.used.add(array)
        return f"{array}[{symbol.index}]", _ATOM

    def _within(self, node: Node, least: int) -> str:
        """The operand, in parentheses if it binds less tightly than `least`."""
        text, binding = self._operand(node)
        return text if binding >= least else f"({text})"

    def _write(self, node: Node) -> tuple[str, int]:
        op, a, b = self._op[node], self._a[node], self._b[node]
        if op == _MUL:
            for factor, other in ((a, b), (b, a)):
                divisor = self._open_reciprocal(other)
                if divisor is not None:
                    return f"{self._within(factor, _PRODUCT)} / {divisor}", _PRODUCT
            return f"{self._within(a, _PRODUCT)} * {self._within(b, _UNARY)}", _PRODUCT
        if op == _ADD:
            return f"{self._within(a, _SUM)} + {self._within(b, _PRODUCT)}", _SUM
        if op == _SUB:
            return f"{self._within(a, _SUM)} - {self._within(b, _PRODUCT)}", _SUM
        if op == _NEG:
            text, binding = self._operand(a)
            return (f"-{text}" if binding == _ATOM else f"-({text})"), _UNARY
        if op == _DIV:
            return f"{self._within(a, _PRODUCT)} / {self._within(b, _UNARY)}", _PRODUCT
        if op == _SELECT:
            return self._choice(node)
        if op in _TRUTH:
            return self._from_truth(self._truth(node)[0])
        second = f", {self._operand(b)[0]}" if b >= 0 else ""
        return f"{self._function(_FUNCTION[op])}({self._operand(a)[0]}{second})", _ATOM

    def _constant(self, text: str) -> tuple[str, int]:
        return text, _UNARY if text[0] == "-" else _ATOM

    def _choice(self, node: Node) -> tuple[str, int]:
        yes, no = self._within(self._b[node], _OR), self._within(self._c[node], _OR)
        return f"{self._condition(self._a[node], _OR)} ? {yes} : {no}", _CHOICE

    def _from_truth(self, text: str) -> tuple[str, int]:
        return f"(double)({text})", _UNARY

    def _function(self, name: str) -> str:
        if name in HELPERS:
            self.helpers.add(name)
        return name

    def _open_reciprocal(self, node: Node) -> str | None:
        """The divisor of a reciprocal that has no name: its product is one division."""
        if self._op[node] != _DIV or node in self._names:
            return None
        if self._dag.value(self._a[node]) != 1:
            return None
        return self._within(self._b[node], _UNARY)

    def _condition(self, node: Node, least: int) -> str:
        """A node as a C condition: true where it is not zero (a NaN is not)."""
        if self._op[node] in _TRUTH and node not in self._names:
            text, binding = self._truth(node)
        else:
            zero = self._constant("0.0")[0]
            text, binding = f"{self._within(node, _SUM)} != {zero}", _COMPARE
        return text if binding >= least else f"({text})"

    def _truth(self, node: Node) -> tuple[str, int]:
        """A comparison or a logical operation as a C condition."""
        op, a, b = self._op[node], self._a[node], self._b[node]
        if op == Op.NOT:
            return f"!{self._condition(a, _UNARY)}", _UNARY
        if op == Op.AND:
            return f"{self._condition(a, _COMPARE)} && {self._condition(b, _COMPARE)}", _AND
        if op == Op.OR:
            return f"{self._condition(a, _COMPARE)} || {self._condition(b, _COMPARE)}", _OR
        sign = {Op.LT: "<", Op.LE: "<=", Op.EQ: "=="}[Op(op)]
        return f"{self._within(a, _SUM)} {sign} {self._within(b, _SUM)}", _COMPARE


class LanePrinter(Printer):
    """The same for the vectors of `bgc_lanes.h`: a number for each instance of a batch.

    Conditions are masks, and both sides of a choice are computed.
    """

    def _constant(self, text: str) -> tuple[str, int]:
        return f"lane_of({text})", _ATOM

    def _choice(self, node: Node) -> tuple[str, int]:
        yes, no = self._operand(self._b[node])[0], self._operand(self._c[node])[0]
        return f"lane_select({self._condition(self._a[node], _CHOICE)}, {yes}, {no})", _ATOM

    def _from_truth(self, text: str) -> tuple[str, int]:
        return f"lane_select({text}, lane_of(1.0), lane_of(0.0))", _ATOM

    def _function(self, name: str) -> str:
        return f"lane_{name.removeprefix('model_')}"

    def _truth(self, node: Node) -> tuple[str, int]:
        op, a, b = self._op[node], self._a[node], self._b[node]
        if op == Op.NOT:
            return f"lane_not({self._condition(a, _CHOICE)})", _ATOM
        if op in {Op.AND, Op.OR}:
            sign = "&" if op == Op.AND else "|"
            return f"({self._condition(a, _ATOM)} {sign} {self._condition(b, _ATOM)})", _ATOM
        text, _ = super()._truth(node)
        return f"({text})", _ATOM


@dataclass(frozen=True, slots=True)
class Numbers:
    """What the numbers of emitted functions are: their C type, and how the text differs.

    `prefix` begins the names of functions that belong to one unit, `shared` of those that units
    share, `function` of mathematical ones. A long function is cut into parts of `part` operations.
    """

    type: str
    prefix: str
    shared: str
    function: str
    part: int
    printer: Callable[[Dag, Mapping[Node, str]], Printer]

    def constant(self, text: str) -> str:
        """A literal as such a number."""
        return f"{self.type}_of({text})" if self.function else text


DOUBLES = Numbers("double", "model", "bgc_model", "", 100, Printer)
LANES = Numbers("lane", "lanes", "bgc_lanes", "lane_", 250, LanePrinter)
