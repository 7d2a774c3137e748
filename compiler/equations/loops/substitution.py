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
from bgc.equations.loops.rates import RateTerms, rate_terms
from bgc.equations.variables.definitions import Explicit, Kept, Rate, Unknown, Variables
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
        self.rates = dict(rates)
        self._equation_of = equation_of
        self.final: dict[Node, Node] = {}
        self.algebraic: list[AlgebraicState] = []
        self.residuals: dict[Node, Node] = {}  # of the unknowns of loops, all as final nodes
        self._unknown_rates: dict[Node, Node] = {}  # unknown of a loop -> its raw rate
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
        rate = self.rates.get(number)
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
                    yield from self._rates_in(node, self.final[of]).values()
            case Kept(residual):
                yield from self._rates_in(node, residual).values()

    def _is_free(self, symbol: Symbol) -> bool:
        """Return whether a symbol stays: the rate of a declared state in an equation does."""
        declared = symbol.kind is Kind.RATE and symbol.index < self._declared
        return symbol.kind in self._free or declared

    def _rates_in(self, node: Node, of: Node) -> dict[Node, Node]:
        """The raw rates of the states and unknowns in a final node whose rate a raw node is."""
        found: dict[Node, Node] = {}
        for inner, symbol in self._dag.symbols_in([of]).items():
            if symbol.kind in {Kind.PARAM, Kind.TIME}:
                continue
            rate = self.rates.get(symbol.index) if symbol.kind is Kind.STATE else None
            if rate is None and inner not in self.residuals:
                raise self._variables.places.no_rate(node, symbol)
            found[inner] = self.rate_of_unknown(inner, node) if rate is None else rate
        return found

    def rate_of_unknown(self, unknown: Node, asking: Node) -> Node:
        """The raw rate of a loop's unknown, with which its residual stays zero.

        In messages it belongs to the element of the raw symbol that asks for it first.
        """
        if unknown not in self._unknown_rates:
            element = self._variables.places.element_of(asking)
            kept = Kept(self.residuals[unknown])
            self._unknown_rates[unknown] = self._variables.new_rate(kept, element)
        return self._unknown_rates[unknown]

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
            case Unknown() | Kept():
                raise self._variables.places.unsolvable([node])

    def _rate(self, symbol: Node, of: Node) -> Node:
        direction = {self._dag.symbol(Kind.TIME): self._dag.one}
        rates = self._rates_in(symbol, of).items()
        direction |= {inner: self.final[rate] for inner, rate in rates}
        return directional_derivative(self._dag, of, direction)

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
        if solved.states or not (self._is_one_law(members) or self._are_rates(members)):
            self.loops.append(solved.loop)

    def _are_rates(self, members: Sequence[Node]) -> bool:
        """Return whether a cycle is that of the rates of a loop's unknowns alone."""
        return all(isinstance(self._variables.definitions.get(node), Kept) for node in members)

    def _rates_among(self, members: Sequence[Node]) -> dict[Node, RateTerms]:
        """The rates in a loop of nodes that do not belong to it themselves."""
        found: dict[Node, RateTerms] = {}
        for node in members:
            if self._dag.symbol_of(node) is None:
                continue
            match self._variables.define(node):
                case Rate(raw) if raw in self.final:
                    of = self.final[raw]
                    self.rates_read.append((node, of))
                case Kept(of):
                    pass
                case _:
                    continue
            found[node] = rate_terms(self._dag, of, self._rates_in(node, of))
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
