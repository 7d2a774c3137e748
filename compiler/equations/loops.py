"""Algebraic loops: variables that depend on each other at one instant.

A loop is torn at the unknowns of equations, and at as many other variables as it takes to leave
no circle. If the torn variables enter linearly, they are solved for once and for all, in the
DAG; a single one also if its law can be turned round (`inversion`). Otherwise each becomes an
algebraic state with a zero row in the mass matrix, which the integrators solve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.derivatives import gradient
from bgc.algebra.fingerprint import PRIME, Fingerprints
from bgc.algebra.inversion import solve_for
from bgc.algebra.solving import SingularSystemError, solve_general
from bgc.equations.variables import Explicit, Rate, Variables
from bgc.graph import Node
from bgc.program import Loop, LoopKind, LoopSolution


@dataclass(frozen=True, slots=True)
class AlgebraicState:
    """An unknown carried as a state: the raw symbol, and the final residual that is zero."""

    symbol: Node
    residual: Node


@dataclass(frozen=True, slots=True)
class Solved:
    """Final nodes of all members of a loop, the states it left, and what to say of it."""

    final: dict[Node, Node]
    states: list[AlgebraicState]
    loop: Loop


def solve_loop(
    variables: Variables,
    equation_of: Mapping[Node, Node],
    members: Sequence[Node],
    outside: Mapping[Node, Node],
    first_state: int,
) -> Solved:
    """Solve the nodes of one strongly connected set.

    `outside` holds the final nodes of all that the loop needs from elsewhere.

    Raises
    ------
    BgError
        The loop has no single solution, or needs the rate of what it decides on.
    """
    loop = _Loop(variables, equation_of, members, outside)
    torn = loop.tear()
    residuals = [loop.target(symbol) for symbol in torn]
    order = loop.order_without(torn, residuals)
    forms = loop.linear_forms(torn, order)
    if forms is not None:
        solution, kind = loop.solve_linear(torn, residuals, forms)
        report = loop.report(torn, kind, LoopSolution.ELIMINATION)
        return Solved(loop.evaluate(order, solution), [], report)
    dag = variables.dag
    solution = {symbol: dag.symbol(Kind.STATE, first_state + k) for k, symbol in enumerate(torn)}
    final = loop.evaluate(order, solution)
    if len(torn) == 1:
        inverted = loop.invert(torn[0], residuals[0], final, solution[torn[0]])
        if inverted is not None:
            report = loop.report(torn, LoopKind.NONLINEAR, LoopSolution.CLOSED_FORM)
            return Solved(loop.evaluate(order, {torn[0]: inverted}), [], report)
    states = []
    for symbol, target in zip(torn, residuals, strict=True):
        value = final[target] if target in final else outside[target]
        residual = value if symbol in equation_of else dag.sub(value, solution[symbol])
        states.append(AlgebraicState(symbol, residual))
    loop.require_regular(states, [solution[symbol] for symbol in torn])
    return Solved(final, states, loop.report(torn, LoopKind.NONLINEAR, LoopSolution.NEWTON))


_Form = tuple[dict[Node, Node], Node]  # coefficients of torn variables, and the rest


class _Loop:
    def __init__(
        self,
        variables: Variables,
        equation_of: Mapping[Node, Node],
        members: Sequence[Node],
        outside: Mapping[Node, Node],
    ) -> None:
        self._variables = variables
        self._dag: Dag = variables.dag
        self._fingerprints: Fingerprints = variables.causal.fingerprints
        self._equation_of = equation_of
        self._members = set(members)
        self._outside = outside
        symbols = [m for m in members if self._dag.op[m] == Op.SYMBOL]
        if any(isinstance(variables.define(s), Rate) for s in symbols):
            raise variables.places.rate_in_loop(symbols)
        self._symbols = sorted(symbols)

    def target(self, symbol: Node) -> Node:
        """The raw node that a symbol is computed from, or that has to be zero."""
        if symbol in self._equation_of:
            return self._equation_of[symbol]
        definition = self._variables.define(symbol)
        assert isinstance(definition, Explicit)
        return definition.node

    def _inside(self, node: Node) -> Iterator[Node]:
        """What a member needs of the loop."""
        needs = (
            (self.target(node),) if self._dag.op[node] == Op.SYMBOL else self._dag.operands(node)
        )
        return (x for x in needs if x in self._members)

    # --- tearing ----------------------------------------------------------------------------

    def tear(self) -> list[Node]:
        """The unknowns of equations, and a symbol of every circle that is left."""
        torn = {s for s in self._symbols if s in self._equation_of}
        done: set[Node] = set()
        for start in self._symbols:
            if start in done or start in torn:
                continue
            path: dict[Node, None] = {start: None}
            stack = [(start, self._inside(start))]
            while stack:
                node, needs = stack[-1]
                for needed in needs:
                    if needed in torn or needed in done:
                        continue
                    if needed in path:
                        torn.add(self._last_symbol(path, needed))
                        continue
                    path[needed] = None
                    stack.append((needed, self._inside(needed)))
                    break
                else:
                    stack.pop()
                    path.pop(node)
                    done.add(node)
        return sorted(torn)

    def _last_symbol(self, path: Mapping[Node, None], start: Node) -> Node:
        """The last symbol on the circle that runs from `start` to the end of the path."""
        for node in reversed(list(path)):
            if self._dag.op[node] == Op.SYMBOL:
                return node
            if node == start:
                break
        raise AssertionError("a circle without a symbol")

    def order_without(self, torn: Sequence[Node], roots: Sequence[Node]) -> list[Node]:
        """All members but the torn ones, each after what it needs."""
        done = set(torn)
        order: list[Node] = []
        for root in (*roots, *self._symbols):
            if root in done or root not in self._members:
                continue
            stack = [(root, self._inside(root))]
            entered = {root}
            while stack:
                node, needs = stack[-1]
                for needed in needs:
                    if needed not in done and needed not in entered:
                        entered.add(needed)
                        stack.append((needed, self._inside(needed)))
                        break
                else:
                    stack.pop()
                    done.add(node)
                    order.append(node)
        return order

    # --- linear loops -----------------------------------------------------------------------

    def linear_forms(self, torn: Sequence[Node], order: Sequence[Node]) -> dict[Node, _Form] | None:
        """Every member as a linear form in the torn variables; None where one is not linear."""
        forms: dict[Node, _Form] = {s: ({s: self._dag.one}, self._dag.zero) for s in torn}
        for node in order:
            form = self._form_of(node, forms)
            if form is None:
                return None
            forms[node] = form
        return forms

    def _form_of(self, node: Node, forms: Mapping[Node, _Form]) -> _Form | None:
        dag = self._dag
        if dag.op[node] == Op.SYMBOL:
            return self._known(self.target(node), forms)
        operands = [self._known(x, forms) for x in dag.operands(node)]
        op = dag.op[node]
        match operands:
            case [(a, x)] if op == Op.NEG:
                return {k: dag.neg(c) for k, c in a.items()}, dag.neg(x)
            case [(a, x), (b, y)] if op == Op.ADD:
                return _sum(dag, a, b), dag.add(x, y)
            case [(a, x), (b, y)] if op == Op.SUB:
                return _sum(dag, a, {k: dag.neg(c) for k, c in b.items()}), dag.sub(x, y)
            case [(a, x), (b, y)] if op == Op.MUL and not b:
                return {k: dag.mul(c, y) for k, c in a.items()}, dag.mul(x, y)
            case [(a, x), (b, y)] if op == Op.MUL and not a:
                return {k: dag.mul(x, c) for k, c in b.items()}, dag.mul(x, y)
            case [(a, x), (b, y)] if op == Op.DIV and not b:
                return {k: dag.div(c, y) for k, c in a.items()}, dag.div(x, y)
            case [(c, z), (a, x), (b, y)] if op == Op.SELECT and not c:
                merged = {
                    k: dag.select(z, a.get(k, dag.zero), b.get(k, dag.zero)) for k in {**a, **b}
                }
                return merged, dag.select(z, x, y)
            case _ if not any(coefficients for coefficients, _ in operands):
                return {}, dag.rebuild(node, tuple(rest for _, rest in operands))
            case _:
                return None

    def _known(self, node: Node, forms: Mapping[Node, _Form]) -> _Form:
        if node in forms:
            return forms[node]
        return {}, self._outside[node]

    def solve_linear(
        self, torn: Sequence[Node], residuals: Sequence[Node], forms: Mapping[Node, _Form]
    ) -> tuple[dict[Node, Node], LoopKind]:
        """The torn variables as final nodes, and what their matrix is made of."""
        dag = self._dag
        column = {symbol: k for k, symbol in enumerate(torn)}
        matrix, right = [], []
        for symbol, target in zip(torn, residuals, strict=True):
            coefficients, rest = self._known(target, forms)
            row = {column[s]: c for s, c in coefficients.items()}
            if symbol not in self._equation_of:
                own = column[symbol]
                row[own] = dag.sub(row.get(own, dag.zero), dag.one)
            matrix.append(row)
            right.append(dag.neg(rest))
        try:
            values = solve_general(
                dag, self._fingerprints, matrix, right, self._preference, self._watch(torn[0])
            )
        except SingularSystemError:
            raise self._variables.places.unsolvable(torn) from None
        highest = max(dag.level[node] for row in matrix for node in row.values())
        kind = LoopKind.CONSTANT if highest <= Level.PARAM else LoopKind.VARYING
        return dict(zip(torn, values, strict=True)), kind

    def report(self, torn: Sequence[Node], kind: LoopKind, solution: LoopSolution) -> Loop:
        """What the user is told of the loop."""
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

    def _watch(self, symbol: Node) -> Callable[[Node], None]:
        """Have the runtime check parameters that the solution divides by."""
        message = f"the algebraic loop at `{self._variables.places.name_of(symbol)}` is singular"

        def note(pivot: Node) -> None:
            if self._dag.level[pivot] == Level.PARAM:
                self._variables.watch(pivot, message)

        return note

    def _preference(self, node: Node) -> int:
        """Constants are the best pivots, then what only parameters change."""
        return {Level.CONST: 0, Level.PARAM: 1}.get(Level(self._dag.level[node]), 2)

    # --- any loops --------------------------------------------------------------------------

    def evaluate(self, order: Sequence[Node], solution: Mapping[Node, Node]) -> dict[Node, Node]:
        """The final nodes of all members, the torn ones being known."""
        dag = self._dag
        final = dict(solution)

        def known(node: Node) -> Node:
            return final[node] if node in final else self._outside[node]

        for node in order:
            if dag.op[node] == Op.SYMBOL:
                final[node] = known(self.target(node))
            else:
                final[node] = dag.rebuild(node, tuple(known(x) for x in dag.operands(node)))
        return final

    def invert(
        self, symbol: Node, target: Node, final: Mapping[Node, Node], stand_in: Node
    ) -> Node | None:
        """The only torn variable in closed form, if its law can be turned round."""
        dag = self._dag
        value = final[target] if target in final else self._outside[target]
        residual = value if symbol in self._equation_of else dag.sub(value, stand_in)
        return solve_for(dag, residual, dag.zero, stand_in)

    def require_regular(self, states: Sequence[AlgebraicState], unknowns: Sequence[Node]) -> None:
        """Refuse residuals whose Jacobian is singular for all values."""
        rows = [
            [
                self._fingerprints.value(node)[0]
                for node in gradient(self._dag, s.residual, unknowns)
            ]
            for s in states
        ]
        if _is_singular(rows):
            raise self._variables.places.unsolvable([state.symbol for state in states])


def _sum(dag: Dag, a: Mapping[Node, Node], b: Mapping[Node, Node]) -> dict[Node, Node]:
    total = dict(a)
    for key, node in b.items():
        total[key] = dag.add(total[key], node) if key in total else node
        if total[key] == dag.zero:
            del total[key]
    return total


def _is_singular(rows: list[list[int]]) -> bool:
    """Gaussian elimination modulo the prime."""
    for k in range(len(rows)):
        chosen = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if chosen is None:
            return True
        rows[k], rows[chosen] = rows[chosen], rows[k]
        inverse = pow(rows[k][k], -1, PRIME)
        for i in range(k + 1, len(rows)):
            if rows[i][k]:
                factor = rows[i][k] * inverse % PRIME
                rows[i] = [(x - factor * y) % PRIME for x, y in zip(rows[i], rows[k], strict=True)]
    return False
