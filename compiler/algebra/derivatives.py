"""Forward and reverse differentiation with the rules of `operations`.

Where a function has no derivative (`abs` and `sqrt` at 0, a switch), the rules give that of one
side, or zero. The result is always finite, and so are the Jacobians of `abs(v)*v` and of a norm at
rest.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isqrt

from bgc.algebra.dag import Dag, Op
from bgc.algebra.nodes import Node
from bgc.algebra.operations import ROWS

CHOICES = frozenset(int(op) for op in Op if op.row.choice is not None)

_INVERTED = int(Op.INVERTED)

Partials = tuple[tuple[Node, Node], ...]


def directional_derivative(dag: Dag, node: Node, direction: Mapping[Node, Node]) -> Node:
    """Differentiate a node along a direction: the sum over symbols s of dnode/ds direction[s]."""
    (derivative,) = directional_derivatives(dag, [node], direction)
    return derivative


def directional_derivatives(
    dag: Dag, nodes: Sequence[Node], direction: Mapping[Node, Node]
) -> list[Node]:
    """Differentiate several nodes along a direction; what they share is differentiated once.

    `direction` may hold nodes that are no symbols: those are taken as independent.
    """
    tangent: dict[Node, Node] = {}
    for inner in dag.reachable(nodes):
        if inner in direction:
            tangent[inner] = direction[inner]
        elif not tangent.keys().isdisjoint(_arguments(dag, inner)):
            change = _change(dag, inner, tangent)
            if change != dag.zero:
                tangent[inner] = change
    return [tangent.get(node, dag.zero) for node in nodes]


def gradient(dag: Dag, node: Node, symbols: Iterable[Node]) -> list[Node]:
    """The derivatives of a node by several symbols, by reverse differentiation."""
    symbols = list(symbols)
    adjoint: dict[Node, Node] = {node: dag.one}
    lowest = min((dag.level[symbol] for symbol in symbols), default=0)
    for inner in reversed(dag.reachable([node])):
        weight = adjoint.get(inner)
        if weight is not None and not (dag.op[inner] == _INVERTED and dag.level[inner] < lowest):
            for operand, share in adjoint_shares(dag, inner, weight):
                adjoint[operand] = dag.add(adjoint.get(operand, dag.zero), share)
    return [adjoint.get(symbol, dag.zero) for symbol in symbols]


def _change(dag: Dag, node: Node, tangent: Mapping[Node, Node]) -> Node:
    if dag.op[node] in CHOICES:
        condition, yes, no = choice(dag, node)
        zero = dag.zero
        return dag.select(condition, tangent.get(yes, zero), tangent.get(no, zero))
    return dag.sum(
        dag.mul(partial, tangent[operand])
        for operand, partial in partials(dag, node)
        if operand in tangent
    )


def adjoint_shares(dag: Dag, node: Node, weight: Node) -> Partials:
    """Operands of a node, each with its share of the node's adjoint `weight`."""
    if dag.op[node] in CHOICES:
        condition, yes, no = choice(dag, node)
        zero = dag.zero
        return (
            (yes, dag.select(condition, weight, zero)),
            (no, dag.select(condition, zero, weight)),
        )
    return tuple((operand, dag.mul(partial, weight)) for operand, partial in partials(dag, node))


def choice(dag: Dag, node: Node) -> tuple[Node, Node, Node]:
    """A node among `CHOICES` as a condition, the result where it holds, the result elsewhere."""
    rule = ROWS[dag.op[node]].choice
    assert rule is not None
    return rule(dag, *dag.operands(node))


def partials(dag: Dag, node: Node) -> Partials:
    """Operands of a node (not one of `CHOICES`), each with the node's derivative by it.

    An operand that is there twice (`x * x`) is listed twice. Operands by which the derivative is
    zero may be left out.
    """
    if dag.op[node] == _INVERTED:
        return _partials_of_inverse(dag, node)
    rule, operands = ROWS[dag.op[node]].partials, dag.operands(node)
    if not operands:
        return ()
    assert rule is not None, f"{Op(dag.op[node]).name} has the derivative of what it chooses"
    return tuple(zip(operands, rule(dag, node, *operands), strict=False))


def _arguments(dag: Dag, node: Node) -> Sequence[Node]:
    """The nodes that `partials` differentiates a node by."""
    return dag.listed(dag.a[node]) if dag.op[node] == _INVERTED else dag.operands(node)


def _partials_of_inverse(dag: Dag, node: Node) -> Partials:
    """Entry (i, j) of an inverse X of A by each entry (k, l) of A: -X_ik X_lj."""
    entries = dag.listed(dag.a[node])
    size = isqrt(len(entries))
    inverse = dag.inverted([entries[size * i : size * (i + 1)] for i in range(size)])
    row, column = divmod(dag.place_in_inverse(node), size)
    return tuple(
        (entries[size * k + m], dag.neg(dag.mul(inverse[row][k], inverse[m][column])))
        for k in range(size)
        for m in range(size)
    )
