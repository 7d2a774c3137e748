"""Differentiate a program's right-hand sides: df/dx with its sparsity, and df/dt.

Forward differentiation propagates a sparse row of derivatives to every node; vertex elimination
(`vertices.py`) removes nodes from the graph, the cheapest first. The model decides which gives
fewer operations (forward and elimination: 6,976 and 7,644 on a crane of 4 beams on springs, 63,803
and 39,178 on an arm of 12 rigid joints), so both are tried. Both visit only nodes that depend on a
state or on time, so their cost is proportional to the number of nonzero derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from bgc.algebra.dag import Dag, Level, Op, Symbol
from bgc.algebra.derivatives import CHOICES, choice, partials
from bgc.emission.vertices import TIME, Row, by_state_and_time, eliminated_rows
from bgc.ir.graph import Node
from bgc.ir.lowered import Jacobian
from bgc.ir.program import Program

# As plain ints: comparing with a member of an enumeration takes several times longer.
_SYMBOL, _ADD, _SUB, _MUL = map(int, (Op.SYMBOL, Op.ADD, Op.SUB, Op.MUL))


def differentiate(program: Program) -> tuple[Program, Jacobian]:
    """Return a program on a DAG that contains its Jacobian, and the Jacobian.

    Inputs are constants, since they are held over a step. The given program is unchanged; the
    returned one has the same node numbers.
    """
    found = differentiate_within(program, None)
    assert found is not None
    return found


def differentiate_within(program: Program, most: int | None) -> tuple[Program, Jacobian] | None:
    """Differentiate a program as above; None if both ways take more than `most` nodes."""
    outputs = [state.derivative for state in program.states]
    found = differentiated_rows(program.dag, outputs, by_state_and_time, most)
    if found is None:
        return None
    dag, rows = found
    return replace(program, dag=dag), jacobian_of(dag, rows)


def differentiated_rows(
    dag: Dag,
    outputs: Sequence[Node],
    column_of: Callable[[Symbol], int | None],
    most: int | None = None,
) -> tuple[Dag, list[Row]] | None:
    """Differentiate outputs in the way with fewer operations, on a copy of the DAG.

    `column_of` gives the column of a symbol, None for a constant one. None if both ways take more
    than `most` nodes.
    """
    if most is not None and most < 0:
        return None
    first = dag.copy()
    limit = None if most is None else len(dag) + most
    rows = _forward_rows(first, outputs, column_of, limit)
    cost = None if rows is None else operation_count(first, jacobian_of(first, rows))
    bounds = [len(dag) + 6 * cost // 5 + 300] if cost is not None else []
    bounds += [limit] if limit is not None else []
    second = dag.copy()
    others = eliminated_rows(second, outputs, min(bounds), column_of)
    if others is None:
        return None if rows is None else (first, rows)
    if cost is None or operation_count(second, jacobian_of(second, others)) < cost:
        return second, others
    assert rows is not None
    return first, rows


def operation_count(dag: Dag, jacobian: Jacobian) -> int:
    """The operations of the Jacobian, without those that depend on parameters only."""
    return len(dag.repeated((*jacobian.entries, *jacobian.by_time)))


def jacobian_of(dag: Dag, rows: Sequence[Row]) -> Jacobian:
    """The entries of rows of derivatives, sorted; derivatives by time apart."""
    entries = [
        (row, column, derivatives[column])
        for row, derivatives in enumerate(rows)
        for column in sorted(derivatives)
        if column != TIME
    ]
    return Jacobian(
        rows=tuple(row for row, _, _ in entries),
        columns=tuple(column for _, column, _ in entries),
        entries=tuple(node for _, _, node in entries),
        by_time=tuple(derivatives.get(TIME, dag.zero) for derivatives in rows),
    )


def forward_rows(
    dag: Dag,
    outputs: Sequence[Node],
    column_of: Callable[[Symbol], int | None] = by_state_and_time,
) -> list[Row]:
    """Differentiate each output by the symbols with a column, in forward mode.

    `column_of` gives the column of a symbol, None for a constant one. Returns a sparse row per
    output.
    """
    rows = _forward_rows(dag, outputs, column_of, None)
    assert rows is not None
    return rows


def _forward_rows(
    dag: Dag,
    outputs: Sequence[Node],
    column_of: Callable[[Symbol], int | None],
    budget: int | None,
) -> list[Row] | None:
    """The same; None if the DAG exceeds `budget` nodes."""
    op, a, b = dag.op, dag.a, dag.b
    add, sub, mul, neg, zero = dag.add, dag.sub, dag.mul, dag.neg, dag.zero
    nothing: Row = {}
    rows: dict[Node, Row] = {}
    for node in dag.reachable(outputs, Level.TIME):
        kind = op[node]
        row: Row
        if kind == _SYMBOL:
            column = column_of(dag.symbols[a[node]])
            if column is not None:
                rows[node] = {column: dag.one}
            continue
        of_a, of_b = rows.get(a[node], nothing), rows.get(b[node], nothing)
        if kind == _MUL:
            x, y = a[node], b[node]
            row = {k: mul(d, y) for k, d in of_a.items()}
            for k, d in of_b.items():
                row[k] = add(row[k], mul(x, d)) if k in row else mul(x, d)
        elif kind == _ADD:
            row = dict(of_a)
            for k, d in of_b.items():
                row[k] = add(row[k], d) if k in row else d
        elif kind == _SUB:
            row = dict(of_a)
            for k, d in of_b.items():
                row[k] = sub(row[k], d) if k in row else neg(d)
        elif kind in CHOICES:
            condition, yes, no = choice(dag, node)
            of_yes, of_no = rows.get(yes, nothing), rows.get(no, nothing)
            row = {
                k: dag.select(condition, of_yes.get(k, zero), of_no.get(k, zero))
                for k in {**of_yes, **of_no}
            }
        elif of_a or of_b:
            row = {}
            for operand, partial in partials(dag, node):
                for k, d in rows.get(operand, nothing).items():
                    row[k] = add(row[k], mul(partial, d)) if k in row else mul(partial, d)
        else:
            continue
        if row:
            rows[node] = {k: d for k, d in row.items() if d != zero}
            if budget is not None and len(dag) > budget:
                return None
    return [rows.get(node, nothing) for node in outputs]
