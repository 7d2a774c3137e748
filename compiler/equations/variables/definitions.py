"""Every variable of a causal graph defined in terms of others, one step at a time.

All nodes here are *raw*: in the symbols of the flat graph (EFFORT, FLOW, DISPLACEMENT, MOMENTUM,
STATE, ...). A raw symbol is defined when it is first needed: as an expression in other raw symbols,
an unknown of an equation, the rate of another node, or a state. `loops/resolve.py` resolves the
definitions.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property
from typing import TypeAlias

from bgc.algebra.dag import Kind, Level, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.quadratic import ConstrainedEnergy
from bgc.algebra.quadratic import Definition as FlowDefinition
from bgc.algebra.signs import Signs
from bgc.causality.certificates import Certificate, Certifier
from bgc.equations.variables.balances import Balances, CausalIndex
from bgc.equations.variables.law_nodes import following_law, gyrator_law, gyristor_law, resistor_law
from bgc.equations.variables.raw_symbols import Symbols
from bgc.equations.variables.variable_names import Places
from bgc.ir.causal import BasisKind, CausalGraph, Role
from bgc.ir.graph import Form, Gyrator, Gyristor, Node, Resistor, Source, Storage
from bgc.ir.program import Divisor, PositiveParameter
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Explicit:
    """The variable is this node."""

    node: Node


@dataclass(frozen=True, slots=True)
class Unknown:
    """The variable is found from an equation (see `Variables.equations`)."""


@dataclass(frozen=True, slots=True)
class Rate:
    """The variable is the rate of change of this node."""

    of: Node


@dataclass(frozen=True, slots=True)
class Kept:
    """The variable is the rate of a loop's unknown, with which this final node stays zero."""

    residual: Node


Definition: TypeAlias = Explicit | Unknown | Rate | Kept

# A value that holds one of these is not known before the start.
_NOT_BEFORE = frozenset({Kind.EFFORT, Kind.FLOW, Kind.UNKNOWN, Kind.RATE, Kind.START})

Column: TypeAlias = tuple[str, int]
"""A resistive unknown: ("flow", independent flow), or ("port", port whose law gives a flow).

Also what a free motion moves beside these: see `motions/motions.py`.
"""

Row: TypeAlias = dict[Column, Node]


@dataclass(frozen=True, slots=True)
class Speed:
    """The speed of a free motion, at which a designated quantity follows its condition.

    `rate` is the rate of the quantity `stored`, to which the motion's speed adds.
    """

    stored: Node
    rate: Node


