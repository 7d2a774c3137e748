"""Print expressions as C on ranges: interval arithmetic, by the functions of `bgc_ranges.h`."""

from __future__ import annotations

from bgc.algebra.dag import TABLE_OPS, Op
from bgc.algebra.operation import Bounds
from bgc.algebra.operations import ROWS
from bgc.emission.print_c import ATOM, Numbers, Printer
from bgc.ir.graph import Node

_MUL, _SYMBOL = int(Op.MUL), int(Op.SYMBOL)
_NAMES = {
    Op.ADD: "sum",
    Op.SUB: "difference",
    Op.MUL: "product",
    Op.DIV: "quotient",
    Op.NEG: "opposite",
    Op.POW: "power",
    Op.SELECT: "choice",
    Op.LT: "less",
    Op.LE: "at_most",
    Op.EQ: "equal",
    Op.AND: "both",
    Op.OR: "either",
    Op.NOT: "negation",
    Op.FMOD: "remainder",
}


class RangePrinter(Printer):
    """Prints nodes for `bgc_range`; every operation is a call."""

    table_prefix = "bgc_range_"

    def _constant(self, text: str) -> tuple[str, int]:
        return f"bgc_range_of({text})", ATOM

    def _write(self, node: Node) -> tuple[str, int]:
        op = self._op[node]
        if op in TABLE_OPS:
            return self._look_up(node), ATOM
        operands = [self._operand(x)[0] for x in self._dag.operands(node)]
        row = ROWS[op]
        if op == _MUL and operands[0] == operands[1]:
            return f"bgc_range_square({operands[0]})", ATOM
        if op in _NAMES:
            name = _NAMES[Op(op)]
        else:
            match row.bounds:
                case Bounds.RISING | Bounds.FALLING:
                    name = row.bounds.value
                    operands.insert(0, self._function(row))
                case Bounds.OWN:
                    name = row.name
                case Bounds.UNKNOWN:
                    return "bgc_range_unknown()", ATOM
        return f"bgc_range_{name}({', '.join(operands)})", ATOM


RANGES = Numbers("bgc_range", "ranges", "bgc_model", "bgc_range_", 100, 16, RangePrinter)
