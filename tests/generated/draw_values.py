"""Names, values and readings of a model that is drawn."""

from __future__ import annotations

import random
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Protocol

from program_laws import (
    DOMAINS,
    Domain,
    Quantity,
    nice,
    signal_of_time,
    variable,
)
from program_tree import (
    Bond,
    End,
    Expr,
    Interface,
    Model,
    Num,
    Part,
    Statement,
    Step,
    Time,
    Unit,
    Value,
    read,
)


@dataclass(frozen=True)
class Node:
    """A junction that bonds may reach."""

    name: str
    kind: str
    domain: Domain
    width: int = 1
    index: int | None = None

    @property
    def step(self) -> Step:
        return Step(self.name, None if self.index is None else Num(Fraction(self.index)))

    @property
    def end(self) -> End:
        return End((self.step,))

    @property
    def common(self) -> str:
        return "e" if self.kind == "J0" else "f"


@dataclass(frozen=True)
class Reading:
    """A readable scalar of a model: its path, its size and unit."""

    path: tuple[Step, ...]
    quantity: Quantity
    component: int | None = None

    @property
    def expr(self) -> Expr:
        return read(*self.path, component=self.component)


@dataclass
class Template:
    """A model that may be a part: its ports' domain and width, its parameters and readings."""

    model: Model
    domain: Domain
    width: int
    parameters: list[tuple[str, Quantity, Fraction]]
    readings: list[Reading]
    inputs: list[tuple[str, Quantity]]


@dataclass(frozen=True)
class Wishes:
    """Features that a program may have."""

    initials: bool = True
    size: int = 5
    coupled: bool = False
    timed: bool = False


class Home(Protocol):
    """Facts that the models of one program share."""

    rng: random.Random
    wishes: Wishes
    models: list[Model]
    one_ports: list[tuple[Interface, list[Template]]]
    two_ports: list[Template]
    uses: list[tuple[str, Template]]

    def fresh(self, base: str) -> str: ...


@dataclass
class Statements:
    """The statements of one model as they are drawn, its values and what can be read of it."""

    home: Home
    name: str
    depth: int
    interface: str | None = None
    statements: list[Statement] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)
    readings: list[Reading] = field(default_factory=list)
    parameters: list[tuple[str, Quantity, Fraction]] = field(default_factory=list)
    inputs: list[tuple[str, Quantity]] = field(default_factory=list)
    settable: list[tuple[tuple[Step, ...], Quantity, Fraction]] = field(default_factory=list)
    moduli: list[Expr] = field(default_factory=list)  # plain signals that vary

    @property
    def rng(self) -> random.Random:
        return self.home.rng

    def add(self, *statements: Statement) -> None:
        self.statements += statements

    def bond(self, tail: End, head: End) -> None:
        self.add(Bond(tail, head))

    def finish(self, domain: Domain = DOMAINS[0], width: int = 1) -> Template:
        model = Model(self.name, tuple(self.statements), self.interface)
        self.home.models.append(model)
        return Template(model, domain, width, self.parameters, self.readings, self.inputs)

    # --- values -------------------------------------------------------------------------

    def coefficient(self, size: Fraction, of: Unit) -> Expr:
        """A number, a parameter, a constant or something made of them."""
        rng, value = self.rng, nice(self.rng, size)
        match rng.randrange(8):
            case 0 | 1 | 2:
                name = self.home.fresh("k")
                self.add(Value("param", name, of, Num(value, of)))
                quantity = Quantity(value, of)
                self.parameters.append((name, quantity, value))
                self.settable.append(((Step(name),), quantity, value))
                return read(name)
            case 3:
                name = self.home.fresh("fixed")
                self.add(Value("const", name, of, Num(value, of)))
                return read(name)
            case 4 if self.parameters:
                other, quantity, at = rng.choice(self.parameters)
                name = self.home.fresh("made")
                ratio = Num(value / 2, of) * (1 + read(other) / Num(at, quantity.unit))
                word = rng.choice(["let", "param"])
                self.add(Value(word, name, of, ratio))
                return read(name)
            case _:
                return Num(value, of)

    def arguments(self, template: Template) -> tuple[tuple[str, Expr], ...]:
        """Arguments of a part, for some of its parameters and all its inputs."""
        rng, found = self.rng, []
        for name, quantity, value in template.parameters:
            if rng.random() < 0.25:
                number = Num(nice(rng, value, 0.5, 2.0), quantity.unit)
                found.append((name, number))
        return tuple(found)

    def show(
        self, name: str, letter: str, domain: Domain, width: int, index: int | None = None
    ) -> None:
        step = Step(name, None if index is None else Num(Fraction(index)))
        for k in range(width):
            component = k + 1 if width > 1 else None
            self.readings.append(Reading((step, Step(letter)), variable(domain, letter), component))

    def _fed(self, template: Template) -> tuple[tuple[str, Expr], ...]:
        """Values for the inputs of a part."""
        found = []
        for name, quantity in template.inputs:
            if self.rng.random() < 0.7:
                value = signal_of_time(self.rng, self.coefficient, quantity, Time(), smooth=True)
                found.append((name, value))
        return tuple(found)

    def _shown_part(
        self, path: tuple[Step, ...], template: Template, arguments: dict[str, Expr]
    ) -> None:
        for r in template.readings:
            self.readings.append(replace(r, path=(*path, *r.path)))
        for name, quantity, value in template.parameters:
            self.settable.append(((*path, Step(name)), quantity, value))

    def node(self, kind: str, domain: Domain, width: int = 1) -> Node:
        base = {"J0": ["node", "gap", "hub"], "J1": ["motion", "loop", "speed"]}[kind]
        node = Node(self.home.fresh(self.rng.choice(base)), kind, domain, width)
        self.add(Part(node.name, kind, (width,)))
        self.nodes.append(node)
        self.show(node.name, node.common, domain, width)
        return node
