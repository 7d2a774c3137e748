"""Elements on a junction: sources, resistors, storage, slots."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from draw_values import Node, Reading, Statements, Template
from program_laws import (
    Domain,
    Quantity,
    characteristic,
    energy,
    nice,
    signal_of_time,
    variable,
)
from program_tree import (
    PLAIN,
    SECOND,
    Assign,
    End,
    Expr,
    Interface,
    Law,
    Num,
    Own,
    Part,
    Step,
    Time,
    Value,
    call,
    matrix,
    read,
    unit,
    vector,
)


class Elements(Statements):
    """Draws elements."""

    def attach(self, node: Node) -> None:
        """Elements on a node; nearly always one that stores energy, nearly always some loss."""
        rng = self.rng
        stores, other = ("I", "C") if node.kind == "J1" else ("C", "I")
        if rng.random() < 0.75:
            self.element(stores, node)
        if rng.random() < 0.6:
            self.element("R", node)
        if rng.random() < 0.35:
            self.element(other, node)
        if rng.random() < 0.4:
            self.element("Se" if node.kind == "J1" else "Sf", node)
        if rng.random() < 0.04:
            self.element("Sf" if node.kind == "J1" else "Se", node)
        if rng.random() < 0.1:
            self.element("R", node)
        if rng.random() < 0.06:
            self.element(stores, node)
        for interface, filling in self.home.one_ports:
            fits = filling[0].domain == node.domain and node.width == 1
            if fits and self.depth == 0 and rng.random() < 0.6:
                self._slot(node, interface, filling)

    def _slot(self, node: Node, interface: Interface, filling: list[Template]) -> None:
        rng = self.rng
        default, other = rng.sample(filling, 2)
        name = self.home.fresh("held")
        self.add(
            Part(name, default.model.name, arguments=self.arguments(default), slot=interface.name)
        )
        self.bond(node.end, End((Step(name),)))
        shown = interface.outputs[0].name
        self.readings.append(Reading((Step(name), Step(shown)), variable(node.domain, "e")))
        self.home.uses.append((name, other))

    def element(self, kind: str, node: Node) -> None:
        """One element on a node."""
        domain, width = node.domain, node.width
        base = {"I": "body", "C": "spring", "R": "damper", "Se": "push", "Sf": "feed"}[kind]
        name = self.home.fresh(base)
        part = Part(name, kind, (width,))
        if kind in ("Se", "Sf"):
            part = self._source(part, node)
        elif kind == "R":
            part = self._resistor(part, domain, width)
        else:
            part = self._storage(part, domain, width)
        self.add(part)
        if kind in ("Se", "Sf"):
            self.bond(End((Step(name),)), node.end)
        else:
            self.bond(node.end, End((Step(name),)))
        letters = {"I": "pef", "C": "qef", "R": "ef", "Se": "f", "Sf": "e"}[kind]
        for letter in letters:
            self.show(name, letter, domain, width)
        power = Quantity(domain.e0 * domain.f0, PLAIN)
        self.readings.append(Reading((Step(name), Step("power")), power))

    def _source(self, part: Part, node: Node) -> Part:
        rng = self.rng
        letter = part.type[1]
        quantity = variable(node.domain, letter)
        smooth = (node.kind == "J1") != (letter == "e")
        items: list[Expr] = []
        for _ in range(part.width[0]):
            choice = rng.random()
            if choice < 0.12 and not smooth:
                items.append(self._feedback(node, letter, quantity))
                part = replace(part, varies=True)
            elif choice < 0.22:
                items.append(read(self._input(quantity)))
            else:
                value = signal_of_time(rng, self.coefficient, quantity, Time(), smooth=smooth)
                items.append(value)
        value = items[0] if len(items) == 1 else vector(*items)
        if rng.random() < 0.3 and len(items) == 1:
            return replace(part, laws=(Law(letter, value),))
        return replace(part, arguments=((letter, value),))

    def _input(self, quantity: Quantity) -> str:
        name = self.home.fresh("given")
        self.add(
            Value("input", name, quantity.unit, Num(nice(self.rng, quantity.size), quantity.unit))
        )
        self.inputs.append((name, quantity))
        return name

    def _feedback(self, node: Node, letter: str, quantity: Quantity) -> Expr:
        """A source that a controller sets: against a flow, or along a filtered signal."""
        rng = self.rng
        of = "f" if letter == "e" else "e"
        source = read(
            node.step, of, component=rng.randint(1, node.width) if node.width > 1 else None
        )
        measured = variable(node.domain, of)
        gain = self.coefficient(quantity.size / measured.size / 2, quantity.unit / measured.unit)
        wanted = self.coefficient(measured.size, measured.unit)
        if rng.random() < 0.5:
            return gain * (wanted - source)
        name = self.home.fresh("filtered")
        lag = self.coefficient(Fraction(1, 2), SECOND)
        self.add(Value("state", name, measured.unit))
        self.add(Assign(name, (source - read(name)) / lag, rate=True))
        self.readings.append(Reading((Step(name),), measured))
        limited = call("min", call("max", wanted - read(name), -2 * wanted), 2 * wanted)
        return gain * (limited if rng.random() < 0.5 else wanted - read(name))

    def _resistor(self, part: Part, domain: Domain, width: int) -> Part:
        rng = self.rng
        e, f = variable(domain, "e"), variable(domain, "f")
        left, right = rng.choice([("e", "f"), ("f", "e")])
        to, of = (e, f) if left == "e" else (f, e)
        if rng.random() < 0.35:
            argument = "resistance" if left == "e" else "conductance"
            value = self._linear(to, of, width, symmetric=rng.random() < 0.5)
            return replace(part, arguments=((argument, value),))
        laws = self._laws(left, right, to, of, width, gentle=False)
        if rng.random() < 0.12:
            scale = 1 + call("sin", self.coefficient(Fraction(1), unit(rad=1, s=-1)) * Time()) / 2
            laws = tuple(replace(law, value=law.value * scale) for law in laws)
            return replace(part, laws=laws, varies=True)
        return replace(part, laws=laws)

    def _laws(
        self, left: str, right: str, to: Quantity, of: Quantity, width: int, *, gentle: bool
    ) -> tuple[Law, ...]:
        def one(u: Expr) -> Expr:
            return characteristic(self.rng, self.coefficient, u, of, to, gentle=gentle)

        if width == 1:
            return (Law(left, one(Own(right))),)
        return tuple(Law(left, one(Own(right, k + 1)), k + 1) for k in range(width))

    def _linear(self, to: Quantity, of: Quantity, width: int, *, symmetric: bool) -> Expr:
        """A positive coefficient: a scalar, a vector, or a matrix whose diagonal outweighs it."""
        rng = self.rng
        size, kind = to.size / of.size, to.unit / of.unit
        if width == 1 or rng.random() < 0.3:
            return self.coefficient(size, kind)
        if rng.random() < 0.3:
            return vector(*(self.coefficient(size, kind) for _ in range(width)))
        table: list[list[Expr]] = [[Num(Fraction(0))] * width for _ in range(width)]
        for i in range(width):
            table[i][i] = Num(nice(rng, size, 1.5, 3.0), kind)
            for j in range(i):
                value = nice(rng, size, 0.1, 0.4) * rng.choice([-1, 1])
                table[i][j] = Num(value, kind)
                table[j][i] = Num(value if symmetric else -value, kind)
        return matrix(table)

    def _storage(self, part: Part, domain: Domain, width: int) -> Part:
        rng = self.rng
        state, answer = ("q", "e") if part.type == "C" else ("p", "f")
        of, to = variable(domain, state), variable(domain, answer)
        kind = rng.random()
        if kind < 0.5:
            argument = rng.choice(["compliance", "stiffness"]) if part.type == "C" else "inertia"
            pair = (to, of) if argument == "stiffness" else (of, to)
            value = self._linear(*pair, width, symmetric=True)
            part = replace(part, arguments=((argument, value),))
        elif kind < 0.75 or width > 1:
            part = replace(part, laws=self._laws(answer, state, to, of, width, gentle=True))
        else:
            law = energy(rng, self.coefficient, Own(state), of, to)
            part = replace(part, laws=(Law("H", law),))
        return self._with_initial(part, of, to, state, answer)

    def _with_initial(
        self, part: Part, of: Quantity, to: Quantity, state: str, answer: str
    ) -> Part:
        rng = self.rng
        if not self.home.wishes.initials or rng.random() < 0.6:
            return part
        linear = bool(part.arguments)
        which = rng.choice([state, answer]) if linear else state
        quantity = of if which == state else to
        numbers = [
            Num(nice(rng, quantity.size) * rng.choice([-1, 1]), quantity.unit)
            for _ in range(part.width[0])
        ]
        value: Expr = numbers[0] if len(numbers) == 1 else vector(*numbers)
        return replace(part, arguments=(*part.arguments, (f"{which}0", value)))
