"""Print a kernel as a table of operations, which a loop performs one after the other.

The C compiler takes some 50 us for an operation of straight-line code, even without optimisation,
and 2 us for a row of a table. The table takes twice as long to run, which does not count where
thousands of operations run once, when parameters are set.
"""

from __future__ import annotations

from collections.abc import Mapping

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.emission.kernels import KernelText, schedule
from bgc.emission.print_c import Printer, is_number_test, literal
from bgc.ir.graph import Node
from bgc.ir.lowered import Kernel

# Arrays of the function. A place is four times the index of an element and its array; the unused
# operands of a step are constant 0.
_CONSTANTS, _PARAMETERS, _RESULTS, _WORK = range(4)
_OPERANDS = ("a", "b", "c")
_PER_LINE = 4


def print_steps(dag: Dag, kernel: Kernel, head: str, known: Mapping[Node, int]) -> KernelText:
    """Print a kernel that computes elements of h from parameters; `head` begins the function.

    The nodes in `known` are not computed: it maps them to their elements of h.
    """
    steps = _Steps(dag, kernel, known)
    rows = [f"{{{', '.join(map(str, row))}}}" for row in steps.rows]
    lines = [", ".join(rows[k : k + _PER_LINE]) for k in range(0, len(rows), _PER_LINE)]
    table = ",\n        ".join(lines)
    constants = ", ".join(steps.constants) or "0.0"
    reads = "".join(
        f"        const double {name} = from[step[{k}] & 3][step[{k}] >> 2];\n"
        for k, name in enumerate(_OPERANDS[: steps.arity], 2)
    )
    cases = "".join(
        f"        case {number}:\n            *result = {text};\n            break;\n"
        for text, number in steps.operations.items()
    )
    text = (
        f"/* {kernel.purpose}\n * A step is an operation, the place of its result and those of its "
        f"operands. */\n{head}\n{{\n"
        f"    static const double constants[] = {{{constants}}};\n"
        f"    static const int steps[][5] = {{\n        {table}}};\n"
        "    const double *const from[] = {constants, p, h, w};\n"
        "    double *const to[] = {h, w};\n\n"
        f"    for (int k = 0; k < {len(rows)}; k++) {{\n"
        "        const int *const step = steps[k];\n"
        f"{reads}"
        "        double *const result = &to[(step[1] & 3) - 2][step[1] >> 2];\n\n"
        f"        switch (step[0]) {{\n{cases}        }}\n    }}\n}}\n"
    )
    helpers = frozenset(steps.printer.helpers)
    return KernelText(text, steps.work, len(steps.order), helpers)


class _Steps:
    """The rows of the table, and the texts of the operations and constants that they name."""

    def __init__(self, dag: Dag, kernel: Kernel, known: Mapping[Node, int]) -> None:
        self._dag = dag
        self.printer = Printer(dag, {})
        self.order = schedule(
            dag, [s.node for s in kernel.stores], int(Level.CONST) - 1, known.keys()
        ).order
        self.operations: dict[str, int] = {}  # text in a, b and c -> number
        self.constants: list[str] = []
        self.rows: list[tuple[int, ...]] = []
        self.work = self.arity = 0
        self._place = {node: 4 * index + _RESULTS for node, index in known.items()}
        self._free: list[int] = []
        targets: dict[Node, list[int]] = {}
        for store in kernel.stores:
            targets.setdefault(store.node, []).append(4 * store.index + _RESULTS)
        self._compute(targets)

    def _compute(self, targets: Mapping[Node, list[int]]) -> None:
        last = {x: node for node in self.order for x in self._operands(node)}
        for node in self.order:
            operands = self._operands(node)
            for name, operand in zip(_OPERANDS, operands, strict=False):
                self.printer.name(operand, name)
            text = self.printer.expression(node)
            places = [self._read(operand) for operand in operands]
            for operand in dict.fromkeys(operands):
                if last[operand] == node and self._place[operand] & 3 == _WORK:
                    self._free.append(self._place[operand])
            own = targets.get(node, ())
            self._place[node] = own[0] if own else self._slot()
            self._add(text, self._place[node], places)
            for other in own[1:]:
                self._add("a", other, [self._place[node]])
        for node in targets.keys() - set(self.order):
            for place in targets[node]:
                self._add("a", place, [self._read(node)])

    def _operands(self, node: Node) -> tuple[Node, ...]:
        """List the nodes that the text of a node reads; a test whether x is a number reads x."""
        dag = self._dag
        operands = dag.operands(node)
        if dag.op[node] == Op.SELECT and is_number_test(dag, operands[0]):
            return (dag.a[operands[0]], *operands[1:])
        return operands

    def _add(self, text: str, result: int, operands: list[int]) -> None:
        number = self.operations.setdefault(text, len(self.operations))
        self.arity = max(self.arity, len(operands))
        self.rows.append((number, result, *operands))

    def _slot(self) -> int:
        """A free element of w."""
        if not self._free:
            self._free.append(4 * self.work + _WORK)
            self.work += 1
        return self._free.pop()

    def _read(self, node: Node) -> int:
        """The place of a node, which is that of a constant or a parameter at first use."""
        if node not in self._place:
            value, symbol = self._dag.value(node), self._dag.symbol_of(node)
            if value is not None:
                self._place[node] = 4 * len(self.constants) + _CONSTANTS
                self.constants.append(literal(value))
            else:
                assert symbol is not None and symbol.kind in (Kind.PARAM, Kind.SELECTOR)
                self._place[node] = 4 * symbol.index + _PARAMETERS
        return self._place[node]
