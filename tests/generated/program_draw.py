"""Draw whole programs at random: models in models, loops, slots, fields, laws, scenes.

Every program is of a kind that an engineer could write: its units agree, its parts are passive,
its variables have the sizes of their domain. Whether it is well posed is not known beforehand;
the reference decides.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field, replace
from fractions import Fraction

from program_laws import (
    DOMAINS,
    Coefficient,
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
    Apply,
    Assign,
    Bond,
    End,
    Equation,
    Expr,
    For,
    Interface,
    Law,
    Model,
    Num,
    Observed,
    Own,
    Part,
    Port,
    Program,
    Scene,
    Statement,
    Step,
    Time,
    Unit,
    Value,
    call,
    matrix,
    read,
    unit,
    vector,
)

JOULE = unit(N=1, m=1)


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


class Drawer:
    """Draws one program."""

    def __init__(self, seed: int, wishes: Wishes) -> None:
        self.rng = random.Random(seed)
        self.wishes = wishes
        self.taken: set[str] = set()
        self.models: list[Model] = []
        self.interfaces: list[Interface] = []
        self.one_ports: list[tuple[Interface, list[Template]]] = []
        self.two_ports: list[Template] = []
        self.uses: list[tuple[str, Template]] = []

    def fresh(self, base: str) -> str:
        """A name that nothing else in the program has."""
        name, k = base, 1
        while name in self.taken:
            k += 1
            name = f"{base}{k}"
        self.taken.add(name)
        return name

    def program(self, seed: int) -> Program:
        rng = self.rng
        for _ in range(rng.choice([0, 1, 1, 2])):
            self.two_ports.append(self._two_port_model())
        if rng.random() < 0.4:
            self._one_port_family()
        main = ModelDraw(self, self.fresh("Main"), 0)
        main.network(rng.choice([1, 2, 2, 3, 3, 4, self.wishes.size]))
        main.dress()
        template = main.finish()
        scene = self._scene(main, template)
        return Program(tuple(self.models), tuple(self.interfaces), scene, seed)

    def _two_port_model(self) -> Template:
        """A part between two nodes of one domain."""
        rng = self.rng
        domain, width = rng.choice(DOMAINS), rng.choice([1, 1, 1, 2, 3])
        draw = ModelDraw(self, self.fresh(rng.choice(["Strut", "Line", "Shaft", "Link"])), 1)
        kind = rng.choice(["J0", "J1"])
        first = draw.node(kind, domain, width)
        base, tip = self.fresh("base"), self.fresh("tip")
        draw.add(Port(base, "in", width))
        draw.add(Port(tip, "out", width))
        draw.bond(End((Step(base),)), first.end)
        last = first
        if rng.random() < 0.4:
            last = draw.node(rng.choice(["J0", "J1"]), domain, width)
            draw.edge(first, last, plain=True)
        draw.bond(last.end, End((Step(tip),)))
        if rng.random() < 0.5:
            side = draw.node("J1" if kind == "J0" else "J0", domain, width)
            draw.edge(first, side, plain=True)
            draw.attach(side)
        draw.attach(first)
        draw.dress(small=True)
        return draw.finish(domain, width)

    def _one_port_family(self) -> None:
        """An interface of one port, and two models that fill its slots."""
        rng = self.rng
        domain = rng.choice(DOMAINS)
        port = Port(self.fresh("contact"), "in", 1)
        shown = self.fresh("shown")
        interface = Interface(self.fresh("Held"), (port,), (Value("output", shown, domain.effort),))
        self.interfaces.append(interface)
        filling = []
        for _ in range(2):
            draw = ModelDraw(self, self.fresh(rng.choice(["Soft", "Hard", "Damped"])), 1)
            draw.interface = interface.name
            draw.add(port)
            node = draw.node("J1", domain, 1)
            draw.bond(End((Step(port.name),)), node.end)
            for kind in rng.choice([["C"], ["R"], ["C", "R"], ["I", "C"]]):
                draw.element(kind, node)
            own = [r for r in draw.readings if r.quantity.unit == domain.effort]
            value = own[-1].expr if own else Num(Fraction(0))
            draw.add(Value("output", shown, domain.effort, value))
            template = draw.finish(domain, 1)
            template.readings.append(Reading((Step(shown),), variable(domain, "e")))
            filling.append(template)
        self.one_ports.append((interface, filling))

    def _scene(self, main: ModelDraw, template: Template) -> Scene:
        rng = self.rng
        readings = list(template.readings)
        rng.shuffle(readings)
        observed = [
            Observed(f"y{k}", r.expr, float(r.quantity.size))
            for k, r in enumerate(readings[: rng.randint(4, 8)])
        ]
        sets = []
        for path, quantity, value in main.settable:
            if rng.random() < 0.12:
                other = nice(rng, value, 0.6, 1.6)
                sets.append((path, Num(other, quantity.unit)))
        drives = []
        for name, quantity in template.inputs:

            def literal(size: Fraction, of: Unit) -> Expr:
                return Num(nice(rng, size), of)

            value_of_time = signal_of_time(rng, literal, quantity, Time(), smooth=True)
            drives.append(((Step(name),), value_of_time))
        uses = []
        for path, other in self.uses:
            if rng.random() < 0.5:
                uses.append(Part(path, other.model.name, arguments=main.arguments(other)))
        return Scene(
            tuple(uses),
            tuple(sets),
            tuple(drives),
            tuple(observed),
            Fraction(rng.choice([2, 4, 5, 10])),
            50,
            accounts=rng.random() < 0.7,
        )


@dataclass
class ModelDraw:
    """Draws the statements of one model."""

    home: Drawer
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

    # --- nodes and what joins them --------------------------------------------------------

    def node(self, kind: str, domain: Domain, width: int = 1) -> Node:
        base = {"J0": ["node", "gap", "hub"], "J1": ["motion", "loop", "speed"]}[kind]
        node = Node(self.home.fresh(self.rng.choice(base)), kind, domain, width)
        self.add(Part(node.name, kind, (width,)))
        self.nodes.append(node)
        self.show(node.name, node.common, domain, width)
        return node

    def network(self, count: int) -> None:
        """A tree of nodes with an element or two on each, and now and then a cycle."""
        rng = self.rng
        domain, width = rng.choice(DOMAINS), rng.choice([1, 1, 1, 2, 3])
        first = self.node(rng.choice(["J0", "J1"]), domain, width)
        self.attach(first)
        for _ in range(count - 1):
            before = rng.choice(self.nodes[-3:])
            if rng.random() < 0.12 and before.width == 1:
                self.chain(before)
                continue
            domain = before.domain if rng.random() < 0.7 else rng.choice(DOMAINS)
            width = before.width if rng.random() < 0.8 else rng.choice([1, 2, 3])
            node = self.node(rng.choice(["J0", "J1"]), domain, width)
            self.edge(before, node)
            self.attach(node)
        if rng.random() < 0.15:
            pairs = [
                (a, b)
                for a in self.nodes
                for b in self.nodes
                if a is not b and a.domain == b.domain and a.width == b.width
            ]
            if pairs:
                self.edge(*rng.choice(pairs))

    def edge(self, a: Node, b: Node, *, plain: bool = False) -> None:
        """Join two nodes, a's power into b."""
        rng = self.rng
        if a.width != b.width:
            self._across_widths(a, b)
            return
        alike = a.domain == b.domain
        choice = rng.random()
        if alike and (choice < 0.5 or plain):
            self.bond(a.end, b.end)
            return
        fitting = [t for t in self.home.two_ports if (t.domain, t.width) == (a.domain, a.width)]
        if alike and fitting and choice < 0.75 and not plain:
            self.part(rng.choice(fitting), a, b)
            return
        kind = rng.choice(["TF", "GY"])
        self.two_port(kind, a, b)

    def part(self, template: Template, a: Node, b: Node) -> None:
        """A part of a model's type between two nodes."""
        name = self.home.fresh("unit_")
        arguments = self.arguments(template) + self._fed(template)
        self.add(Part(name, template.model.name, arguments=arguments))
        one, two = template.model.ports
        through = self.rng.random() < 0.5
        self.bond(a.end, End((Step(name),) if through else (Step(name), Step(one.name))))
        self.bond(End((Step(name),) if through else (Step(name), Step(two.name))), b.end)
        self._shown_part((Step(name),), template, dict(arguments))

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

    def two_port(self, kind: str, a: Node, b: Node) -> None:
        """A transformer or gyrator between nodes of one width."""
        rng = self.rng
        name = self.home.fresh("gear" if kind == "TF" else "motor")
        to, of = ("f", "f") if kind == "TF" else ("e", "f")
        quantity = Quantity(
            variable(b.domain, to).size / variable(a.domain, of).size,
            variable(b.domain, to).unit / variable(a.domain, of).unit,
        )
        varies, laws, arguments = False, (), ()
        ratio: Expr
        if rng.random() < 0.25:
            ratio, varies = self._modulus(quantity), True
        elif a.width > 1 and rng.random() < 0.5:
            ratio = self._full_matrix(quantity, a.width, b.width)
        else:
            ratio = self.coefficient(quantity.size, quantity.unit)
            if rng.random() < 0.2:
                ratio = -ratio
        if rng.random() < 0.4 and a.width == 1:
            other = {"f2": "f1", "e1": "e2"} if kind == "TF" else {"e2": "f1", "e1": "f2"}
            left = rng.choice(sorted(other))
            laws = (Law(left, ratio * Own(other[left])),)
        else:
            arguments = (("ratio", ratio),)
        self.add(Part(name, kind, (a.width, b.width), arguments, laws, varies=varies))
        self.bond(a.end, End((Step(name),)))
        self.bond(End((Step(name),)), b.end)
        for letter, domain in (("e1", a.domain), ("f2", b.domain)):
            self._show_side(name, letter, domain, a.width)

    def _show_side(self, name: str, letter: str, domain: Domain, width: int) -> None:
        for k in range(width):
            component = k + 1 if width > 1 else None
            quantity = variable(domain, letter[0])
            self.readings.append(Reading((Step(name), Step(letter)), quantity, component))

    def _modulus(self, quantity: Quantity) -> Expr:
        """A ratio that varies with the time, an angle or a signal."""
        rng = self.rng
        size = self.coefficient(quantity.size, quantity.unit)
        match rng.randrange(4):
            case 0:
                rate = self.coefficient(Fraction(2), unit(rad=1, s=-1))
                return size * (2 + call("sin", rate * Time())) / 2
            case 1 if self.moduli:
                return size * (1 + rng.choice(self.moduli) / 2)
            case 2:
                return size * call("cos", self._angle())
            case _:
                return size * (Fraction(3, 2) + call("sin", self._angle()))

    def _angle(self) -> Expr:
        """A state that follows a flow, as a plain number."""
        rng = self.rng
        flows = [n for n in self.nodes if n.kind == "J1"]
        name = self.home.fresh("angle")
        if not flows:
            self.add(Value("state", name, unit(rad=1), Num(Fraction(3, 10), unit(rad=1))))
            rate = self.coefficient(Fraction(1), unit(rad=1, s=-1))
            self.add(Assign(name, rate, rate=True))
            return read(name)
        node = rng.choice(flows)
        q = variable(node.domain, "q")
        start = Num(nice(rng, q.size / 5), q.unit)
        self.add(Value("state", name, q.unit, start))
        component = rng.randint(1, node.width) if node.width > 1 else None
        self.add(Assign(name, read(node.step, "f", component=component), rate=True))
        self.readings.append(Reading((Step(name),), q))
        return read(name) / Num(q.size, q.unit)

    def _full_matrix(self, quantity: Quantity, columns: int, rows: int) -> Expr:
        table: list[list[Expr]] = []
        for i in range(rows):
            line: list[Expr] = []
            for j in range(columns):
                if i != j and self.rng.random() < 0.4:
                    line.append(Num(Fraction(0)))
                    continue
                sign = self.rng.choice([-1, 1]) if i != j else 1
                value = nice(self.rng, quantity.size * (1 if i == j else Fraction(1, 2)))
                line.append(Num(sign * value, quantity.unit))
            table.append(line)
        return matrix(table)

    def _across_widths(self, a: Node, b: Node) -> None:
        """Join nodes of different widths: a matrix, a slice of the wider, or a mux."""
        rng = self.rng
        if a.domain == b.domain and rng.random() < 0.5:
            wide, narrow = (a, b) if a.width > b.width else (b, a)
            first = rng.randint(1, wide.width - narrow.width + 1)
            end = replace(wide.end, slice=(first, first + narrow.width - 1))
            self.bond(*((end, b.end) if wide is a else (a.end, end)))
            return
        name = self.home.fresh("map_")
        f1, f2 = variable(a.domain, "f"), variable(b.domain, "f")
        quantity = Quantity(f2.size / f1.size, f2.unit / f1.unit)
        table = self._full_matrix(quantity, a.width, b.width)
        law = Law("f2", table * Own("f1"))
        self.add(Part(name, "TF", (a.width, b.width), laws=(law,)))
        self.bond(a.end, End((Step(name),)))
        self.bond(End((Step(name),)), b.end)
        self._show_side(name, "f2", b.domain, b.width)

    # --- elements -------------------------------------------------------------------------

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

    # --- larger pieces ----------------------------------------------------------------------

    def chain(self, before: Node) -> None:
        """A row of equal cells in a loop, joined by another loop."""
        rng, home, domain = self.rng, self.home, before.domain
        n = rng.randint(2, 4)
        count = home.fresh("count")
        self.add(Value("const", count, None, Num(Fraction(n))))
        i = read("i")
        cell, gap = home.fresh("cell"), home.fresh("couple")
        kinds = rng.choice([("J1", "J0"), ("J0", "J1")])
        stores = "I" if kinds[0] == "J1" else "C"
        held, between = home.fresh("mass"), home.fresh("buffer")
        q, e = variable(domain, "q"), variable(domain, "e")
        p, f = variable(domain, "p"), variable(domain, "f")
        own = (p, f, "inertia") if stores == "I" else (q, e, "compliance")
        ratio = self.coefficient(own[0].size / own[1].size, own[0].unit / own[1].unit)
        grow = rng.choice([ratio, ratio * i, ratio * (1 + i / 3)])
        body: list[Statement] = [
            Part(cell, kinds[0], index=i),
            Part(held, stores, arguments=((own[2], grow),), index=i),
            Bond(End((Step(cell, i),)), End((Step(held, i),))),
        ]
        first = For("i", Num(Fraction(1)), read(count), tuple(body))
        fitting = [t for t in home.two_ports if (t.domain, t.width) == (domain, 1)]
        joined: list[Statement]
        end, beyond = End((Step(cell, i),)), End((Step(cell, i + 1),))
        if fitting and rng.random() < 0.5:
            template = rng.choice(fitting)
            arguments = tuple(
                (name, Num(nice(rng, value), quantity.unit) * (1 + i / 4))
                for name, quantity, value in template.parameters[:1]
            )
            joined = [
                Part(between, template.model.name, arguments=arguments, index=i),
                Bond(end, End((Step(between, i),))),
                Bond(End((Step(between, i),)), beyond),
            ]
            for k in range(1, n):
                self._shown_part((Step(between, Num(Fraction(k))),), template, dict(arguments))
        else:
            kind = "R" if rng.random() < 0.3 else ("C" if kinds[1] == "J0" else "I")
            loss = Part(between, kind, index=i)
            if kind == "R":
                loss = self._resistor(loss, domain, 1)
            else:
                loss = replace(self._storage(loss, domain, 1), index=i)
            joined = [
                Part(gap, kinds[1], index=i),
                loss,
                Bond(end, End((Step(gap, i),))),
                Bond(End((Step(gap, i),)), beyond),
                Bond(End((Step(gap, i),)), End((Step(between, i),))),
            ]
            for k in range(1, n):
                self.show(between, "e", domain, 1, k)
        second = For("i", Num(Fraction(1)), read(count) - 1, tuple(joined))
        self.add(first, second)
        common = "f" if kinds[0] == "J1" else "e"
        for k in range(1, n + 1):
            self.show(cell, common, domain, 1, k)
        self.bond(before.end, End((Step(cell, Num(Fraction(1))),)))
        self.nodes.append(Node(cell, kinds[0], domain, 1, n))
        total = home.fresh("total")
        self.add(Value("signal", total, variable(domain, common).unit, shape=n))
        one = Assign(total, read(Step(cell, i), common) * 2, component=i)
        self.add(For("i", Num(Fraction(1)), read(count), (one,)))
        self.readings.append(Reading((Step(total),), variable(domain, common), n))

    def dress(self, *, small: bool = False) -> None:
        """Fields, equations and signals on top of the network."""
        rng = self.rng
        scalar = [n for n in self.nodes if n.width == 1]
        pairs = [(a, b) for a in scalar for b in scalar if a is not b and a.domain == b.domain]
        if pairs and rng.random() < (0.1 if small else 0.4):
            self.field(*rng.choice(pairs))
        wide = [n for n in self.nodes if n.width == 3 and n.kind == "J1"]
        if wide and rng.random() < 0.5:
            self._gyristor(rng.choice(wide))
        if rng.random() < (0.1 if small else 0.25):
            self._implicit()
        if rng.random() < 0.2 and scalar:
            self._swing(rng.choice(scalar))

    def field(self, a: Node, b: Node) -> None:
        """An element of two ports on two nodes."""
        rng, domain = self.rng, a.domain
        kind = rng.choice(["C", "I", "R", "R", "IC"])
        name = self.home.fresh("field")
        e, f, q, p = (variable(domain, x) for x in "efqp")
        part = Part(name, kind, (2,))
        shown = "e"
        if kind == "R":
            left, right = rng.choice([("e", "f"), ("f", "e")])
            to, of = (e, f) if left == "e" else (f, e)
            if rng.random() < 0.5:
                value = self._linear(to, of, 2, symmetric=rng.random() < 0.5)
                argument = "resistance" if left == "e" else "conductance"
                part = replace(part, arguments=((argument, value),))
            else:
                u, v = Own(right, 1), Own(right, 2)
                coefficient = self.coefficient

                def one(x: Expr, *, gentle: bool = False) -> Expr:
                    return characteristic(rng, coefficient, x, of, to, gentle=gentle)

                both = one(u - v, gentle=True)
                part = replace(
                    part, laws=(Law(left, one(u) + both, 1), Law(left, one(v) - both, 2))
                )
        elif kind in ("C", "I"):
            state, answer = ("q", "e") if kind == "C" else ("p", "f")
            of, to = variable(domain, state), variable(domain, answer)
            shown = state
            if rng.random() < 0.5:
                argument = "stiffness" if kind == "C" else "inertia"
                pair = (to, of) if kind == "C" else (of, to)
                value = self._linear(*pair, 2, symmetric=True)
                part = replace(part, arguments=((argument, value),))
            else:
                u, v = Own(state, 1), Own(state, 2)
                total = energy(rng, self.coefficient, u, of, to)
                total = total + energy(rng, self.coefficient, v, of, to)
                total = total + energy(rng, self.coefficient, u - v, of, to)
                part = replace(part, laws=(Law("H", total),))
            part = self._with_initial(part, of, to, state, answer)
        else:
            u, v = Own("q", 1), Own("q", 2)
            h = energy(rng, self.coefficient, u - v, q, e) + energy(rng, self.coefficient, u, q, e)
            m1 = self.coefficient(p.size / f.size, p.unit / f.unit)
            m2 = self.coefficient(p.size / f.size, p.unit / f.unit)
            bend = 1 + (Own("q", 2) / self.coefficient(q.size, q.unit)) ** 2
            h = h + Own("p", 1) ** 2 / (2 * m1 * (bend if rng.random() < 0.5 else Fraction(1)))
            h = h + Own("p", 2) ** 2 / (2 * m2)
            part = replace(part, laws=(Law("H", h),))
            shown = "q"
        self.add(part)
        if rng.random() < 0.5:
            self.bond(a.end, End((Step(name),), place=1))
            self.bond(b.end, End((Step(name),), place=2))
        else:
            self.bond(b.end, End((Step(name),), place=2))
            self.bond(a.end, End((Step(name),), place=1))
        self.show(name, shown, domain, 2)

    def _gyristor(self, node: Node) -> None:
        """Gyroscopic forces on three flows."""
        e, f = variable(node.domain, "e"), variable(node.domain, "f")
        size, kind = e.size / f.size, e.unit / f.unit
        x, y, z = (Num(nice(self.rng, size), kind) for _ in range(3))
        zero = Num(Fraction(0))
        table = matrix([[zero, -z, y], [z, zero, -x], [-y, x, zero]])
        name = self.home.fresh("turning")
        self.add(Part(name, "GY", (3,), laws=(Law("e", table * Own("f")),), varies=True))
        self.bond(node.end, End((Step(name),)))
        self.show(name, "e", node.domain, 3)

    def _implicit(self) -> None:
        """A plain number y that solves an equation with a growing left side."""
        rng = self.rng
        name = self.home.fresh("root")
        self.add(Value("unknown", name, PLAIN))
        y = read(name)
        left = rng.choice([y + y**3, 2 * y + call("sin", y), y + call("tanh", y), call("sinh", y)])
        drive: Expr = call("sin", self.coefficient(Fraction(1), unit(rad=1, s=-1)) * Time())
        if self.readings and rng.random() < 0.6:
            r = rng.choice(self.readings)
            drive = call("tanh", r.expr / Num(r.quantity.size, r.quantity.unit))
            if r.path[-1].name == "power":
                drive = call("sin", Time())
        self.add(Equation(left, drive))
        self.readings.append(Reading((Step(name),), Quantity(Fraction(1), PLAIN)))
        self.moduli.append(y)

    def _swing(self, node: Node) -> None:
        """A pendulum in one element, or its like in another domain."""
        if node.kind != "J1":
            return
        q, e, p, f = (variable(node.domain, x) for x in "qepf")
        name = self.home.fresh("swing")
        m = self.coefficient(p.size / f.size, p.unit / f.unit)
        top = self.coefficient(e.size, e.unit)
        at = self.coefficient(q.size, q.unit)
        h = Own("p") ** 2 / (2 * m) + top * at * (1 - call("cos", Own("q") / at))
        part = Part(name, "IC", (1,), laws=(Law("H", h),))
        if self.home.wishes.initials and self.rng.random() < 0.5:
            part = replace(part, arguments=(("q0", Num(nice(self.rng, q.size), q.unit)),))
        self.add(part)
        self.bond(node.end, End((Step(name),)))
        for letter in "qp":
            self.show(name, letter, node.domain, 1)


def draw_program(seed: int, wishes: Wishes | None = None) -> Program:
    """The program of a seed."""
    return Drawer(seed, wishes or Wishes()).program(seed)


__all__ = ["Apply", "Coefficient", "Wishes", "draw_program"]
