"""Every variable of a causal graph defined in terms of others, one step at a time.

All nodes here are *raw*: in the symbols of the flat graph (EFFORT, FLOW, DISPLACEMENT, MOMENTUM,
STATE, ...). A raw symbol is given a meaning only when somebody needs it: an expression in other
raw symbols, an unknown of an equation to be solved, the rate of another node, or a state.
`resolve` puts the definitions together.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from bgc.causal import BasisKind, CausalGraph, ElementPort, Role
from bgc.certificates import Certifier
from bgc.dag import Kind
from bgc.evaluate import evaluate_nodes
from bgc.grammar.catalogue import causality as catalogue
from bgc.grammar.diagnostics import BgError
from bgc.grammar.source import Span
from bgc.graph import Form, Gyrator, Gyristor, Junction, Node, Resistor, Source, Storage
from bgc.laws import gyrator_law, gyristor_law, resistor_law
from bgc.program import PositiveParameter


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


Definition: TypeAlias = Explicit | Unknown | Rate


class Variables:
    """The definitions of a causal graph's bond variables.

    Sources and resistors are known from the start. Storage is for `storage` to fill in:
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
        self._places: dict[Node, int] = {}  # symbols that are not of bonds -> element
        self._rates = 0
        self._forces: dict[bool, list[Node]] = {}
        self._multipliers: dict[int, Node] | None = None
        self._branches: dict[int, dict[int, int]] = {}  # class -> bond -> junction behind it
        self._storage_ports = sum(
            len(e.ports) for e in causal.graph.elements if isinstance(e, Storage)
        )
        self._certifier = Certifier(self.dag, causal.fingerprints, causal.graph.parameters)
        self.watched: list[PositiveParameter] = []
        self._index_graph()
        self._answer_of_elements()

    def _index_graph(self) -> None:
        causal = self.causal
        self.ports_of_element: dict[int, list[int]] = {}
        self._port_at: dict[tuple[int, int], int] = {}  # (bond, sign) -> element port
        for k, port in enumerate(causal.ports):
            self.ports_of_element.setdefault(port.element, []).append(k)
            self._port_at[port.bond, port.sign] = k
        self._row_ends: dict[tuple[int, int], list[tuple[int, Node]]] = {}
        for index, row in enumerate(causal.rows):
            for end in row.ends:
                self._row_ends.setdefault((end.bond, end.sign), []).append((index, end.coefficient))
        self._junction_at = {
            (port.bond, port.sign): index
            for index, element in enumerate(causal.graph.elements)
            if isinstance(element, Junction)
            for port in element.ports
        }
        self._kind_of = {b.bond_class: b.kind for b in causal.basis}
        self._step_of = {step.dependent: k for k, step in enumerate(causal.steps)}
        self._steps_with: list[list[tuple[int, Node]]] = [[] for _ in causal.classes]
        for k, step in enumerate(causal.steps):
            for number, entry in step.working:
                self._steps_with[number].append((k, entry))

    def _answer_of_elements(self) -> None:
        """Sources answer with their value, resistors by their law or by an equation."""
        for index, members in self.ports_of_element.items():
            element = self.causal.graph.elements[index]
            match element:
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
        """A law that gives the across variables answers; one that gives the other is solved."""
        for k, node in zip(members, law, strict=True):
            port = self.causal.ports[k]
            if (form is Form.EFFORT) != port.dual:
                self.set_answer(k, node)
            else:
                symbol = self.across(port.bond)
                self._answers[k] = symbol
                self.definitions[symbol] = Unknown()
                self.add_equation(self.dag.sub(self.port_through(port), node), symbol)

    # --- names of variables ---------------------------------------------------------------

    def through(self, bond: int) -> Node:
        """The symbol of a bond's through variable."""
        kind = Kind.EFFORT if self.causal.dual[bond] else Kind.FLOW
        return self.dag.symbol(kind, bond)

    def across(self, bond: int) -> Node:
        """The symbol of a bond's across variable."""
        kind = Kind.FLOW if self.causal.dual[bond] else Kind.EFFORT
        return self.dag.symbol(kind, bond)

    def class_through(self, number: int) -> Node:
        """The symbol that stands for a class: the through variable of its first bond."""
        return self.through(self.causal.classes[number].bonds[0])

    def independent(self, k: int) -> Node:
        """The through variable of a basis flow: its symbol, or the value that a source sets."""
        basis = self.causal.basis[k]
        if basis.kind is BasisKind.FLOW_SOURCE:
            return self.source_of(basis.bond_class).value
        return self.class_through(basis.bond_class)

    def port_through(self, port: ElementPort) -> Node:
        """A port's through variable in the element's sense."""
        return self._turned(self.through(port.bond), port.turn_through)

    def port_across(self, port: ElementPort) -> Node:
        """A port's across variable in the element's sense."""
        return self._turned(self.across(port.bond), port.turn_across)

    def _turned(self, node: Node, sign: int) -> Node:
        return node if sign > 0 else self.dag.neg(node)

    def rate_of(self, node: Node, element: int) -> Node:
        """A symbol for the rate of change of a node, which belongs to an element."""
        index = len(self.causal.graph.states) + self._rates
        self._rates += 1
        symbol = self.dag.symbol(Kind.RATE, index)
        self.set_definition(symbol, Rate(node), element)
        return symbol

    def set_definition(self, symbol: Node, definition: Definition, element: int) -> None:
        """Say what a symbol other than a bond's is; messages name the element."""
        self.definitions[symbol] = definition
        self._places[symbol] = element

    def set_answer(self, port_index: int, answer: Node) -> None:
        """Say what a port's across variable is, in the element's sense."""
        port = self.causal.ports[port_index]
        self._answers[port_index] = self._turned(answer, port.turn_across)

    def set_flow(self, number: int, definition: Definition) -> None:
        """Say what an independent through variable is."""
        self.definitions[self.class_through(number)] = definition

    def set_rate_of(self, port_index: int, state: Node, bias: Node) -> None:
        """Say that a merged inertia's across variable is the rate of its state, and a bias."""
        port = self.causal.ports[port_index]
        if self._answer_at(port.bond) is None:
            answer = self.dag.add(self.rate_of(state, port.element), bias)
            turned = self._turned(answer, port.turn_across)
            self.definitions[self.across(port.bond)] = Explicit(turned)

    def add_equation(self, residual: Node, unknown: Node) -> None:
        """Add an equation `residual = 0`, meant for an unknown."""
        self.equations.append((residual, unknown))

    def new_state(self, kind: Kind) -> Node:
        """A symbol for a state that is no element's own."""
        self._storage_ports += 1
        return self.dag.symbol(kind, self._storage_ports - 1)

    def may_divide(self, node: Node, message: str) -> bool:
        """Whether a node never vanishes; the parameters that this takes are noted."""
        certificate = self._certifier.certify(node)
        if certificate is None:
            return False
        self.watched.extend(
            PositiveParameter(watched, message, strictly_positive=False)
            for watched in certificate.watched
        )
        return True

    def default(self, node: Node) -> float:
        """The value of a node of at most PARAM level at the parameters' defaults."""
        return self._certifier.default(node)

    def at_start(self, nodes: Sequence[Node]) -> list[float] | None:
        """Values of raw nodes at the start: parameters at their defaults, inputs at zero.

        A charge or momentum counts as zero unless it is given. None where an effort, a flow or
        an unknown takes part.
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
        for leaf in map(dag.symbol_of, dag.reachable(nodes)):
            if leaf is not None and leaf not in values:
                if leaf.kind in {Kind.EFFORT, Kind.FLOW, Kind.UNKNOWN, Kind.RATE}:
                    return None
                values[leaf] = 0.0
        return evaluate_nodes(dag, nodes, values)

    def set_balances(self) -> None:
        """Write the equations of the independent through variables that resistors determine."""
        for independent in self.causal.basis:
            if independent.kind is BasisKind.RESISTANCE:
                symbol = self.class_through(independent.bond_class)
                self.definitions[symbol] = Unknown()
                self.add_equation(self.balance(independent.bond_class), symbol)

    # --- definitions ----------------------------------------------------------------------

    def define(self, symbol: Node) -> Definition:
        """What a raw symbol is; of one that has not been told, a bond's variable."""
        known = self.definitions.get(symbol)
        if known is None:
            leaf = self.dag.symbol_of(symbol)
            assert leaf is not None, symbol
            assert leaf.kind in {Kind.EFFORT, Kind.FLOW}, leaf
            if symbol == self.through(leaf.index):
                known = Explicit(self._through_of(leaf.index))
            else:
                known = Explicit(self._across_of(leaf.index))
            self.definitions[symbol] = known
        return known

    def _through_of(self, bond: int) -> Node:
        causal, dag = self.causal, self.dag
        number = causal.class_of[bond]
        first = causal.classes[number].bonds[0]
        if bond != first:
            return self.through(first)
        if number in self._step_of:
            step = causal.steps[self._step_of[number]]
            pivot = dict(step.working)[number]
            return dag.sum(
                dag.neg(dag.mul(dag.div(entry, pivot), self.class_through(other)))
                for other, entry in step.working
                if other != number
            )
        if self._kind_of[number] is BasisKind.FLOW_SOURCE:
            return self.source_of(number).value
        raise self._undetermined(bond, through=True)

    def source_of(self, number: int) -> Source:
        """The source that sets the through variable of a class."""
        for k in self.causal.classes[number].ports:
            port = self.causal.ports[k]
            source = self.causal.graph.elements[port.element]
            if port.role is Role.FLOW_SOURCE and isinstance(source, Source):
                return source
        raise AssertionError(f"class {number} has no source of its through variable")

    # --- errors -----------------------------------------------------------------------------

    def unsolvable(self, symbols: Sequence[Node]) -> BgError:
        """The error of equations without a single solution for these unknowns."""
        places = [self._place(symbol) for symbol in symbols]
        names = list(dict.fromkeys(name for name, _ in places))
        return BgError([catalogue.singular_loop(places[0][1], names)])

    def rate_in_loop(self, symbols: Sequence[Node]) -> BgError:
        """The error of a loop through the rate of a merged variable."""
        leaves = [s for s in symbols if not isinstance(self.define(s), Rate)]
        places = [self._place(symbol) for symbol in leaves or symbols]
        names = list(dict.fromkeys(name for name, _ in places))
        return BgError([catalogue.derivative_loop(places[0][1], names)])

    def no_rate(self, symbol: Node) -> BgError:
        """The error of a rate that would need the rate of an input or of a loop's unknown."""
        name, span = self._place(symbol)
        return BgError([catalogue.rate_unknown(span, name)])

    def name_of(self, symbol: Node) -> str:
        """The name of a variable that becomes an algebraic state: `coil.bond.f`."""
        leaf = self.dag.symbol_of(symbol)
        assert leaf is not None
        letter = {Kind.EFFORT: "e", Kind.FLOW: "f", Kind.DISPLACEMENT: "q"}.get(leaf.kind, "p")
        return f"({self._place(symbol)[0]}).{letter}"

    def unit_of(self, symbol: Node) -> str:
        """The unit of an effort or flow that becomes an algebraic state."""
        leaf = self.dag.symbol_of(symbol)
        assert leaf is not None
        if leaf.kind not in {Kind.EFFORT, Kind.FLOW}:
            return ""
        bond = self.causal.graph.bonds[leaf.index]
        return bond.effort_unit if leaf.kind is Kind.EFFORT else bond.flow_unit

    def _place(self, symbol: Node) -> tuple[str, Span]:
        """What to call a raw symbol in a message, and where it is."""
        graph = self.causal.graph
        leaf = self.dag.symbol_of(symbol)
        assert leaf is not None
        if leaf.kind in {Kind.EFFORT, Kind.FLOW}:
            return graph.bonds[leaf.index].name, graph.bonds[leaf.index].span
        if symbol in self._places:
            element = graph.elements[self._places[symbol]]
            return element.name, element.span
        raise AssertionError(f"{leaf} has no place")

    def _undetermined(self, bond: int, *, through: bool) -> BgError:
        what = "flow" if through != self.causal.dual[bond] else "effort"
        facts = self.causal.graph.bonds[bond]
        return BgError([catalogue.nothing_determines(facts.span, facts.name, what)])

    # --- across variables -------------------------------------------------------------------

    def _across_of(self, bond: int) -> Node:
        """The across variable of a bond, from whichever of its ends determines it."""
        ends = ((bond, 1), (bond, -1))
        answer = self._answer_at(bond)
        if answer is not None:
            return answer
        for end in ends:
            answer = self._answer_beside(end)
            if answer is not None:
                return answer
        for end in ends:
            if end in self._port_at:
                return self.reaction(self._port_at[end])
        for end in ends:
            if end in self._row_ends:
                return self._at_row(end)
        if (bond, 1) in self._junction_at and (bond, -1) in self._junction_at:
            return self._between_junctions(bond)
        return self.dag.zero  # a side of a transformer that nothing is carried to

    def _answer_at(self, bond: int) -> Node | None:
        for sign in (1, -1):
            port = self._port_at.get((bond, sign))
            if port in self._answers:
                return self._answers[port]
        return None

    def _answer_beside(self, end: tuple[int, int]) -> Node | None:
        """At a summing junction, whose bonds share the across variable: that of another one."""
        for row_index, _ in self._row_ends.get(end, ()):
            row = self.causal.rows[row_index]
            if isinstance(self.causal.graph.elements[row.element], Junction):
                for other in row.ends:
                    answer = self._answer_at(other.bond)
                    if answer is not None:
                        return answer
        return None

    def _at_row(self, end: tuple[int, int]) -> Node:
        """At a summing junction or transformer: what the rows' multipliers amount to."""
        multipliers = self._find_multipliers()
        total = self.dag.zero
        for row, coefficient in self._row_ends[end]:
            if row not in multipliers:
                raise self._undetermined(end[0], through=False)
            term = self.dag.mul(coefficient, multipliers[row])
            total = self.dag.add(total, term)
        return self._turned(total, end[1])

    def _find_multipliers(self) -> dict[int, Node]:
        """The multipliers of the raw rows: those of the working rows, elimination undone."""
        if self._multipliers is None:
            causal, dag = self.causal, self.dag
            forces = self._step_forces(reactions=True)
            found: dict[int, Node] = {}
            taken: dict[int, list[tuple[int, Node]]] = {}  # row -> later rows it was taken from
            for step in causal.steps:
                for earlier, factor in step.factors:
                    taken.setdefault(earlier, []).append((step.row, factor))
            for k in range(len(causal.steps) - 1, -1, -1):
                row = causal.steps[k].row
                if row not in causal.redundant:
                    parts = (dag.mul(f, found[later]) for later, f in taken.get(row, ()))
                    found[row] = dag.sub(forces[k], dag.sum(parts))
            self._multipliers = found
        return self._multipliers

    def balance(self, number: int, sign: int = 1) -> Node:
        """A sign times what the reactions of inertias and flow sources balance on a class.

        It is the sum of the signed across variables, power into the elements positive, the
        shares of transformers and junctions included.
        """
        return self._balance(number, sign, reactions=False, without=None)

    def reaction(self, port_index: int) -> Node:
        """The across variable that a flow source, or an inertia alone on its flow, has to bear."""
        port = self.causal.ports[port_index]
        number = self.causal.class_of[port.bond]
        alone = port.role is Role.INERTIA
        return self._balance(number, -port.sign, reactions=not alone, without=port_index)

    def _balance(self, number: int, sign: int, *, reactions: bool, without: int | None) -> Node:
        """A sign times the sum on a class; reactions of inertias and flow sources or not."""
        dag = self.dag
        forces = self._step_forces(reactions)
        total = self._own_forces(number, sign, reactions, without)
        for k, entry in self._steps_with[number]:
            total = dag.add(total, self._turned(dag.mul(entry, forces[k]), sign))
        return total

    def _own_forces(self, number: int, sign: int, reactions: bool, without: int | None) -> Node:
        total = self.dag.zero
        for k in self.causal.classes[number].ports:
            port = self.causal.ports[k]
            reacts = port.role in {Role.INERTIA, Role.FLOW_SOURCE}
            if k == without or (reacts and not reactions):
                continue
            force = self.across(port.bond) if reacts else self._answers[k]
            total = self.dag.add(total, self._turned(force, sign * port.sign))
        return total

    def _step_forces(self, reactions: bool) -> list[Node]:
        """The multipliers of the steps' working rows, in order of elimination."""
        if reactions not in self._forces:
            dag = self.dag
            forces: list[Node] = []
            for k, step in enumerate(self.causal.steps):
                total = self._own_forces(step.dependent, -1, reactions, None)
                pivot = dag.one
                for other, entry in self._steps_with[step.dependent]:
                    if other == k:
                        pivot = entry
                    else:
                        total = dag.sub(total, dag.mul(entry, forces[other]))
                forces.append(dag.div(total, pivot))
            self._forces[reactions] = forces
        return self._forces[reactions]

    def _between_junctions(self, bond: int) -> Node:
        """The across variable of a bond between two junctions of common through variable."""
        number = self.causal.class_of[bond]
        if number not in self._branches:
            self._branches[number] = self._branches_of(number)
        junction = self._branches[number].get(bond)
        if junction is None:
            raise self._undetermined(bond, through=False)
        total, own = self.dag.zero, 1
        element = self.causal.graph.elements[junction]
        assert isinstance(element, Junction)
        for port in element.ports:
            if port.bond == bond:
                own = port.sign
            else:
                term = self._turned(self.across(port.bond), port.sign)
                total = self.dag.add(total, term)
        return self._turned(total, -own)

    def _branches_of(self, number: int) -> dict[int, int]:
        """The tree of junctions of a class: each inner bond, with the junction farther out.

        Empty if the junctions form a loop: what circulates there is not determined.
        """
        inner = [
            bond
            for bond in self.causal.classes[number].bonds
            if (bond, 1) in self._junction_at
            and (bond, -1) in self._junction_at
            and (bond, 1) not in self._row_ends
            and (bond, -1) not in self._row_ends
        ]
        at: dict[int, list[tuple[int, int]]] = {}
        for bond in inner:
            head, tail = self._junction_at[bond, 1], self._junction_at[bond, -1]
            at.setdefault(head, []).append((bond, tail))
            at.setdefault(tail, []).append((bond, head))
        branches: dict[int, int] = {}
        root = self._junction_at[inner[0], 1]
        seen, queue = {root}, deque([root])
        while queue:
            for bond, other in at[queue.popleft()]:
                if other not in seen:
                    seen.add(other)
                    branches[bond] = other
                    queue.append(other)
        return branches if len(branches) == len(inner) else {}
