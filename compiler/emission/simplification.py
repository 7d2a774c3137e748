"""Simplify the DAG of a program.

One pass over the required nodes, operands first, combines three simplifications:

- every operation is rebuilt by the rules of the DAG, which fold constants, zeros and ones;
- a quotient becomes a product with a reciprocal, which quotients with the same divisor share and
  which is computed once per run where the divisor is a parameter;
- nodes with equal or opposite values modulo a large prime at random points are merged (value
  numbering), which also detects expressions that are identically zero.

Literals remain exact, since rounding would prevent cancellations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.fingerprint import Fingerprints, negative
from bgc.ir.evaluation import evaluated_always
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Guard, Node
from bgc.ir.program import Program
from bgc.ir.unused import without_settled_jumps, without_unused_divisors

# As plain ints: comparing with a member of an enumeration takes several times longer.
_CONST, _SYMBOL, _ADD, _SUB, _MUL, _DIV, _NEG = map(
    int, (Op.CONST, Op.SYMBOL, Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG)
)
_EITHER = frozenset((Kind.STATE, Kind.START))  # a function of the C code is given one of these
_ARITHMETIC = frozenset((_ADD, _SUB, _MUL, _DIV, _NEG))  # exact on fingerprints
_FUNCTIONS = frozenset(int(op) for op in Op if op.row.curve is not None)  # may equal arithmetic


def optimise(program: Program) -> Program:
    """Return an equivalent program on a new DAG that contains only required nodes.

    A quotient of the model that cancels, as `x/x` does, leaves an assertion that its divisor is not
    zero. Assertions that parameters alone decide come first. Raises AssertionError if the
    fingerprint of an output changes.
    """
    roots = nodes_of(program)
    dag, new = number_values(program.dag, roots)
    smaller = without_unused_divisors(map_nodes(program, dag, new.__getitem__))
    smaller = without_settled_jumps(smaller)
    guards = (*smaller.guards, *_guards_of_cancelled(program.dag, roots, dag, new))
    return replace(
        smaller, guards=tuple(sorted(guards, key=lambda g: dag.level[g.condition] > Level.PARAM))
    )


def _guards_of_cancelled(
    old: Dag, roots: Sequence[Node], dag: Dag, new: Mapping[Node, Node]
) -> Iterator[Guard]:
    """Assertions for divisors that vary and that no quotient of the new graph has."""
    marked = [
        node
        for node in evaluated_always(old, roots)
        if old.op[node] == _DIV and node in old.places and old.level[old.b[node]] > Level.PARAM
    ]
    if not marked:
        return
    present = set(dag.reachable([new[root] for root in roots]))
    for node in marked:
        divisor = new[old.b[node]]
        reciprocal = dag.div(dag.one, divisor)
        if dag.op[reciprocal] == _NEG:
            reciprocal = dag.a[reciprocal]
        if dag.op[divisor] != _CONST and reciprocal not in present:
            place = old.places[node]
            yield Guard(divisor, f"`{place.text}` divides by zero", place)


def number_values(dag: Dag, roots: Sequence[Node]) -> tuple[Dag, dict[Node, Node]]:
    """Simplify the roots on a new DAG; also return the new node of every old node they need."""
    simple = Dag()
    values, after = Fingerprints(dag).values(), Fingerprints(simple)
    first: dict[int, Node] = {}  # fingerprint -> node
    new: dict[Node, Node] = {}
    read: list[int] = []  # of the nodes of `simple`: see `_kinds_read`
    folded: set[Node] = set()  # nodes whose fingerprint in `dag` is outdated by constant folding
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
        if (is_function or folded) and _is_folded(dag, simple, node, new, folded):
            folded.add(node)
            values[node] = after.value(made)
        _kinds_read(simple, read)
        new[node] = _representative(simple, first, read, values[node], made)
    for node in sorted((dag.places.keys() | dag.owners.keys()) & new.keys()):
        simple.mark_as(new[node], dag, node)
    now = after.values()
    for root in roots:
        assert now[new[root]] == values[root], f"node {root} changed its value"
    return simple, new


def _is_folded(dag: Dag, simple: Dag, node: Node, new: dict[Node, Node], folded: set[Node]) -> bool:
    """Return whether constant folding changes the fingerprint of a node.

    The fingerprint of a function is a hash of its operands, so it changes where an operand becomes
    a constant: `max(a - a + 2, 1)` becomes 2. Nodes that depend on such a function change too.
    """
    is_function = dag.op[node] not in _ARITHMETIC
    return any(
        x in folded or (is_function and dag.op[x] != _CONST and simple.op[new[x]] == _CONST)
        for x in dag.operands(node)
    )


def _remake(dag: Dag, simple: Dag, node: Node, new: dict[Node, Node]) -> Node:
    operands = tuple(new[x] for x in dag.operands(node))
    if dag.op[node] == _DIV and operands[1] != simple.zero:  # a zero divisor has been reported
        return simple.mul(operands[0], simple.div(simple.one, operands[1]))
    return simple.adopt(dag, node, operands)


def _kinds_read(dag: Dag, known: list[int]) -> None:
    """Add for each new node whether it reads states, and what the start solves for, as bits."""
    for node in range(len(known), len(dag.op)):
        symbol = dag.symbol_of(node)
        bits = 0 if symbol is None or symbol.kind not in _EITHER else 1 << symbol.kind
        for operand in dag.operands(node):
            bits |= known[operand]
        known.append(bits)


def _representative(
    dag: Dag, first: dict[int, Node], read: list[int], value: int, node: Node
) -> Node:
    """The representative of a node with this fingerprint: an equal node, a negation, or itself.

    The representative is the first node found, unless a later one reads less or has a lower level,
    or is a function and the first is arithmetic: `exp(x) - 1` loses the digits that `expm1(x)`
    keeps.
    """
    if dag.op[node] <= _SYMBOL:
        first[value] = node
        return node
    if value == 0:
        return dag.zero
    known = first.get(value)
    other = first.get(negative(value)) if known is None else known
    if (
        other is None
        or dag.level[node] < dag.level[other]
        or read[other] & ~read[node]
        or (dag.op[node] in _FUNCTIONS and dag.op[other] in _ARITHMETIC)
    ):
        first[value] = node
        return node
    return dag.neg(other) if known is None else other
