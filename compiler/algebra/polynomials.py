"""Nodes as sums of terms `c x^n` and `c x^n abs(x)` in one symbol."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from bgc.algebra.dag import Dag, Op
from bgc.algebra.nodes import Node

Terms: TypeAlias = dict[tuple[int, int], Node]
"""(power of x, 1 if times abs(x)) -> coefficient."""


def antiderivative(dag: Dag, node: Node, symbol: Node) -> Node | None:
    """The integral from zero of a sum of terms `c x^n` and `c x^n abs(x)` in a symbol.

    None for anything else; the energy is then integrated along with the states.
    """
    terms = terms_in(dag, node, symbol)
    if terms is None:
        return None
    size = dag.call(Op.ABS, symbol)
    total = dag.zero
    for (power, absolute), coefficient in sorted(terms.items()):
        degree = power + absolute + 1
        term = dag.pow(symbol, dag.const(power + 1))
        if absolute:
            term = dag.mul(term, size)
        total = dag.add(total, dag.div(dag.mul(coefficient, term), dag.const(degree)))
    return total


def terms_in(dag: Dag, node: Node, symbol: Node) -> Terms | None:
    """A node as a sum of `c x^n` and `c x^n abs(x)`, c independent of x; None for anything else."""
    found: dict[Node, Terms | None] = {}
    for inner in dag.reachable([node]):
        operands = [found[x] for x in dag.operands(inner)]
        parts = [part for part in operands if part is not None]
        if len(parts) < len(operands):
            found[inner] = None
        elif inner == symbol:
            found[inner] = {(1, 0): dag.one}
        elif all(set(part) <= {(0, 0)} for part in parts):
            found[inner] = {(0, 0): inner}
        else:
            found[inner] = _combined(dag, Op(dag.op[inner]), dag.operands(inner), parts, symbol)
    return found[node]


def _combined(
    dag: Dag, op: Op, operands: Sequence[Node], parts: Sequence[Terms], symbol: Node
) -> Terms | None:
    match op, parts:
        case Op.ADD, [a, b]:
            return _added(dag, a, b)
        case Op.SUB, [a, b]:
            return _added(dag, a, _negated(dag, b))
        case Op.NEG, [a]:
            return _negated(dag, a)
        case Op.MUL, [a, b]:
            return _multiplied(dag, a, b)
        case Op.DIV, [a, b] if set(b) <= {(0, 0)}:
            return {key: dag.div(c, operands[1]) for key, c in a.items()}
        case Op.ABS, _ if operands[0] == symbol:
            return {(0, 1): dag.one}
        case _:
            return None


def _added(dag: Dag, a: Terms, b: Terms) -> Terms:
    total = dict(a)
    for key, node in b.items():
        total[key] = dag.add(total.get(key, dag.zero), node)
    return total


def _negated(dag: Dag, a: Terms) -> Terms:
    return {key: dag.neg(node) for key, node in a.items()}


def _multiplied(dag: Dag, a: Terms, b: Terms) -> Terms:
    total: Terms = {}
    for (n, s), x in a.items():
        for (m, t), y in b.items():
            key = (n + m + 2, 0) if s and t else (n + m, s + t)  # abs(x)^2 = x^2
            total[key] = dag.add(total.get(key, dag.zero), dag.mul(x, y))
    return total
