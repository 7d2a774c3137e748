"""Keep the speeds of rigid mechanisms as unknowns of the linear systems.

f solves for the independent flows u of merged inertias in the DAG. On a chain of n bodies that
takes O(n) operations, but its derivatives by the states are dense: every state reaches its own row
through the articulated inertias of all bodies. With u as unknowns z of the linear systems these
inertias are never differentiated. f becomes g(x, z), with 0 = r(x, z) as before it was solved, and

    W = | c M - g_x   -g_z |
        |    -r_x     -r_z |

has the solution of c M - df/dx in its leading part, since right-hand sides have zeros in the rows
of r. -r_z is the reduced mass, so pivots on the diagonal are as safe as those of c M - df/dx.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from bgc.algebra.dag import Dag, Kind, Level, Op, Symbol
from bgc.emission.differentiate import differentiated_rows, forward_rows, jacobian_of
from bgc.emission.optimise import number_values
from bgc.emission.vertices import TIME
from bgc.ir.graph import Node
from bgc.ir.lowered import Jacobian
from bgc.ir.program import Program, SpeedEquations


@dataclass(frozen=True, slots=True)
class _Implicit:
    """g and r, on a DAG in which SPEED symbols stand for z."""

    dag: Dag
    rates: tuple[Node, ...]
    residuals: tuple[Node, ...]


def differentiate_implicitly(program: Program) -> tuple[Program, Jacobian] | None:
    """A program on a DAG with [g_x g_z; r_x r_z] and df/dt; None if no flow can be kept.

    The given program is unchanged; the returned one has the same node numbers.
    """
    if program.speeds is None:
        return None
    form = _implicit_form(program, program.speeds)
    if form is None:
        return None
    size = len(program.states)

    def column(symbol: Symbol) -> int | None:
        match symbol.kind:
            case Kind.STATE:
                return symbol.index
            case Kind.SPEED:
                return size + symbol.index
            case _:
                return None

    found = differentiated_rows(form.dag, (*form.rates, *form.residuals), column)
    assert found is not None
    local = jacobian_of(*found)
    dag = program.dag.copy()
    speeds = {
        Symbol(Kind.SPEED, k): node
        for k, node in enumerate(_adopted(dag, program.speeds.dag, program.speeds.values, {}))
    }
    entries = _adopted(dag, found[0], local.entries, speeds)
    outputs = [state.derivative for state in program.states]
    by_time = [
        row.get(TIME, dag.zero)
        for row in forward_rows(dag, outputs, lambda s: TIME if s.kind is Kind.TIME else None)
    ]
    jacobian = replace(
        local,
        entries=tuple(entries),
        by_time=tuple(by_time),
        inner=len(program.speeds.values),
        slopes=dependences(program),
    )
    return replace(program, dag=dag), jacobian


def dependences(program: Program) -> tuple[tuple[int, int], ...]:
    """The places at which df/dx may have entries, sorted."""
    dag = program.dag
    reads: dict[Node, int] = {}  # node -> the states that it depends on, as bits
    outputs = [state.derivative for state in program.states]
    for node in dag.reachable(outputs):
        symbol = dag.symbol_of(node)
        bits = 1 << symbol.index if symbol is not None and symbol.kind is Kind.STATE else 0
        for operand in dag.operands(node):
            bits |= reads[operand]
        reads[node] = bits
    return tuple(
        (row, column)
        for row, output in enumerate(outputs)
        for column in range(len(outputs))
        if reads[output] >> column & 1
    )


def _implicit_form(program: Program, speeds: SpeedEquations) -> _Implicit | None:
    """g and r; None where g would need a flow whose symbol cannot take its place."""
    dag = program.dag.copy()
    rates = [state.derivative for state in program.states]
    values = _adopted(dag, speeds.dag, speeds.values, {})
    dag, new = number_values(dag, (*rates, *values))
    place: dict[Node, Node] = {}
    for k, value in enumerate(values):
        node, symbol = new[value], dag.symbol(Kind.SPEED, k)
        if dag.op[node] == Op.NEG:
            node, symbol = dag.a[node], dag.neg(symbol)
        if dag.op[node] <= Op.SYMBOL or dag.level[node] <= Level.PARAM or node in place:
            return None
        place[node] = symbol
    cut = dag.substitute([new[rate] for rate in rates], place)
    residuals = _adopted(dag, speeds.dag, speeds.residuals, {})
    dag, new = number_values(dag, (*cut, *residuals))
    return _Implicit(dag, tuple(new[node] for node in cut), tuple(new[node] for node in residuals))


def _adopted(
    dag: Dag, other: Dag, nodes: Sequence[Node], symbols: dict[Symbol, Node]
) -> list[Node]:
    """Nodes of another DAG as nodes of this one; some symbols become given nodes."""
    new: dict[Node, Node] = {}
    for node in other.reachable(nodes):
        symbol = other.symbol_of(node)
        if symbol is not None and symbol in symbols:
            new[node] = symbols[symbol]
        else:
            new[node] = dag.adopt(other, node, tuple(new[x] for x in other.operands(node)))
    return [new[node] for node in nodes]
