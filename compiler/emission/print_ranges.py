"""Print expressions as C on ranges: interval arithmetic, by the functions of `bgc_ranges.h`."""

from __future__ import annotations

from bgc.algebra.dag import TABLE_OPS, Op
from bgc.algebra.intervals import UNKNOWN
from bgc.algebra.operations import ROWS
from bgc.emission.print_c import ATOM, Numbers, Printer
from bgc.ir.graph import Node

_MUL = int(Op.MUL)


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
        if row.bounds is UNKNOWN:
            operands = []
        elif row.bounds.takes_function:
            operands.insert(0, self._function(row))
        return f"bgc_range_{row.bounds.c}({', '.join(operands)})", ATOM


RANGES = Numbers("bgc_range", "ranges", "bgc_model", "bgc_range_", 100, 16, RangePrinter)