class Variables:
    """The definitions of a causal graph's bond variables.

    Sources and resistors are defined from the start. The storage passes define the rest:
    `set_answer` for every port of a compliance, `set_flow` for every independent through
    variable that storage determines, `set_rate_of` for every port of a merged inertia. Only
    then may `set_balances` and `define` be called.
    """

    def __init__(self, causal: CausalGraph) -> None:
        self.causal = causal
        self.dag = causal.graph.dag
        self.definitions: dict[Node, Definition] = {}
        self.equations: list[tuple[Node, Node]] = []  # residual, the unknown it is meant for
        self._answers: dict[int, Node] = {}  # port -> its across variable, bond's sense
        self._conductances: dict[int, Node] = {}  # port -> its through variable by its law
        self._ports_of_law: dict[Node, list[int]] = {}  # law of a resistance -> its ports
        self._rates = 0
        self._storage_ports = sum(
            len(e.ports) for e in causal.graph.elements if isinstance(e, Storage)
        )
        self._certifier = Certifier(
            self.dag, causal.fingerprints, causal.graph.parameters, ranged=causal.ranged
        )
        self.watched: list[PositiveParameter] = []
        self.raw_divisors: list[Divisor] = []
        self.ignored_defaults: list[str] = []  # storage elements
        self.starting: set[int] = set()  # elements with conditions of their start (`start/`)
        self.given_junctions: set[int] = set()  # elements that set the flows of inertias
        self.start_names: list[str] = []  # elements with a value given in these rows
        self.start_rows: list[Node] = []  # linear equations in START symbols, as many as these
        self.kinetic: list[tuple[ConstrainedEnergy, Mapping[int, Node]]] = []  # see `speeds.py`
        self.speeds: dict[Node, Speed] = {}
        self.multipliers: list[Node] = []  # of the closing rows, in the order of the closures
        self.resting: set[Node] = set()  # states whose rates are those at motions of speed zero
        self._rests: dict[Node, Node | None] = {}  # unknown -> its part beside free motions
        self.index = CausalIndex(causal)
        self.symbols = Symbols(causal)
        self.places = Places(causal)
        self.balances = Balances(causal, self.index, self.symbols, self.places, self._answers)
        for closure in causal.closures:
            multiplier = self.new_state(Kind.DISPLACEMENT)
            self.multipliers.append(multiplier)
            self.places.note(multiplier, causal.rows[closure.row].element)
            self.balances.close(closure.row, multiplier)
        self._answer_of_elements()

    def _answer_of_elements(self) -> None:
        """Sources answer with their value, resistors by their law or by an equation."""
        for index, members in self.index.ports_of_element.items():
            element = self.causal.graph.elements[index]
            match element:
                case Source(follows=True):
                    self._resist(members, *following_law(self.dag, element))
                case Source():
                    (k,) = members
                    if self.causal.ports[k].role is Role.EFFORT_SOURCE:
                        self._answers[k] = element.value
                case Resistor():
                    self._resist(members, *resistor_law(self.dag, element))
                case Gyristor():
                    self._resist(members, Form.EFFORT, gyristor_law(self.dag, element))
                case Gyrator():
                    law = gyrator_law(self.dag, element)
                    positions = [self.causal.ports[k].position for k in members]
                    self._resist(members, Form.EFFORT, tuple(law[p] for p in positions))
                case _:
                    pass

    def _resist(self, members: list[int], form: Form, law: tuple[Node, ...]) -> None:
        """Use a law that gives across variables directly; one for through variables is solved."""
        for k, node in zip(members, law, strict=True):
            port = self.causal.ports[k]
            if (form is Form.EFFORT) != port.dual:
                self.set_answer(k, node)
            else:
                symbol = self.symbols.across(port.bond)
                self._answers[k] = symbol
                self.definitions[symbol] = Unknown()
                self._conductances[k] = node
            if port.role is Role.RESISTANCE:
                for given in self.laws_of([k]):
                    self._ports_of_law.setdefault(given, []).append(k)

    @cached_property
    def signs(self) -> Signs:
        """The signs of final nodes, to choose pivots by."""
        return Signs(self.dag, self.defaults)

    @cached_property
    def flow_definitions(self) -> dict[int, FlowDefinition]:
        """The row of each dependent class, ordered so that no class appears in a later row.

        Sources with zero value are omitted.
        """
        dag, causal = self.dag, self.causal
        still = {
            independent.bond_class
            for k, independent in enumerate(causal.basis)
            if independent.kind is BasisKind.FLOW_SOURCE and self.independent(k) == dag.zero
        }
        found = {}
        for step in causal.steps:
            pivot = dict(step.working)[step.dependent]
            row = {
                number: dag.neg(dag.div(entry, pivot))
                for number, entry in step.working
                if number != step.dependent and number not in still
            }
            found[step.dependent] = FlowDefinition(step.dependent, row)
        return found

    def rate_of(self, node: Node, element: int) -> Node:
        """A symbol for the rate of change of a node, which belongs to an element."""
        return self.new_rate(Rate(node), element)

    def new_rate(self, definition: Rate | Kept, element: int) -> Node:
        """A symbol for a rate, which belongs to an element."""
        index = len(self.causal.graph.states) + self._rates
        self._rates += 1
        symbol = self.dag.symbol(Kind.RATE, index)
        self.set_definition(symbol, definition, element)
        return symbol

    def set_definition(self, symbol: Node, definition: Definition, element: int) -> None:
        """Define a symbol that does not belong to a bond; messages name the element."""
        self.definitions[symbol] = definition
        self.places.note(symbol, element)

    def set_answer(self, port_index: int, answer: Node) -> None:
        """Define a port's across variable, in the element's sense."""
        port = self.causal.ports[port_index]
        self._answers[port_index] = self.symbols.turned(answer, port.across_sign)

    def set_flow(self, number: int, definition: Definition) -> None:
        """Define an independent through variable."""
        self.definitions[self.symbols.of_class(number)] = definition

    def set_rate_of(self, port_index: int, state: Node, bias: Node) -> None:
        """Define a merged inertia's across variable as the rate of its state plus a bias."""
        port = self.causal.ports[port_index]
        if self.balances.answer_at(port.bond) is None:
            answer = self.dag.add(self.rate_of(state, port.element), bias)
            turned = self.symbols.turned(answer, port.across_sign)
            self.definitions[self.symbols.across(port.bond)] = Explicit(turned)

    def add_equation(self, residual: Node, unknown: Node) -> None:
        """Add an equation `residual = 0`, meant for an unknown."""
        self.equations.append((residual, unknown))

    def new_state(self, kind: Kind) -> Node:
        """A symbol for a state that belongs to no element."""
        self._storage_ports += 1
        return self.dag.symbol(kind, self._storage_ports - 1)

    def ports_among(self, members: Collection[Node]) -> list[int]:
        """The ports of resistors (and gyrators) whose laws are among some raw nodes."""
        return sorted({k for node in members for k in self._ports_of_law.get(node, ())})

    def laws_of(self, ports: Iterable[int]) -> set[Node]:
        """The nodes that the laws of ports give."""
        laws = ((self._answers.get(k), self._conductances.get(k)) for k in ports)
        return {node for pair in laws for node in pair if node is not None}

    def new_start_unknowns(self, count: int) -> list[Node]:
        """Symbols for unknowns of the start; as many rows follow in `start_rows`."""
        first = len(self.start_rows)
        return [self.dag.symbol(Kind.START, first + k) for k in range(count)]

    def new_speed(self, stored: Node, rate: Node) -> Node:
        """A symbol for the speed of a free motion, which adds to the rate of a quantity."""
        symbol = self.new_state(Kind.DISPLACEMENT)
        self.speeds[symbol] = Speed(stored, rate)
        self.places.move(symbol, stored)
        return symbol

    def set_share(self, symbol: Node, share: Node, *, alone: bool) -> None:
        """Define the contribution of free motions to an unknown flow or across variable.

        The remaining part is an unknown of the resistive equations. Where `alone` is set there is
        no such part, and the equation follows from the others.
        """
        rest = None if alone else self.new_state(Kind.DISPLACEMENT)
        self._rests[symbol] = rest
        self.definitions[symbol] = Explicit(share if rest is None else self.dag.add(rest, share))
        if rest is not None:
            self.definitions[rest] = Unknown()
            self.places.call(rest, symbol)

    def symbol_of(self, column: Column) -> Node:
        """The variable that a resistive unknown is."""
        what, k = column
        if what == "flow":
            return self.symbols.of_class(self.causal.basis[k].bond_class)
        return self.symbols.across(self.causal.ports[k].bond)

    def certificate(self, node: Node) -> Certificate | None:
        """The proof that a node never vanishes, None where there is none."""
        return self._certifier.certify(node)

    def may_divide(self, node: Node, message: str) -> bool:
        """Return whether a node never vanishes; the parameters that this takes are noted."""
        certificate = self._certifier.certify(node)
        if certificate is None:
            return False
        for watched in certificate.watched:
            self.watch(watched, message)
        return True

    def watch(self, node: Node, message: str) -> None:
        """Note a node of PARAM level that must not be zero."""
        self.watched.append(self._certifier.check(node, message))

    def may_vanish(self, node: Node) -> bool:
        """Return whether a divisor varies during a run and may reach zero."""
        varies = self.dag.level[node] > Level.PARAM
        return varies and not self._certifier.at_defaults.excludes_zero(node)

    def limits(self, node: Node) -> tuple[float, float]:
        """The least and the largest value of a node, at the parameters' defaults."""
        return self._certifier.at_defaults.limits(node)

    @property
    def defaults(self) -> Mapping[Symbol, float]:
        """The default of each parameter."""
        return self._certifier.defaults

    def default(self, node: Node) -> float:
        """The value of a node of at most PARAM level at the parameters' defaults."""
        return self._certifier.default(node)

    def at_start(self, nodes: Sequence[Node]) -> list[float] | None:
        """Values of raw nodes at the start: parameters at their defaults, inputs at zero.

        A charge or momentum counts as zero unless it is given. None where an effort, a flow or
        an unknown takes part, of the graph or of the start.
        """
        graph, dag = self.causal.graph, self.dag
        start = {dag.symbol(Kind.STATE, state.index): state.initial for state in graph.states}
        for element in graph.elements:
            if isinstance(element, Storage):
                for initial in element.initial:
                    kind = {"q": Kind.DISPLACEMENT, "p": Kind.MOMENTUM}.get(initial.variable)
                    if kind is not None:
                        symbol = dag.symbol(kind, element.first_state + initial.port)
                        start[symbol] = initial.value
        nodes = list(nodes)
        for _ in start:
            held = set(dag.reachable(nodes)) & set(start)
            if not held:
                break
            nodes = dag.substitute(nodes, {symbol: start[symbol] for symbol in held})
        values = dict(self._certifier.defaults)
        for leaf in dag.symbols_in(nodes).values():
            if leaf not in values:
                if leaf.kind in _NOT_BEFORE:
                    return None
                values[leaf] = 0.0
        return evaluate_nodes(dag, nodes, values)

    def set_balances(self) -> None:
        """Write the equations of the variables that resistors determine.

        An independent through variable is determined by the balance on it, or by the law of a
        resistor on it, whose across variable then follows from the balance.
        """
        laws = dict(self._conductances)
        for independent in self.causal.basis:
            if independent.kind is BasisKind.RESISTANCE:
                number = independent.bond_class
                unknown = self.symbols.of_class(number)
                if unknown in self._rests:
                    self._add_resting(self.balances.balance(number), unknown)
                    continue
                self.definitions[unknown] = Unknown()
                for k in self.causal.classes[number].ports:
                    port = self.causal.ports[k]
                    across = self.symbols.across(port.bond)
                    if k in laws and across not in self._rests:
                        given = self.symbols.turned(laws.pop(k), port.through_sign)
                        self.definitions[unknown] = Explicit(given)
                        unknown = across
                        break
                self.add_equation(self.balances.balance(number), unknown)
        for k, node in laws.items():
            port = self.causal.ports[k]
            residual = self.dag.sub(self.symbols.port_through(port), node)
            unknown = self.symbols.across(port.bond)
            if unknown in self._rests:
                self._add_resting(residual, unknown)
            else:
                self.add_equation(residual, unknown)

    def _add_resting(self, residual: Node, unknown: Node) -> None:
        """Add the equation of an unknown that free motions take part in, unless it is trivial."""
        rest = self._rests[unknown]
        if rest is not None:
            self.add_equation(residual, rest)

    # --- definitions ----------------------------------------------------------------------

    def define(self, symbol: Node) -> Definition:
        """The definition of a raw symbol; a symbol without one is a bond's variable."""
        known = self.definitions.get(symbol)
        if known is None:
            leaf = self.dag.leaf(symbol)
            if leaf.kind is Kind.MOMENTUM:
                raise self.places.no_momentum(leaf.index)
            assert leaf.kind in {Kind.EFFORT, Kind.FLOW}, leaf
            if symbol == self.symbols.through(leaf.index):
                known = Explicit(self._through_of(leaf.index))
            else:
                known = Explicit(self.balances.across_of(leaf.index))
            self.definitions[symbol] = known
        return known

    def _through_of(self, bond: int) -> Node:
        causal, dag = self.causal, self.dag
        number = causal.class_of[bond]
        first = causal.classes[number].bonds[0]
        if bond != first:
            return self.symbols.through(first)
        if number in self.index.step_of:
            step = causal.steps[self.index.step_of[number]]
            pivot = dict(step.working)[number]
            return dag.sum(
                dag.neg(dag.mul(dag.div(entry, pivot), self.symbols.of_class(other)))
                for other, entry in step.working
                if other != number
            )
        if self.index.kind_of[number] is BasisKind.FLOW_SOURCE:
            return self.source_of(number).value
        raise self.places.undetermined(bond, through=True)

    def independent(self, k: int) -> Node:
        """The through variable of a basis flow: its symbol, or the value that a source sets."""
        basis = self.causal.basis[k]
        if basis.kind is BasisKind.FLOW_SOURCE:
            return self.source_of(basis.bond_class).value
        return self.symbols.of_class(basis.bond_class)

    def source_of(self, number: int) -> Source:
        """The source that sets the through variable of a class."""
        for k in self.causal.classes[number].ports:
            port = self.causal.ports[k]
            source = self.causal.graph.elements[port.element]
            if port.role is Role.FLOW_SOURCE and isinstance(source, Source):
                return source
        raise AssertionError(f"class {number} has no source of its through variable")
