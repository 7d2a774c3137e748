"""Resolve definitions: raw nodes become nodes in states, time, inputs and parameters.

A depth-first search over nodes and definitions (Tarjan 1972) finds the order of evaluation and the
strongly connected sets of variables. Those are algebraic loops, which `loops` solves. The search
visits only the nodes that are needed, each once.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.derivatives import directional_derivative
from bgc.algebra.strong_components import strong_components
from bgc.equations.loops.loops import AlgebraicState, solve_loop
from bgc.equations.loops.rates import RateTerms, implicit_rates, rate_terms
from bgc.equations.variables.definitions import Explicit, Rate, Unknown, Variables
from bgc.ir.graph import Node
from bgc.ir.program import Divisor, Loop, ProgramState

_FREE = frozenset({Kind.PARAM, Kind.TIME, Kind.INPUT, Kind.START, Kind.SPEED})
_FINAL = _FREE | {Kind.STATE}  # in final nodes, where a state is its number in the program


class Resolver:
    """Resolves raw nodes to final ones.

    `states` maps the raw symbols that are states to their numbers, `rates` these numbers to
    the raw derivative where there is one; `equation_of` maps an unknown to the residual that
    it is solved from. The symbols in `later` stay in final nodes.
    """

    def __init__(
        self,
        variables: Variables,
        states: Mapping[Node, int],
        rates: Mapping[int, Node],
        equation_of: Mapping[Node, Node],
        later: Collection[Node],
    ) -> None:
        self._free = _FREE
        self._variables = variables
        self._dag: Dag = variables.dag
        self._states = states
        self._rates = rates
        self._equation_of = equation_of
        self.final: dict[Node, Node] = {}
        self.algebraic: list[AlgebraicState] = []
        self.residuals: dict[Node, Node] = {}  # of the unknowns of loops, all as final nodes
        self.loops: list[Loop] = []
        self.divisors: list[Divisor] = []  # of loops, which may vanish
        self.rates_read: list[tuple[Node, Node]] = []  # raw symbol, final node whose rate it is
        self._first_algebraic = len(states)
        self._declared = len(variables.causal.graph.states)
        self._later = later

    def of_final_nodes(self, states: int, later: Collection[Node]) -> Resolver:
        """A resolver of symbols that stayed in the final nodes of a program with some states."""
        resolver = Resolver(self._variables, {}, {}, {}, later)
        resolver._free, resolver._first_algebraic = _FINAL, states
        return resolver

    def resolve(self, node: Node) -> Node:
        """The final node of a raw one."""
        if node not in self.final:
            self._search(node)
        return self.final[node]

    def resolve_all(self, nodes: Iterable[Node]) -> tuple[Node, ...]:
        """The final nodes of several raw ones."""
        return tuple(self.resolve(node) for node in nodes)

    def rate_of_state(self, number: int) -> Node | None:
        """The final rate of a state; None where equations determine it."""
        rate = self._rates.get(number)
        return None if rate is None else self.resolve(rate)

    def raw_state(self, number: int) -> Node:
        """The raw symbol of a state."""
        return next(symbol for symbol, other in self._states.items() if other == number)

    # --- the search -------------------------------------------------------------------------

    def _search(self, root: Node) -> None:
        for members, has_cycle in strong_components(root, self._needs, self.final.__contains__):
            if has_cycle:
                self._close(members)
            else:
                self.final[members[0]] = self._finish(members[0])

    def _needs(self, node: Node) -> Iterator[Node]:
        """The raw nodes that a node needs, one by one as the earlier ones are resolved."""
        symbol = self._dag.symbol_of(node)
        if symbol is None:
            yield from self._dag.operands(node)
            return
        if self._is_free(symbol) or node in self._states or node in self._later:
            return
        match self._variables.define(node):
            case Explicit(inner):
                yield inner
            case Unknown():
                yield self._equation_of[node]
            case Rate(of):
                yield of
                if of in self.final:
                    yield from self._rates_behind(node, self.final[of])

    def _is_free(self, symbol: Symbol) -> bool:
        """Return whether a symbol stays: the rate of a declared state in an equation does."""
        declared = symbol.kind is Kind.RATE and symbol.index < self._declared
        return symbol.kind in self._free or declared

    def _rates_behind(self, node: Node, of: Node) -> Iterator[Node]:
        """The derivatives of the states that a final node depends on."""
        for inner, symbol in self._varying_in(of).items():
            rate = self._rates.get(symbol.index) if symbol.kind is Kind.STATE else None
            if rate is not None:
                yield rate
            elif inner not in self.residuals:
                raise self._variables.places.no_rate(node, symbol)

    def _varying_in(self, of: Node) -> dict[Node, Symbol]:
        """The states, inputs and speeds in a final node, and in the residuals of unknowns in it."""
        found, waiting = dict[Node, Symbol](), [of]
        while waiting:
            for inner, symbol in self._dag.symbols_in([waiting.pop()]).items():
                if symbol.kind in {Kind.PARAM, Kind.TIME} or inner in found:
                    continue
                found[inner] = symbol
                if inner in self.residuals:
                    waiting.append(self.residuals[inner])
        return found

    def _finish(self, node: Node) -> Node:
        """The final node of one whose needs are all final."""
        dag = self._dag
        symbol = dag.symbol_of(node)
        if symbol is None:
            operands = dag.operands(node)
            new = tuple(self.final[x] for x in operands)
            return node if new == operands else dag.rebuild(node, new)
        if self._is_free(symbol) or node in self._later:
            return node
        if node in self._states:
            return dag.symbol(Kind.STATE, self._states[node])
        match self._variables.define(node):
            case Explicit(inner):
                return self.final[inner]
            case Rate(of):
                self.rates_read.append((node, self.final[of]))
                return self._rate(node, self.final[of])
            case Unknown():
                raise self._variables.places.unsolvable([node])

    def _rate(self, symbol: Node, of: Node) -> Node:
        dag = self._dag
        rates, unknown = self._moving(of)
        direction = {dag.symbol(Kind.TIME): dag.one}
        direction |= {inner: self.final[rate] for inner, rate in rates.items()}
        direction |= self.implicit_rates(symbol, unknown, direction)
        return directional_derivative(dag, of, direction)

    def implicit_rates(
        self, symbol: Node, unknown: Mapping[Node, Node], direction: Mapping[Node, Node]
    ) -> dict[Node, Node]:
        """The rates of unknowns that the rate of a raw symbol needs; see `rates.py`."""
        doubtful: set[Node] = set()
        found = implicit_rates(self._variables, unknown, direction, doubtful)
        self._watch(symbol, doubtful)
        return found

    def _watch(self, symbol: Node, divisors: Collection[Node]) -> None:
        """Note divisors by which a rate was found, and which may vanish."""
        places = self._variables.places
        what, span = f"a divisor of `{places.name_of(symbol)}`", places.span_of(symbol)
        self.divisors += [Divisor(node, what, span) for node in sorted(divisors)]

    def _moving(self, of: Node) -> tuple[dict[Node, Node], dict[Node, Node]]:
        """The raw rates of the states in a final node, and the residuals of the unknowns in it."""
        rates, unknown = dict[Node, Node](), dict[Node, Node]()
        for inner, symbol in self._varying_in(of).items():
            if inner in self.residuals:
                unknown[inner] = self.residuals[inner]
            else:
                rates[inner] = self._rates[symbol.index]
        return rates, unknown

    def _close(self, members: list[Node]) -> None:
        """Solve an algebraic loop; what is not linear becomes algebraic states."""
        solved = solve_loop(
            self._variables,
            self._equation_of,
            members,
            self.final,
            self._rates_among(members),
            self._first_algebraic + len(self.algebraic),
        )
        self.final.update(solved.final)
        self.divisors += solved.divisors
        for state in solved.states:
            number = self._first_algebraic + len(self.algebraic)
            self.residuals[self._dag.symbol(Kind.STATE, number)] = state.residual
            self.algebraic.append(state)
        self.resolve_all(members)  # a rate whose weight is zero needs what no unknown needs
        if solved.states or not self._is_one_law(members):
            self.loops.append(solved.loop)

    def _rates_among(self, members: Sequence[Node]) -> dict[Node, RateTerms]:
        """The rates in a loop of nodes that do not belong to it themselves."""
        found: dict[Node, RateTerms] = {}
        for node in members:
            if self._dag.symbol_of(node) is None:
                continue
            definition = self._variables.define(node)
            if isinstance(definition, Rate) and definition.of in self.final:
                self.rates_read.append((node, self.final[definition.of]))
                found[node] = self._rate_terms(node, self.final[definition.of])
        return found

    def _rate_terms(self, symbol: Node, of: Node) -> RateTerms:
        doubtful: set[Node] = set()
        found = rate_terms(self._variables, of, *self._moving(of), doubtful)
        self._watch(symbol, doubtful)
        return found

    def _is_one_law(self, members: Sequence[Node]) -> bool:
        """Return whether a cycle is the inverse law of one element, not a loop of the graph."""
        ports = self._variables.ports_among(members)
        if len({self._variables.causal.ports[k].element for k in ports}) != 1:
            return False
        laws = self._variables.laws_of(ports)
        inside = set(members) - laws
        for node in members:
            if self._dag.symbol_of(node) is None:
                continue
            terms = [term for needed in self._needs(node) for term in self._terms(needed, laws)]
            if node in laws:
                if node not in terms:
                    continue
                terms.remove(node)  # the law's result, in the balance that determines it
            if node in terms or self._leads_to(node, terms, inside):
                return False
        return True

    def _terms(self, node: Node, whole: Collection[Node]) -> list[Node]:
        """The terms of a sum; nodes in `whole` are not expanded."""
        terms: list[Node] = []
        stack = [node]
        while stack:
            inner = stack.pop()
            if self._dag.op[inner] in {Op.ADD, Op.SUB, Op.NEG} and inner not in whole:
                stack.extend(self._dag.operands(inner))
            else:
                terms.append(inner)
        return terms

    def _leads_to(self, node: Node, terms: Iterable[Node], inside: Collection[Node]) -> bool:
        """Return whether terms need a node, by way of the nodes inside."""
        stack = [term for term in terms if term in inside]
        seen = set(stack)
        while stack:
            for needed in self._needs(stack.pop()):
                if needed == node:
                    return True
                if needed in inside and needed not in seen:
                    seen.add(needed)
                    stack.append(needed)
        return False


def algebraic_states(variables: Variables, resolver: Resolver) -> list[ProgramState]:
    """The unknowns of loops that were not solved in the DAG, as states with rows of zeros in M."""
    dag, places = variables.dag, variables.places
    return [
        ProgramState(
            places.name_of(state.symbol),
            places.unit_of(state.symbol),
            "algebraic",
            dag.zero,
            state.residual,
            None,
            dag.one,
        )
        for state in resolver.algebraic
    ]
