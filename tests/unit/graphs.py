"""Small flat graphs for tests of the passes after elaboration, without the front end."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from bgc.algebra.dag import Dag, Kind
from bgc.causality.assign import assign
from bgc.diagnostics.diagnostic import accepted
from bgc.diagnostics.source import Source as Text
from bgc.diagnostics.source import Span
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import (
    Bond,
    Element,
    EnergyLaw,
    Equation,
    ExplicitLaw,
    FlatGraph,
    Form,
    Guard,
    Gyrator,
    Gyristor,
    Initial,
    Junction,
    Law,
    LinearLaw,
    Matrix,
    Node,
    Observation,
    Parameter,
    Port,
    Resistor,
    Source,
    State,
    Storage,
    Transformer,
    Unknown,
)
from bgc.ir.scene_nodes import DeviceUse
from bgc.language.column_names import AccountColumn
from bgc.language.scene import Scene

SPAN = Span(Text("<test>", "test"), 0, 4)

Number = int | float | Fraction | str  # a string names a parameter


@dataclass
class GraphBuilder:
    """Collects elements and bonds by name; `build` makes the flat graph.

    Bonds reach an element's ports in the order in which they are made.
    """

    dag: Dag = field(default_factory=Dag)
    accounts: tuple[str, ...] = ()
    bonds: list[tuple[str, str, bool]] = field(default_factory=list)
    parameters: list[Parameter] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    unknowns: list[Unknown] = field(default_factory=list)
    equations: list[Equation] = field(default_factory=list)
    observations: list[Observation] = field(default_factory=list)
    guards: list[Guard] = field(default_factory=list)
    devices: list[DeviceUse] = field(default_factory=list)
    kept: tuple[str, ...] = ()
    _makers: dict[str, Callable[[list[Port]], Element]] = field(default_factory=dict)
    _storages: int = 0
    _first_state: dict[str, int] = field(default_factory=dict)

    # --- values -----------------------------------------------------------------------

    def node(self, value: Number) -> Node:
        if isinstance(value, str):
            return self.param(value)
        return self.dag.const(value)

    def param(self, name: str, default: int | float | Fraction | None = None) -> Node:
        for parameter in self.parameters:
            if parameter.name == name:
                return self.dag.symbol(Kind.PARAM, parameter.index)
        assert default is not None, name
        index = len(self.parameters)
        self.parameters.append(
            Parameter(index, name, "", self.dag.const(default), None, None, SPAN)
        )
        return self.dag.symbol(Kind.PARAM, index)

    def matrix(self, rows: list[list[Number]]) -> Matrix:
        return tuple(tuple(self.node(x) for x in row) for row in rows)

    def effort(self, bond: int) -> Node:
        return self.dag.symbol(Kind.EFFORT, bond)

    def flow(self, bond: int) -> Node:
        return self.dag.symbol(Kind.FLOW, bond)

    def q(self, name: str, port: int = 0) -> Node:
        return self.dag.symbol(Kind.DISPLACEMENT, self._first_state[name] + port)

    def p(self, name: str, port: int = 0) -> Node:
        return self.dag.symbol(Kind.MOMENTUM, self._first_state[name] + port)

    # --- elements ---------------------------------------------------------------------

    def junction(self, kind: str, *names: str) -> None:
        for name in names:
            self._makers[name] = lambda ports, name=name: Junction(  # type: ignore[misc]
                name, kind, tuple(ports), SPAN
            )

    def source(self, kind: str, name: str, value: Node) -> None:
        self._makers[name] = lambda ports: Source(name, kind, ports[0], value, SPAN)

    def storage(
        self,
        kind: str,
        name: str,
        law: Law | Number | list[list[Number]],
        form: Form | None = None,
        width: int = 1,
        **initial: Number,
    ) -> None:
        """A scalar law is the compliance of a C, the inertia of an I."""
        if not isinstance(law, LinearLaw | ExplicitLaw | EnergyLaw):
            rows = law if isinstance(law, list) else [[law]]
            width = len(rows)
            default = Form.DISPLACEMENT if kind == "C" else Form.MOMENTUM
            law = LinearLaw(form or default, self.matrix(rows))
        final = law
        first = self._storages
        self._storages += width
        self._first_state[name] = first
        given = tuple(Initial(0, key[0], self.node(v), SPAN) for key, v in initial.items())
        self._makers[name] = lambda ports: Storage(
            name, kind, tuple(ports), final, first, given, SPAN
        )

    def next_state(self, kind: Kind, port: int = 0) -> Node:
        """The symbol of the charge or momentum of the storage that is made next."""
        return self.dag.symbol(kind, self._storages + port)

    def resistor(
        self, name: str, law: ExplicitLaw | Number | list[list[Number]], form: Form = Form.EFFORT
    ) -> None:
        if not isinstance(law, ExplicitLaw):
            rows = law if isinstance(law, list) else [[law]]
            final: LinearLaw | ExplicitLaw = LinearLaw(form, self.matrix(rows))
        else:
            final = law
        self._makers[name] = lambda ports: Resistor(name, tuple(ports), final, SPAN)

    def transformer(
        self, name: str, matrix: Matrix | Number, given: str = "f2", inverse: Matrix | None = None
    ) -> None:
        m = matrix if isinstance(matrix, tuple) else ((self.node(matrix),),)
        self._makers[name] = lambda ports: Transformer(
            name, given, *_sides(ports), m, inverse, SPAN
        )

    def gyrator(self, name: str, matrix: Matrix | Number) -> None:
        m = matrix if isinstance(matrix, tuple) else ((self.node(matrix),),)
        self._makers[name] = lambda ports: Gyrator(name, *_sides(ports), m, SPAN)

    def gyristor(self, name: str, matrix: Matrix) -> None:
        self._makers[name] = lambda ports: Gyristor(name, tuple(ports), matrix, SPAN)

    # --- the rest ----------------------------------------------------------------------

    def draw(self, text: str) -> None:
        """Elements and bonds as text: `supply : Se(1); c : C(2, q0=1); supply -> node -> c, r;`.

        A value is a number or names a parameter, that of a C its compliance, of an I its inertia.
        """
        for statement in filter(None, map(str.strip, text.replace("\n", " ").split(";"))):
            if " -> " in statement:
                *chain, last = statement.split(" -> ")
                for tail, head in pairwise(chain):
                    self.bond(tail, head)
                self.fan(chain[-1], *last.split(", "))
                continue
            names, _, kind = statement.partition(" : ")
            kind, *given = re.split(r"[(,)] ?", kind.removesuffix(")"))
            value = _number(given[0]) if given else 0
            initial = {
                key: _number(start) for key, start in (each.split("=") for each in given[1:])
            }
            for name in names.split(", "):
                if kind in ("J0", "J1"):
                    self.junction(kind, name)
                elif kind in ("Se", "Sf"):
                    self.source(kind, name, self.node(value))
                elif kind in ("C", "I"):
                    self.storage(kind, name, value, **initial)
                else:
                    make = {"R": self.resistor, "TF": self.transformer, "GY": self.gyrator}[kind]
                    make(name, value)

    def bond(self, tail: str, head: str, power: bool = True) -> int:
        """A bond, its half arrow from tail to head; its index."""
        self.bonds.append((tail, head, power))
        return len(self.bonds) - 1

    def fan(self, junction: str, *others: str) -> list[int]:
        """Bonds from a junction to several elements."""
        return [self.bond(junction, other) for other in others]

    def state(self, name: str, initial: Number, projection: Node | None = None) -> Node:
        index = len(self.states)
        self.states.append(State(index, name, "", self.node(initial), None, projection, SPAN))
        return self.dag.symbol(Kind.STATE, index)

    def derivative(self, state: Node, node: Node) -> None:
        symbol = self.dag.symbol_of(state)
        assert symbol is not None
        old = self.states[symbol.index]
        self.states[symbol.index] = State(
            old.index, old.name, old.unit, old.initial, node, old.projection, SPAN
        )

    def unknown(self, name: str, start: Number = 0) -> Node:
        self.unknowns.append(Unknown(len(self.unknowns), name, "", self.node(start), SPAN))
        return self.dag.symbol(Kind.UNKNOWN, len(self.unknowns) - 1)

    def rate(self, state: Node) -> Node:
        symbol = self.dag.symbol_of(state)
        assert symbol is not None
        return self.dag.symbol(Kind.RATE, symbol.index)

    def equation(self, residual: Node) -> None:
        self.equations.append(Equation(residual, SPAN))

    def observe(self, name: str, node: Node) -> None:
        self.observations.append(Observation(name, "", node, SPAN))

    def drop_unbonded(self) -> None:
        """Forget elements that no bond reaches."""
        bonded = {name for tail, head, _ in self.bonds for name in (tail, head)}
        for name in [n for n in self._makers if n not in bonded]:
            del self._makers[name]

    def build(self) -> FlatGraph:
        ports: dict[str, list[Port]] = {name: [] for name in self._makers}
        bonds = []
        for index, (tail, head, power) in enumerate(self.bonds):
            ports[tail].append(Port(index, -1))
            ports[head].append(Port(index, 1))
            bonds.append(Bond(index, f"{tail} -> {head}", 1, 1, "", "", power, SPAN))
        return FlatGraph(
            dag=self.dag,
            scene=Scene(
                "scene",
                "Model",
                (),
                tuple(AccountColumn(name, f"energy.{name}") for name in self.accounts),
            ),
            bonds=tuple(bonds),
            elements=tuple(make(ports[name]) for name, make in self._makers.items()),
            parameters=tuple(self.parameters),
            states=tuple(self.states),
            unknowns=tuple(self.unknowns),
            equations=tuple(self.equations),
            guards=tuple(self.guards),
            observations=tuple(self.observations),
            requirements=(),
            devices=tuple(self.devices),
            kept=self.kept,
        )


def _number(text: str) -> Number:
    """A number, or the name of a parameter."""
    if text[0].isalpha():
        return text
    value = Fraction(text)
    return int(value) if value.denominator == 1 else value


def drawn(text: str) -> GraphBuilder:
    """A graph from the text that `GraphBuilder.draw` takes."""
    g = GraphBuilder()
    g.draw(text)
    return g


def _sides(ports: list[Port]) -> tuple[tuple[Port, ...], tuple[Port, ...]]:
    return tuple(p for p in ports if p.sign > 0), tuple(p for p in ports if p.sign < 0)


def rlc(r: Number = 2, l: Number = 3, c: Number = 4, e: Number = 1) -> GraphBuilder:  # noqa: E741
    """Series RLC circuit on a constant supply; bonds: supply, coil, capacitor, resistor."""
    g = GraphBuilder()
    g.source("Se", "supply", g.node(e))
    g.junction("J1", "loop")
    g.storage("I", "coil", l)
    g.storage("C", "capacitor", c)
    g.resistor("resistor", r)
    g.draw("supply -> loop -> coil, capacitor, resistor")
    return g


def causal_of(graph: FlatGraph) -> CausalGraph:
    """The causality of a graph by the plain choice."""
    return accepted(assign(graph))
