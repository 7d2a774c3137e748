"""Simplification of a program's graph.

Three things happen in one pass over the nodes that are needed, operands first:

- every operation is made again by the graph's own rules, which fold constants, zeros and ones;
- a quotient becomes a product with a reciprocal, which the quotients of one divisor share and
  which is computed once and for all where the divisor is a parameter;
- nodes that are equal, or opposite, modulo a large prime at random points become one
  (value numbering), which also finds expressions that are zero without looking it.

Literals stay exact: floats would lose cancellations.
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Dag, Op
from bgc.algebra.fingerprint import Fingerprints, negative
from bgc.ir.graph import Node
from bgc.ir.program import Program
from bgc.ir.program_nodes import map_program, program_roots

# As plain ints: comparing with a member of an enumeration takes several times longer.
_CONST, _SYMBOL, _ADD, _SUB, _MUL, _DIV, _NEG = map(
    int, (Op.CONST, Op.SYMBOL, Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG)
)
_ARITHMETIC = frozenset((_ADD, _SUB, _MUL, _DIV, _NEG))  # of fingerprints too


def optimise(program: Program) -> Program:
    """The program on a new graph that holds nothing else, with equal outputs.

    Raises AssertionError if an output has another fingerprint than before.
    """
    dag, new = number_values(program.dag, program_roots(program))
    return map_program(program, dag, new.__getitem__)


def number_values(dag: Dag, roots: Sequence[Node]) -> tuple[Dag, dict[Node, Node]]:
    """A new graph with the roots simplified, and the new node of every old one they need."""
    simple = Dag()
    values, after = Fingerprints(dag).values(), Fingerprints(simple)
    first: dict[int, Node] = {}  # fingerprint -> node
    new: dict[Node, Node] = {}
    computed: set[Node] = set()  # their values in `dag` are hashes of numbers now computed with
    op, a, b = dag.op, dag.a, dag.b
    for node in dag.reachable(roots):
        kind = op[node]
        if kind == _MUL:
            made = simple.mul(new[a[node]], new[b[node]])
        elif kind == _ADD:
            made = simple.add(new[a[node]], new[b[node]])
        elif kind == _SUB:
            made = simple.sub(new[a[node]], new[b[node]])
        else:
            made = _remake(dag, simple, node, new)
        is_function = kind not in _ARITHMETIC
        if (is_function or computed) and _is_computed(dag, simple, node, new, computed):
            computed.add(node)
            values[node] = after.value(made)
        new[node] = _known(simple, first, values[node], made)
    for node in sorted(dag.places.keys() & new.keys()):
        simple.mark(new[node], dag.places[node])
    now = after.values()
    for root in roots:
        assert now[new[root]] == values[root], f"node {root} changed its value"
    return simple, new


def _is_computed(
    dag: Dag, simple: Dag, node: Node, new: dict[Node, Node], computed: set[Node]
) -> bool:
    """Whether a function meets an operand that has turned out to be a number, or is of such.

    `max(a - a + 2, 1)` is 2, which no hash of the operands tells.
    """
    is_function = dag.op[node] not in _ARITHMETIC
    return any(
        x in computed or (is_function and dag.op[x] != _CONST and simple.op[new[x]] == _CONST)
        for x in dag.operands(node)
    )


def _remake(dag: Dag, simple: Dag, node: Node, new: dict[Node, Node]) -> Node:
    operands = tuple(new[x] for x in dag.operands(node))
    if dag.op[node] == _DIV and operands[1] != simple.zero:  # a zero divisor has been reported
        return simple.mul(operands[0], simple.div(simple.one, operands[1]))
    return simple.adopt(dag, node, operands)


def _known(dag: Dag, first: dict[int, Node], value: int, node: Node) -> Node:
    """The node to use for one with this value: an equal one, the opposite of one, or itself."""
    if dag.op[node] <= _SYMBOL:
        first[value] = node
        return node
    if value == 0:
        return dag.zero
    known = first.get(value)
    if known is None:
        opposite = first.get(negative(value))
        if opposite is None or dag.level[node] < dag.level[opposite]:
            first[value] = node
            return node
        return dag.neg(opposite)
    if dag.level[node] < dag.level[known]:
        first[value] = node
        return node
    return known
