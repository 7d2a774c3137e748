"""Print expressions of the DAG as C."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction

from bgc.algebra.dag import TABLE_OPS, Dag, Kind, Op
from bgc.algebra.operation import Lanes, Operation
from bgc.algebra.operations import ROWS
from bgc.algebra.table import orders_of
from bgc.ir.graph import Node
from bgc.record_class import dataclass

# Precedence of a piece of C text, ascending.
_CHOICE, _COMPARE, _SUM, _PRODUCT, _UNARY, ATOM = range(6)


def function_text(number: str, name: str, arity: int, formula: str) -> str:
    """A C function that returns a formula in its arguments `a` (and `b`) of type `number`."""
    arguments = ", ".join(f"{number} {x}" for x in "ab"[:arity])
    return f"static inline {number} {name}({arguments})\n{{\n    return {formula};\n}}\n"


# Functions that are missing in C, defined in each unit that calls them.
HELPERS: dict[str, str] = {
    row.c: function_text("double", row.c, row.arity, row.c_formula) for row in ROWS if row.c_formula
}
HELPERS |= {row.c: f'#include "{row.c_header}"\n' for row in ROWS if row.c_header}

_ARRAY = {
    Kind.PARAM: "p",
    Kind.SELECTOR: "p",
    Kind.INPUT: "u",
    Kind.STATE: "x",
    Kind.START: "s",
    Kind.RATE: "r",
    Kind.CHANGE: "d",
    Kind.HOISTED_CHANGE: "q",
}

# As plain ints: comparing with a member of an enumeration takes several times longer.
_CONST, _SYMBOL, _ADD, _SUB, _MUL, _DIV, _NEG, _SELECT = map(
    int, (Op.CONST, Op.SYMBOL, Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.SELECT)
)


def literal(value: Fraction) -> str:
    """The double nearest to an exact value, in the shortest text that reads back exactly."""
    try:
        return repr(float(value))
    except OverflowError:
        return "INFINITY" if value > 0 else "-INFINITY"


def is_number_test(dag: Dag, node: Node) -> bool:
    """Return whether a condition is `x == x`, which is false if x is NaN."""
    return dag.op[node] == Op.EQ and dag.a[node] == dag.b[node]


class Printer:
    """Prints nodes as C: named nodes by their name, all others as expressions.

    A condition is 1, 0, or NaN if undefined; a choice with an undefined condition is NaN. The
    condition of a choice must have a name, since it is read twice. `used` collects the arrays (and
    `t`) that the text reads, `helpers` the functions that the unit has to define or declare.
    """

    table_prefix = "bgc_"  # of the functions that look tables up

    def __init__(self, dag: Dag, names: Mapping[Node, str]) -> None:
        self._dag = dag
        self._op, self._a, self._b, self._c = dag.op, dag.a, dag.b, dag.c
        self._names: dict[Node, str] = dict(names)
        self.used: set[str] = set()
        self.helpers: set[str] = set()

    def name(self, node: Node, text: str) -> None:
        """Print the node as `text` from now on."""
        self._names[node] = text

    def expression(self, node: Node) -> str:
        """The node as an expression, even if it has a name."""
        return self._write(node)[0]

    def leaf(self, node: Node) -> str:
        """A constant, a symbol or a node with a name."""
        return self._operand(node)[0]

    def _operand(self, node: Node) -> tuple[str, int]:
        name = self._names.get(node)
        if name is not None:
            if name[0] != "v":
                self.used.add(name[0])
            return name, ATOM
        op = self._op[node]
        if op > _SYMBOL:
            return self._write(node)
        if op == _CONST:
            return self._constant(literal(self._dag.constants[self._a[node]]))
        symbol = self._dag.symbols[self._a[node]]
        if symbol.kind is Kind.TIME:
            self.used.add("t")
            return "t", ATOM
        array = _ARRAY[symbol.kind]
        self.used.add(array)
        return f"{array}[{symbol.index}]", ATOM

    def _within(self, node: Node, least: int) -> str:
        """The operand, in parentheses if its precedence is below `least`."""
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
            return (f"-{text}" if binding == ATOM else f"-({text})"), _UNARY
        if op == _DIV:
            return f"{self._within(a, _PRODUCT)} / {self._within(b, _UNARY)}", _PRODUCT
        if op == _SELECT:
            return self._choice(node)
        if op in TABLE_OPS:
            return self._look_up(node), ATOM
        second = f", {self._operand(b)[0]}" if b >= 0 else ""
        return f"{self._function(ROWS[op])}({self._operand(a)[0]}{second})", ATOM

    def _look_up(self, node: Node) -> str:
        """The call that looks a table up: its name, orders of the derivative, and arguments."""
        dag, op = self._dag, self._op[node]
        table = dag.table_of(node)
        orders = orders_of(int(dag.constants[self._a[self._a[node]]]))
        shown = {Op.PLACE: (), Op.LOOKUP2: orders}.get(Op(op), orders[:1])
        name = f"&bgc_model_table_{list(dag.tables).index(table.number)}"
        arguments = [self._operand(x)[0] for x in dag.operands(node)[1:]]
        function = self.table_prefix + ROWS[op].c.removeprefix("bgc_")
        return f"{function}({', '.join([name, *map(str, shown), *arguments])})"

    def _constant(self, text: str) -> tuple[str, int]:
        return text, _UNARY if text[0] == "-" else ATOM

    def _choice(self, node: Node) -> tuple[str, int]:
        condition = self._a[node]
        yes, no = self._within(self._b[node], _COMPARE), self._within(self._c[node], _COMPARE)
        if is_number_test(self._dag, condition):
            mode = self._operand(self._a[condition])[0]
            pieces = self._pieces(node)
            if pieces is not None:
                first, second = (self._within(piece, _COMPARE) for piece in pieces)
                return f"{mode} >= 1.0 ? {first} : {mode} < 1.0 ? {second} : {no}", _CHOICE
            return f"{mode} == {mode} ? {yes} : {no}", _CHOICE
        truth = self._operand(condition)[0]
        return f"{truth} == 0.0 ? {no} : {truth} == {truth} ? {yes} : {truth}", _CHOICE

    def _pieces(self, node: Node) -> tuple[Node, Node] | None:
        """The pieces of a kink in mode 1 and 0, in a choice between them and the operation.

        Its mode is 1, 0 or NaN, so that ordered comparisons tell these apart at the least cost.
        """
        mode, held = self._a[self._a[node]], self._b[node]
        if self._op[held] != _SELECT or self._a[held] != mode or held in self._names:
            return None
        return self._b[held], self._c[held]

    def _function(self, row: Operation) -> str:
        if row.c in HELPERS:
            self.helpers.add(row.c)
        return row.c

    def _open_reciprocal(self, node: Node) -> str | None:
        """The divisor if a node is an unnamed reciprocal, whose product is one division."""
        if self._op[node] != _DIV or node in self._names:
            return None
        if self._dag.value(self._a[node]) != 1:
            return None
        return self._within(self._b[node], _UNARY)


class LanePrinter(Printer):
    """Prints nodes for the vectors of `bgc_lanes.h`; both operands of a choice are computed."""

    table_prefix = "lane_"

    def _constant(self, text: str) -> tuple[str, int]:
        return f"lane_of({text})", ATOM

    def _choice(self, node: Node) -> tuple[str, int]:
        condition = self._a[node]
        yes, no = self._operand(self._b[node])[0], self._operand(self._c[node])[0]
        if is_number_test(self._dag, condition):
            mode = self._operand(self._a[condition])[0]
            pieces = self._pieces(node)
            if pieces is not None:
                first, second = (self._operand(piece)[0] for piece in pieces)
                yes = f"lane_select({mode} == lane_of(0.0), {second}, {first})"
            return f"lane_select({mode} == {mode}, {yes}, {no})", ATOM
        return f"lane_choose({self._operand(condition)[0]}, {yes}, {no})", ATOM

    def _function(self, row: Operation) -> str:
        name = lane_name(row)
        if row.lanes is not Lanes.HEADER:
            self.helpers.add(name)
        return name


def lane_name(row: Operation) -> str:
    """The name of an operation's function on vector registers."""
    return f"lane_{row.c.removeprefix('model_')}"


@dataclass(frozen=True, slots=True)
class Numbers:
    """The C type of the numbers of emitted functions, and the differences that follow from it.

    `prefix` is that of static functions, `shared` that of functions shared between units,
    `function` that of mathematical functions. A long function is split into parts of `part`
    operations. `reach` is the distance from a pointer that has a short encoding (`windows.py`).
    `factors` is the type of the factors that `solve` reads, that of the numbers where it is empty.
    """

    type: str
    prefix: str
    shared: str
    function: str
    part: int
    reach: int
    printer: Callable[[Dag, Mapping[Node, str]], Printer]
    factors: str = ""

    def constant(self, text: str) -> str:
        """A literal of this type."""
        return f"{self.type}_of({text})" if self.function else text


DOUBLES = Numbers("double", "model", "bgc_model", "", 200, 16, Printer)
LANES = Numbers("lane", "lanes", "bgc_lanes", "lane_", 250, 128, LanePrinter)
