"""Assertions that the arguments of tables stay within the knots, where leaving them is an error."""

from __future__ import annotations

from collections.abc import Iterator

from bgc.algebra.dag import Op
from bgc.algebra.table import Table
from bgc.ir.fields import nodes_of
from bgc.ir.graph import FlatGraph, Guard


def guards_of_tables(graph: FlatGraph) -> Iterator[Guard]:
    """The conditions of all tables of a graph with `outside = error`."""
    dag = graph.dag
    if not dag.tables:
        return
    seen: set[tuple[int, int]] = set()
    for node in dag.reachable(nodes_of(graph)):
        if dag.op[node] not in (Op.LOOKUP, Op.PIECE):
            continue
        table, x = dag.table_of(node), dag.b[node]
        if not isinstance(table, Table) or not table.strict or (table.number, x) in seen:
            continue
        seen.add((table.number, x))
        inside = dag.call(
            Op.AND,
            dag.call(Op.LE, dag.const(table.x[0]), x),
            dag.call(Op.LE, x, dag.const(table.x[-1])),
        )
        span = dag.places.get(node)
        if span is not None:
            message = (
                f"the argument of `interpolate` is outside the data `{table.source}`, "
                f"from {table.x[0]:.15g} to {table.x[-1]:.15g}"
            )
            yield Guard(inside, message, span)
