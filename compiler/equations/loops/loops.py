"""Algebraic loops: variables that depend on each other at one instant.

A loop is torn at the unknowns of equations, and at further variables until no cycle is left. If the
torn variables enter linearly, the system is solved symbolically in the DAG. A single nonlinear one
is solved in closed form if its law can be inverted (`algebra/inversion.py`). Otherwise each becomes
an algebraic state with a zero row in the mass matrix, which the integrators solve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.derivatives import gradient
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.inversion import solve_for
from bgc.algebra.linear import LinearForm, linear_form
from bgc.algebra.modular import Solutions, solutions_of
from bgc.algebra.strong_components import strong_components, vertices_on_cycles
from bgc.algebra.symbolic_systems import SingularSystemError, solve_general
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.loops.rates import RateTerms
from bgc.equations.variables.definitions import Explicit, Kept, Rate, Unknown, Variables
from bgc.ir.graph import Node
from bgc.ir.program import Divisor, Loop, LoopKind, LoopSolution, PositiveParameter
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class AlgebraicState:
    """An unknown carried as a state: the raw symbol, and the final residual that is zero."""

    symbol: Node
    residual: Node


@dataclass(frozen=True, slots=True)
class Solved:
    """A solved loop: final nodes of its members, its algebraic states, and its report.

    `divisors` are the pivots that a run watches.
    """

    final: dict[Node, Node]
    states: list[AlgebraicState]
    loop: Loop
    divisors: Sequence[Divisor] = ()


def solve_loop(
    variables: Variables,
    equation_of: Mapping[Node, Node],
    members: Sequence[Node],
    outside: Mapping[Node, Node],
    rates: Mapping[Node, RateTerms],
    first_state: int,
) -> Solved:
    """Solve the nodes of one strongly connected set.

    `outside` holds the final nodes of everything the loop needs from outside, `rates` the rates
    among the members as sums over the rates of states.

    Raises
    ------
    BgError
        The loop has no unique solution, or needs the rate of one of its own variables.
    """
    loop = _Loop(variables, equation_of, members, outside, rates)
    torn = loop.tear()
    order = loop.order_without(torn)
    forms = loop.linear_forms(torn, order)
    if forms is not None:
        system = loop.linear_system(torn, forms)
        solution = loop.solve_linear(system)
        if solution is not None:
            report = loop.report(torn, system.kind, LoopSolution.ELIMINATION)
            return Solved(loop.evaluate(order, solution), [], report, loop.divisors)
    dag = variables.dag
    solution = {symbol: dag.symbol(Kind.STATE, first_state + k) for k, symbol in enumerate(torn)}
    final = loop.evaluate(order, solution)
    if forms is None and len(torn) == 1:
        inverted = loop.invert(torn[0], final, solution[torn[0]])
        if inverted is not None:
            report = loop.report(torn, LoopKind.NONLINEAR, LoopSolution.CLOSED_FORM)
            return Solved(loop.evaluate(order, {torn[0]: inverted}), [], report)
    states = [
        AlgebraicState(symbol, loop.residual(symbol, final, solution[symbol])) for symbol in torn
    ]
    loop.require_regular(states, [solution[symbol] for symbol in torn])
    kind = LoopKind.NONLINEAR if forms is None else LoopKind.VARYING
    return Solved(final, states, loop.report(torn, kind, LoopSolution.NEWTON))


@dataclass(frozen=True, slots=True)
class _System:
    """`matrix * torn = right`, a sparse row for each."""

    torn: Sequence[Node]
    matrix: list[dict[int, Node]]
    right: list[Node]
    kind: LoopKind


class _Loop:
    def __init__(
        self,
        variables: Variables,
        equation_of: Mapping[Node, Node],
        members: Sequence[Node],
        outside: Mapping[Node, Node],
        rates: Mapping[Node, RateTerms],
    ) -> None:
        self._variables = variables
        self._dag: Dag = variables.dag
        self._fingerprints: Fingerprints = variables.causal.fingerprints
        self._equation_of = equation_of
        self._members = set(members)
        self._outside = outside
        self._rates = rates
        symbols = [m for m in members if self._dag.op[m] == Op.SYMBOL]
        if any(isinstance(variables.define(s), Rate) and s not in rates for s in symbols):
            raise variables.places.rate_in_loop(symbols)
        self._symbols = sorted(symbols)
        self.divisors: list[Divisor] = []  # pivots of the solution that may vanish

    def _target(self, symbol: Node) -> Node:
        """The raw node that defines a symbol, or the residual of an unknown; not of a rate."""
        if symbol in self._equation_of:
            return self._equation_of[symbol]
        definition = self._variables.define(symbol)
        assert isinstance(definition, Explicit)
        return definition.node

    def _is_unknown(self, symbol: Node) -> bool:
        """Return whether a symbol is found from a residual."""
        return isinstance(self._variables.define(symbol), Unknown | Kept)

    def _inside(self, node: Node) -> Iterator[Node]:
        """The members of the loop that a member depends on."""
        return (x for x in self._needs(node) if x in self._members)

    def _needs(self, node: Node) -> tuple[Node, ...]:
        if self._dag.op[node] != Op.SYMBOL:
            return self._dag.operands(node)
        if node in self._rates:
            return tuple(self._rates[node].weights)
        return (self._target(node),)

    # --- tearing ----------------------------------------------------------------------------

    def tear(self) -> list[Node]:
        """Choose the torn variables: unknowns of equations, and a symbol of each other cycle."""
        unknowns = filter(self._is_unknown, self._symbols)
        return sorted(vertices_on_cycles(self._symbols, self._inside, unknowns))

    def order_without(self, torn: Sequence[Node]) -> list[Node]:
        """All members except the torn ones, in topological order."""
        done = set(torn)
        order: list[Node] = []
        roots = [node for symbol in torn for node in self._needs(symbol)]
        for root in (*roots, *self._symbols):
            if root not in done and root in self._members:
                for (node,), _ in strong_components(root, self._inside, done.__contains__):
                    done.add(node)
                    order.append(node)
        return order

    # --- linear loops -----------------------------------------------------------------------

    def linear_forms(
        self, torn: Sequence[Node], order: Sequence[Node]
    ) -> dict[Node, LinearForm] | None:
        """Every member as a linear form in the torn variables; None where one is not linear."""
        forms: dict[Node, LinearForm] = {s: ({s: self._dag.one}, self._dag.zero) for s in torn}
        for node in order:
            form = self._form_of(node, forms)
            if form is None:
                return None
            forms[node] = form
        return forms

    def _form_of(self, node: Node, forms: Mapping[Node, LinearForm]) -> LinearForm | None:
        dag = self._dag
        if dag.op[node] == Op.SYMBOL:
            return self._form_of_target(node, forms)
        return linear_form(dag, node, [self._known(x, forms) for x in dag.operands(node)])

    def _form_of_target(self, symbol: Node, forms: Mapping[Node, LinearForm]) -> LinearForm:
        """The linear form of the node that defines a symbol, or of an unknown's residual."""
        if symbol not in self._rates:
            return self._known(self._target(symbol), forms)
        dag, terms = self._dag, self._rates[symbol]
        total: dict[Node, Node] = {}
        rest = terms.by_time
        for rate, weight in terms.weights.items():
            coefficients, constant = self._known(rate, forms)
            for other, node in coefficients.items():
                total[other] = dag.add(total.get(other, dag.zero), dag.mul(weight, node))
            rest = dag.add(rest, dag.mul(weight, constant))
        return total, rest

    def _known(self, node: Node, forms: Mapping[Node, LinearForm]) -> LinearForm:
        if node in forms:
            return forms[node]
        return {}, self._outside[node]

    def linear_system(self, torn: Sequence[Node], forms: Mapping[Node, LinearForm]) -> _System:
        """The linear system of the torn variables; refused where it is always singular."""
        dag = self._dag
        column = {symbol: k for k, symbol in enumerate(torn)}
        matrix, right = [], []
        for symbol in torn:
            coefficients, rest = self._form_of_target(symbol, forms)
            row = {column[s]: c for s, c in coefficients.items()}
            if not self._is_unknown(symbol):
                own = column[symbol]
                row[own] = dag.sub(row.get(own, dag.zero), dag.one)
            matrix.append(row)
            right.append(dag.neg(rest))
        return _System(torn, matrix, right, self._kind_of(matrix))

    def _kind_of(self, matrix: Sequence[Mapping[int, Node]]) -> LoopKind:
        highest = max((self._dag.level[node] for row in matrix for node in row.values()), default=0)
        return LoopKind.CONSTANT if highest <= Level.PARAM else LoopKind.VARYING

    def solve_linear(self, system: _System) -> dict[Node, Node] | None:
        """Solve for the torn variables as final nodes; None where a pivot may vanish.

        A varying pivot is accepted where the system is singular without it, or if it keeps its sign
        at random points. Pivots of parameters alone are checked at run time.
        """
        unsafe: list[Node] = []
        doubtful: list[Node] = []
        places = self._variables.places
        name = places.name_of(system.torn[0])
        message = f"the algebraic loop at `{name}` is singular"

        def note(pivot: Node, alone: bool) -> None:
            if self._dag.level[pivot] == Level.PARAM:
                self._variables.watch(pivot, message)
            elif not alone and not self._variables.signs.is_certain(pivot):
                unsafe.append(pivot)
            elif self._variables.may_vanish(pivot):
                doubtful.append(pivot)

        try:
            rank = self._variables.signs.rank
            values = solve_general(
                self._dag, self._fingerprints, system.matrix, system.right, rank, note
            )
        except SingularSystemError:
            size = range(len(system.torn))
            rows = [[row.get(k, self._dag.zero) for k in size] for row in system.matrix]
            raise self._unsolvable(system.torn, rows, system.right) from None
        if unsafe:
            return None
        what, span = f"a divisor of the algebraic loop at `{name}`", places.span_of(system.torn[0])
        self.divisors = [Divisor(node, what, span) for node in doubtful]
        return dict(zip(system.torn, values, strict=True))

    def _unsolvable(
        self,
        torn: Sequence[Node],
        rows: Sequence[Sequence[Node]],
        right: Sequence[Node],
        unknowns: Sequence[Node] = (),
    ) -> BgError:
        """The error for a loop without a unique solution: none, many, or unclear.

        It is unclear where the rows depend on the unknowns.
        """
        residue = self._fingerprints.residue
        found = "unclear"
        if set(unknowns).isdisjoint(self._dag.reachable([n for row in rows for n in row])):
            numbers = [[residue(n) for n in row] for row in rows]
            found = solutions_of(numbers, [residue(n) for n in right]).value
        ports = self._variables.ports_among(self._members)
        places = self._variables.places
        return places.unsolvable(
            torn, found, places.bonds_of(self._symbols, ports), places.elements_of(ports)
        )

    def report(self, torn: Sequence[Node], kind: LoopKind, solution: LoopSolution) -> Loop:
        """Describe the loop for tables and messages."""
        places = self._variables.places
        ports = self._variables.ports_among(self._members)
        return Loop(
            bonds=places.bonds_of(self._symbols, ports),
            elements=places.elements_of(ports),
            torn=tuple(places.name_of(symbol) for symbol in torn),
            kind=kind,
            solution=solution,
            span=places.span_of(torn[0]),
        )

    # --- any loops --------------------------------------------------------------------------

    def evaluate(self, order: Sequence[Node], solution: Mapping[Node, Node]) -> dict[Node, Node]:
        """The final nodes of all members, given the torn ones."""
        dag = self._dag
        final = dict(solution)

        for node in order:
            if dag.op[node] == Op.SYMBOL:
                final[node] = self._value_of_target(node, final)
            else:
                operands = tuple(self._value(x, final) for x in dag.operands(node))
                final[node] = dag.rebuild(node, operands)
        return final

    def _value(self, node: Node, final: Mapping[Node, Node]) -> Node:
        return final[node] if node in final else self._outside[node]

    def _value_of_target(self, symbol: Node, final: Mapping[Node, Node]) -> Node:
        """The final node of what defines a symbol, or of an unknown's residual."""
        if symbol not in self._rates:
            return self._value(self._target(symbol), final)
        dag, terms = self._dag, self._rates[symbol]
        parts = (dag.mul(w, self._value(rate, final)) for rate, w in terms.weights.items())
        return dag.add(terms.by_time, dag.sum(parts))

    def residual(self, symbol: Node, final: Mapping[Node, Node], stand_in: Node) -> Node:
        """The residual of a torn variable, for which a symbol stands in the final nodes."""
        value = self._value_of_target(symbol, final)
        return value if self._is_unknown(symbol) else self._dag.sub(value, stand_in)

    def invert(self, symbol: Node, final: Mapping[Node, Node], stand_in: Node) -> Node | None:
        """Solve for a single torn variable in closed form, if its law can be inverted."""
        dag = self._dag
        residual = self.residual(symbol, final, stand_in)
        self._refuse_flat(residual, symbol, stand_in)
        return solve_for(
            dag, residual, dag.zero, stand_in, self._variables.limits, self._rely_on(symbol)
        )

    def _rely_on(self, symbol: Node) -> Callable[[Node], None]:
        name = self._variables.places.name_of(symbol)
        message = f"the law that gives `{name}` rises only while its coefficients are positive"

        def note(node: Node) -> None:
            self._variables.watched.append(PositiveParameter(node, message, strictly_positive=True))

        return note

    def _refuse_flat(self, residual: Node, symbol: Node, stand_in: Node) -> None:
        """Refuse a law that is even, or constant over a range: it has no unique inverse."""
        dag = self._dag
        (mirrored,) = dag.substitute([residual], {stand_in: dag.neg(stand_in)})
        why = None
        if self._fingerprints.equal(mirrored, residual):
            why = "the same for a value and its opposite"
        elif _is_flat(dag, *gradient(dag, residual, [stand_in])):
            why = "the same for a whole range of values"
        if why is not None:
            ports = self._variables.ports_among(self._members)
            places = self._variables.places
            raise places.not_invertible(symbol, places.elements_of(ports), why)

    def require_regular(self, states: Sequence[AlgebraicState], unknowns: Sequence[Node]) -> None:
        """Refuse residuals whose Jacobian is singular for all values."""
        residue = self._fingerprints.residue
        rows = [gradient(self._dag, s.residual, unknowns) for s in states]
        found = solutions_of([[residue(n) for n in row] for row in rows], [0] * len(rows))
        if found is not Solutions.ONE:
            right = [state.residual for state in states]
            raise self._unsolvable([state.symbol for state in states], rows, right, unknowns)


def _is_flat(dag: Dag, slope: Node) -> bool:
    """Return whether a slope is zero on one side of a condition."""
    while dag.op[slope] in {Op.NEG, Op.MUL, Op.DIV}:
        operands = dag.operands(slope)
        varying = [x for x in operands if dag.level[x] > Level.PARAM]
        if len(varying) != 1 or (dag.op[slope] == Op.DIV and varying[0] != operands[0]):
            return False
        slope = varying[0]
    if dag.op[slope] != Op.SELECT:
        return slope == dag.zero
    return any(_is_flat(dag, branch) for branch in dag.operands(slope)[1:])
