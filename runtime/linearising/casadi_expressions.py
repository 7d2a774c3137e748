"""Nodes of a graph of expressions as CasADi SX expressions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import ModuleType
from typing import Any, TypeAlias

from bgc.algebra.dag import Dag, Op, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.linalg import spelled_out
from bgc.algebra.table import Grid, Table, orders_of
from bgc.ir.graph import Node

SX: TypeAlias = Any
"""`casadi.SX`: a matrix of scalar expressions."""

# Operations that CasADi has by another name than C, and those that it lacks.
_OTHERWISE: dict[Op, Callable[..., SX]] = {
    Op.ADD: lambda casadi, a, b: a + b,
    Op.SUB: lambda casadi, a, b: a - b,
    Op.MUL: lambda casadi, a, b: a * b,
    Op.DIV: lambda casadi, a, b: a / b,
    Op.NEG: lambda casadi, a: -a,
    Op.POW: lambda casadi, a, b: a**b,
    Op.MAX: lambda casadi, a, b: casadi.fmax(a, b),
    Op.MIN: lambda casadi, a, b: casadi.fmin(a, b),
    Op.SELECT: lambda casadi, condition, yes, no: casadi.if_else(condition, yes, no),
    Op.SIGN: lambda casadi, a: casadi.sign(a),
    Op.LT: lambda casadi, a, b: a < b,
    Op.LE: lambda casadi, a, b: a <= b,
    Op.EQ: lambda casadi, a, b: a == b,
    Op.AND: lambda casadi, a, b: casadi.logic_and(a, b),
    Op.OR: lambda casadi, a, b: casadi.logic_or(a, b),
    Op.NOT: lambda casadi, a: casadi.logic_not(a),
    Op.CBRT: lambda casadi, a: casadi.sign(a) * casadi.fabs(a) ** (1 / 3),
    Op.ERFC: lambda casadi, a: 1 - casadi.erf(a),
}


def expressions(
    casadi: ModuleType,
    dag: Dag,
    nodes: Iterable[Node],
    leaf: Callable[[Symbol], SX],
    numbers: Mapping[Symbol, float],
) -> list[SX]:
    """The SX expressions of some nodes; `leaf` gives that of a symbol.

    Each node is converted once. A table becomes its polynomials, chosen by the argument. A random
    number, whose seed is a parameter, is the constant that the parameters' `numbers` give.
    """
    roots = spelled_out(dag, list(nodes))
    made: dict[Node, SX] = {}
    for node in dag.reachable(roots):
        op, value, symbol = Op(dag.op[node]), dag.value(node), dag.symbol_of(node)
        if value is not None:
            made[node] = casadi.SX(float(value))
        elif symbol is not None:
            made[node] = leaf(symbol)
        elif op is Op.RANDOM:
            made[node] = casadi.SX(evaluate_nodes(dag, [node], numbers)[0])
        else:
            made[node] = _operation(casadi, dag, node, op, [made[k] for k in dag.operands(node)])
    return [made[root] for root in roots]


def _operation(casadi: ModuleType, dag: Dag, node: Node, op: Op, operands: list[SX]) -> SX:
    if op in _OTHERWISE:
        return _OTHERWISE[op](casadi, *operands)
    if op in {Op.LOOKUP, Op.PIECE, Op.LOOKUP2}:
        table, orders = dag.table_of(node), orders_of(int(dag.constants[dag.a[dag.a[node]]]))
        if isinstance(table, Grid):
            return _on_grid(casadi, table, orders, operands[1], operands[2])
        return _on_curve(casadi, table, orders[0], operands[1])
    if op is Op.PLACE:  # only of a segment, which the argument of the table determines here
        return operands[1]
    return getattr(casadi, op.row.c)(*operands)


def _on_curve(casadi: ModuleType, table: Table, order: int, x: SX) -> SX:
    """A table of one argument, or its derivative."""
    if table.period is not None:
        x = x - casadi.floor((x - table.x[0]) / table.period) * table.period
    boundaries, points, derivatives = table.polynomials()
    u = x - _chosen(casadi, x, boundaries, points)
    total, power = casadi.SX(0), casadi.SX(1)
    for k, values in enumerate(derivatives[order:], 1):
        total += power * _chosen(casadi, x, boundaries, values)
        power *= u / k
    return total


def _on_grid(casadi: ModuleType, grid: Grid, orders: tuple[int, int], x: SX, y: SX) -> SX:
    """A table of two arguments, or its derivative, by the derivatives at a corner of its cell."""
    left, below = grid.x[:-1], grid.y[:-1]
    u = x - _chosen(casadi, x, left[1:], left)
    v = y - _chosen(casadi, y, below[1:], below)
    highest = 3 if grid.fields else 1
    total = casadi.SX(0)
    for a in range(orders[0], highest + 1):
        for b in range(orders[1], highest + 1):
            rows = [[grid.value((a, b), i, j) for j in below] for i in left]
            across = [_chosen(casadi, y, below[1:], row) for row in rows]
            at_corner = _chosen(casadi, x, left[1:], across)
            total += at_corner * _term(u, a - orders[0]) * _term(v, b - orders[1])
    return total


def _term(u: SX, power: int) -> SX:
    """`u^power / power!`."""
    return u**power / math.factorial(power)


def _chosen(casadi: ModuleType, x: SX, boundaries: Sequence[float], values: Sequence[SX]) -> SX:
    """The value of the piece that x is in; there is one more than boundaries."""
    if not boundaries:
        return casadi.SX(values[0])
    return casadi.pw_const(x, casadi.SX(casadi.DM(boundaries)), casadi.vertcat(*values))
