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

from collections.abc import Callable, Sequence

from bgc.algebra.dag import Dag, Kind, Level, Op, Symbol
from bgc.emission.differentiate import differentiated_rows, forward_rows, jacobian_of
from bgc.emission.kept_vertices import Order, Settings, order_elimination
from bgc.emission.simplification import number_values
from bgc.emission.vertices import TIME, DerivativeGraph
from bgc.ir.graph import Node
from bgc.ir.lowered import Jacobian
from bgc.ir.program import Program, SpeedEquations
from bgc.record_class import dataclass, replace

_SETTINGS: tuple[Settings, ...] = ((0, 0), (1, 3), (2, 4), (14, 6))  # no single one is good for all


@dataclass(frozen=True, slots=True)
class _Implicit:
    """g and r, on a DAG in which SPEED symbols stand for z."""

    dag: Dag
    rates: tuple[Node, ...]
    residuals: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class KeptOrder:
    """An order of elimination, and the graph on a DAG to which it belongs."""

    dag: Dag
    graph: DerivativeGraph
    order: Order


@dataclass(frozen=True, slots=True)
class ImplicitForms:
    """The ways to differentiate a program with its speeds as unknowns of the linear systems.

    Each gives a program on a DAG of its own, with [g_x g_z; r_x r_z] and df/dt.
    """

    program: Program  # on a DAG with the values of the speeds and df/dt
    form: _Implicit
    speeds: dict[Symbol, Node]
    by_time: tuple[Node, ...]
    slopes: tuple[tuple[int, int], ...]

    @property
    def size(self) -> int:
        """The number of states and speeds."""
        return len(self.program.states) + len(self.speeds)

    def places(self) -> tuple[tuple[int, int], ...]:
        """The places at which the derivatives by states and speeds may have entries, sorted."""
        return _dependences(self.form.dag, self._outputs, self._column, self.size)

    def accumulated(self, most: int | None = None) -> tuple[Program, Jacobian] | None:
        """With the speeds alone as inner unknowns z, and all derivatives accumulated.

        None if these take more than `most` nodes.
        """
        found = differentiated_rows(self.form.dag, self._outputs, self._column, most)
        if found is None:
            return None
        dag, rows = found
        return self._joined(dag, jacobian_of(dag, rows), len(self.speeds))

    def order(self) -> KeptOrder | None:
        """The order with kept vertices (`kept_vertices.py`) that takes the fewest products.

        Found on patterns, without derivatives. None where M is not the identity.
        """
        if self.program.mass is not None:
            return None
        graph = DerivativeGraph(dag := self.form.dag.copy(), self._outputs, self._column)
        graph.eliminate_choices()
        pattern = {target: edges.keys() for target, edges in graph.edges().items()}
        speeds = range(len(self.program.states), self.size)
        orders = (order_elimination(pattern, speeds, settings) for settings in _SETTINGS)
        return KeptOrder(dag, graph, min(orders, key=lambda order: order.products))

    def with_kept_vertices(self, kept: KeptOrder) -> tuple[Program, Jacobian]:
        """With intermediate values in z too, and an order of the pivots. An order serves once."""
        for vertex in kept.order.accumulated:
            kept.graph.accumulate(vertex)
        local = _with_kept(kept.dag, kept.graph, kept.order, self.size)
        return self._joined(kept.dag, local, len(self.speeds) + len(kept.order.kept))

    @property
    def _outputs(self) -> tuple[Node, ...]:
        return (*self.form.rates, *self.form.residuals)

    def _column(self, symbol: Symbol) -> int | None:
        """The column of the derivatives by a state or a speed."""
        match symbol.kind:
            case Kind.STATE:
                return symbol.index
            case Kind.SPEED:
                return len(self.program.states) + symbol.index
            case _:
                return None

    def _joined(self, other: Dag, local: Jacobian, inner: int) -> tuple[Program, Jacobian]:
        """The program and the entries of a Jacobian on another DAG, on one."""
        dag = self.program.dag.copy()
        jacobian = replace(
            local,
            entries=tuple(dag.adopted(other, local.entries, self.speeds)),
            by_time=self.by_time,
            inner=inner,
            slopes=self.slopes,
        )
        return replace(self.program, dag=dag), jacobian


def implicit_forms(program: Program) -> ImplicitForms | None:
    """The implicit forms of a program, whose nodes keep their numbers; None if it has no speeds."""
    if program.speeds is None:
        return None
    form = _implicit_form(program, program.speeds)
    if form is None:
        return None
    dag = program.dag.copy()
    values = dag.adopted(program.speeds.dag, program.speeds.values)
    outputs = [state.derivative for state in program.states]
    rows = forward_rows(dag, outputs, lambda s: TIME if s.kind is Kind.TIME else None)
    return ImplicitForms(
        replace(program, dag=dag),
        form,
        {Symbol(Kind.SPEED, k): node for k, node in enumerate(values)},
        tuple(row.get(TIME, dag.zero) for row in rows),
        dependences(program),
    )


def _with_kept(dag: Dag, graph: DerivativeGraph, order: Order, size: int) -> Jacobian:
    """The entries of what is left of a graph; kept vertices follow `size` unknowns."""
    number = {vertex: size + k for k, vertex in enumerate(order.kept)}
    entries: dict[tuple[int, int], Node] = {}
    for target, edges in graph.edges().items():
        row = ~target if target < 0 else number[target]
        for source, edge in edges.items():
            entries[row, ~source if source < 0 else number[source]] = edge
    minus = dag.const(-1)
    entries |= {(k, k): minus for k in number.values()}
    places = sorted(entries)
    return Jacobian(
        rows=tuple(row for row, _ in places),
        columns=tuple(column for _, column in places),
        entries=tuple(entries[place] for place in places),
        by_time=(),
        pivots=tuple(pivot if pivot >= 0 else number[~pivot] for pivot in order.pivots),
    )


def dependences(program: Program) -> tuple[tuple[int, int], ...]:
    """The places at which df/dx may have entries, sorted."""
    outputs = [state.derivative for state in program.states]
    return _dependences(
        program.dag, outputs, lambda s: s.index if s.kind is Kind.STATE else None, len(outputs)
    )


def _dependences(
    dag: Dag, outputs: Sequence[Node], column_of: Callable[[Symbol], int | None], size: int
) -> tuple[tuple[int, int], ...]:
    """The places of rows of derivatives by the symbols with a column, of `size` columns."""
    reads: dict[Node, int] = {}  # node -> the columns that it depends on, as bits
    for node in dag.reachable(outputs):
        symbol = dag.symbol_of(node)
        column = column_of(symbol) if symbol is not None else None
        bits = 0 if column is None else 1 << column
        for operand in dag.operands(node):
            bits |= reads[operand]
        reads[node] = bits
    return tuple(
        (row, column)
        for row, output in enumerate(outputs)
        for column in range(size)
        if reads[output] >> column & 1
    )


def _implicit_form(program: Program, speeds: SpeedEquations) -> _Implicit | None:
    """g and r; None where g would need a flow whose symbol cannot take its place."""
    dag = program.dag.copy()
    rates = [state.derivative for state in program.states]
    values = dag.adopted(speeds.dag, speeds.values)
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
    residuals = dag.adopted(speeds.dag, speeds.residuals)
    dag, new = number_values(dag, (*cut, *residuals))
    return _Implicit(dag, tuple(new[node] for node in cut), tuple(new[node] for node in residuals))
