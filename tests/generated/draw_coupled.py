"""Networks whose parts depend on each other: wide bodies, turned matrices, moduli of flows.

Everything that stores energy may have an initial value, so that one which is missed is seen. No
modulus that is drawn here vanishes, and every matrix has its full rank whatever its angle is.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction

from draw_network import ModelDraw
from draw_values import Node, Reading, Template
from program_laws import DOMAINS, Domain, Quantity, nice, variable
from program_tree import (
    PLAIN,
    SECOND,
    Apply,
    Bond,
    End,
    Expr,
    For,
    Law,
    Num,
    Own,
    Part,
    Sampled,
    Step,
    Time,
    Value,
    call,
    choose,
    matrix,
    read,
    vector,
)

ZERO, ONE = Num(Fraction(0)), Num(Fraction(1))


@dataclass
class CoupledDraw(ModelDraw):
    """Draws the statements of one model; `stores` are its elements with states."""

    stores: list[tuple[str, str, Node]] = field(default_factory=list)

    def network(self, count: int) -> None:
        """A tree of wide nodes, nearly each with a body, joined by moduli that vary."""
        rng = self.rng
        domain, width = rng.choice(DOMAINS), rng.choice([1, 2, 3, 3, 4, 5, 6, 6])
        if self.home.two_ports and rng.random() < 0.6:
            template = rng.choice(self.home.two_ports)
            domain, width = template.domain, template.width
        self.attach(self.node("J1" if rng.random() < 0.8 else "J0", domain, width))
        for _ in range(count - 1):
            before = rng.choice(self.nodes[-3:])
            if before.width == 1 and rng.random() < 0.1:
                self.chain(before)
                continue
            domain = before.domain if rng.random() < 0.7 else rng.choice(DOMAINS)
            width = before.width if rng.random() < 0.5 else rng.choice([1, 1, 2, 2, 3, 4])
            node = self.node("J1" if rng.random() < 0.75 else "J0", domain, width)
            self.edge(before, node)
            self.attach(node)

    def attach(self, node: Node) -> None:
        """A body on nearly every node, and often a loss and a source."""
        rng = self.rng
        stores, other = ("I", "C") if node.kind == "J1" else ("C", "I")
        if rng.random() < 0.85:
            self.element(stores, node)
        if rng.random() < 0.5:
            self.element("R", node)
        if rng.random() < 0.25:
            self.element(other, node)
        if rng.random() < 0.35:
            self.element("Se" if node.kind == "J1" else "Sf", node)

    def dress(self, *, small: bool = False) -> None:
        """Gyroscopic forces that depend on flows too."""
        super().dress(small=small)
        if self.home.wishes.timed and self.stores and self.rng.random() < (0.2 if small else 0.7):
            self._sampled(*self.rng.choice(self.stores))
        bodies = [n for _, letter, n in self.stores if letter == "p" and n.width > 1]
        if bodies and self.rng.random() < 0.5:
            self._gyrating(self.rng.choice(bodies))

    def _gyrating(self, node: Node) -> None:
        """Efforts without power on two flows, whose modulus moves; not where efforts give flows."""
        e, f = variable(node.domain, "e"), variable(node.domain, "f")
        k, m = sorted(self.rng.sample(range(node.width), 2))
        size = Num(nice(self.rng, e.size / f.size), e.unit / f.unit)
        moving = self.rng.choice([call("sin", self._argument(node)), ONE])
        modulus = size * (moving if node.kind == "J1" else ONE)
        table: list[list[Expr]] = [[ZERO] * node.width for _ in range(node.width)]
        table[k][m], table[m][k] = -modulus, modulus
        name = self.home.fresh("turning")
        law = Law("e", matrix(table) * Own("f"))
        self.add(Part(name, "GY", (node.width,), laws=(law,), varies=True))
        self.bond(node.end, End((Step(name),)))
        self.show(name, "e", node.domain, node.width)

    # --- what joins nodes ---------------------------------------------------------------

    def edge(self, a: Node, b: Node, *, plain: bool = False) -> None:
        rng = self.rng
        if plain and rng.random() < 0.3:
            super().edge(a, b, plain=True)
            return
        fitting = [t for t in self.home.two_ports if (t.domain, t.width) == (a.domain, a.width)]
        alike = (a.domain, a.width) == (b.domain, b.width)
        choice = rng.random()
        if alike and fitting and choice < 0.6:
            if choice < 0.25:
                self._row_of_parts(rng.choice(fitting), a, b)
            else:
                self.part(rng.choice(fitting), a, b)
        elif choice < 0.25 and alike:
            super().edge(a, b, plain=plain)
        else:
            self._coupling(a, b)

    def _row_of_parts(self, template: Template, a: Node, b: Node) -> None:
        """Some equal parts in a loop, one behind the other."""
        n = self.rng.randint(2, 3)
        name, count, i = self.home.fresh("row"), self.home.fresh("count"), read("i")
        arguments = tuple(
            (parameter, Num(nice(self.rng, value), quantity.unit) * (1 + i / 4))
            for parameter, quantity, value in template.parameters[:1]
        )
        one, two = template.model.ports
        every = Part(name, template.model.name, arguments=arguments, index=i)
        inside = End((Step(name, i), Step(two.name))), End((Step(name, i + 1), Step(one.name)))
        self.add(
            Value("const", count, None, Num(Fraction(n))),
            For("i", ONE, read(count), (every,)),
            For("i", ONE, read(count) - 1, (Bond(*inside),)),
        )
        first, last = Step(name, ONE), Step(name, Num(Fraction(n)))
        self.bond(a.end, End((first, Step(one.name))))
        self.bond(End((last, Step(two.name))), b.end)
        for k in range(1, n + 1):
            self._shown_part((Step(name, Num(Fraction(k))),), template, {})

    def _coupling(self, a: Node, b: Node) -> None:
        """A transformer or gyrator by a matrix of a row, a column or more, which may turn."""
        rng = self.rng
        kind = "TF" if rng.random() < 0.65 else "GY"
        name = self.home.fresh("lever" if kind == "TF" else "rotor")
        left, right = rng.choice(
            [("f2", "f1"), ("e1", "e2")] if kind == "TF" else [("e2", "f1"), ("e1", "f2")]
        )
        at = {"1": a, "2": b}
        to, of = (variable(at[x[1]].domain, x[0]) for x in (left, right))
        quantity = Quantity(to.size / of.size, to.unit / of.unit)
        rows, columns = at[left[1]].width, at[right[1]].width
        varies = rng.random() < 0.75
        if rows == columns == 1:
            size = self.coefficient(quantity.size, quantity.unit)
            table = size * self._positive(self._argument(a, b)) if varies else size
        elif varies:
            table = self._table(quantity, rows, columns, self._argument(a, b))
        else:
            table = self._full_rank(quantity, rows, columns, [ZERO, ONE, -ONE])
        law = Law(left, table * Own(right))
        self.add(Part(name, kind, (a.width, b.width), laws=(law,), varies=varies))
        self.bond(a.end, End((Step(name),)))
        self.bond(End((Step(name),)), b.end)
        self._show_side(name, "e1", a.domain, a.width)
        self._show_side(name, "f2", b.domain, b.width)

    def _modulus(self, quantity: Quantity) -> Expr:
        size = self.coefficient(quantity.size, quantity.unit)
        return size * self._positive(self._argument(*self.nodes[-2:]))

    def _argument(self, *nodes: Node) -> Expr:
        """A plain number that moves: an angle, or a flow or momentum near the nodes."""
        rng = self.rng
        flows = [n for n in nodes if n.kind == "J1"]
        choice = rng.random()
        if choice < 0.35 and flows:
            return self._of_size(*self._component(rng.choice(flows), "f"))
        if choice < 0.5 and self.stores:
            name, letter, node = rng.choice(self.stores[-3:])
            component = rng.randint(1, node.width) if node.width > 1 else None
            value = read(name, letter, component=component)
            return self._of_size(value, variable(node.domain, letter))
        return self._angle()

    def _component(self, node: Node, letter: str) -> tuple[Expr, Quantity]:
        component = self.rng.randint(1, node.width) if node.width > 1 else None
        value = read(node.step, letter, component=component)
        return value, variable(node.domain, letter)

    def _of_size(self, value: Expr, quantity: Quantity) -> Expr:
        return value / self.coefficient(2 * quantity.size, quantity.unit)

    def _positive(self, u: Expr) -> Expr:
        """A number above a third, whatever u is."""
        if self.home.wishes.timed and self.rng.random() < 0.3:
            number = Quantity(ONE.value, PLAIN)
            values = [Num(nice(self.rng, ONE.value, 0.5, 2.0)) for _ in range(5)]
            return self._curve(number, values, "hold", u, ["linear", "pchip"])
        return self.rng.choice(
            [
                Fraction(3, 2) + call("sin", u),
                2 + call("cos", u),
                Fraction(3, 2) + call("tanh", u),
                1 + u**2 / 4,
                2 + call("atan", u),
                1 + call("log1p", u**2),
            ]
        )

    def _table(self, quantity: Quantity, rows: int, columns: int, u: Expr) -> Expr:
        """A matrix of full rank at every u: a rotation, or a triangle that moves."""
        sine, cosine = call("sin", u), call("cos", u)
        if rows == columns and self.rng.random() < 0.6:
            k, m = sorted(self.rng.sample(range(rows), 2))
            size = Num(nice(self.rng, quantity.size), quantity.unit)
            table: list[list[Expr]] = [
                [size if i == j else ZERO for j in range(columns)] for i in range(rows)
            ]
            table[k][k], table[k][m] = size * cosine, -size * sine
            table[m][k], table[m][m] = size * sine, size * cosine
            return matrix(table)
        return self._full_rank(quantity, rows, columns, [ZERO, ONE, sine, cosine, -sine])

    def _full_rank(self, quantity: Quantity, rows: int, columns: int, entries: list[Expr]) -> Expr:
        """Fixed numbers on the diagonal, and below it what one of the entries makes of others."""
        table: list[list[Expr]] = [[ZERO] * columns for _ in range(rows)]
        # Of a wide matrix the triangle lies above the diagonal: then its rows are independent.
        for i in range(rows):
            for j in range(columns):
                size = Num(nice(self.rng, quantity.size), quantity.unit)
                if i == j:
                    table[i][j] = size
                elif (i > j) == (rows >= columns):
                    entry = self.rng.choice(entries)
                    table[i][j] = ZERO if entry is ZERO else size * entry
        return matrix(table)

    # --- tables and sampled parts -------------------------------------------------------

    def _curve(
        self, of: Quantity, values: list[Num], outside: str, u: Expr, methods: list[str]
    ) -> Expr:
        """A curve through the values at knots about zero."""
        middle = len(values) // 2
        apart = nice(self.rng, of.size, 0.3, 1.0)
        knots = [Num((k - middle) * apart, of.unit) for k in range(len(values))]
        op = f"interpolate {self.rng.choice(methods)} {outside}"
        return Apply(op, (vector(*knots), vector(*values), u))

    def _growing(self, of: Quantity, to: Quantity, u: Expr) -> Expr:
        """A curve that grows with u and vanishes with it, with a slope everywhere."""
        steps = [nice(self.rng, to.size, 0.4, 1.2) for _ in range(4)]
        values = [-steps[0] - steps[1], -steps[1], Fraction(0), steps[2], steps[2] + steps[3]]
        numbers = [Num(value, to.unit) for value in values]
        return self._curve(of, numbers, "extrapolate", u, ["linear", "pchip"])

    def _laws(
        self, left: str, right: str, to: Quantity, of: Quantity, width: int, *, gentle: bool
    ) -> tuple[Law, ...]:
        if not self.home.wishes.timed or self.rng.random() < 0.6:
            return super()._laws(left, right, to, of, width, gentle=gentle)
        if width == 1:
            return (Law(left, self._growing(of, to, Own(right))),)
        return tuple(
            Law(left, self._growing(of, to, Own(right, k + 1)), k + 1) for k in range(width)
        )

    def _sampled(self, name: str, letter: str, node: Node) -> None:
        """A source that a sampled part sets, beside one that switches at an instant of it."""
        rng, kind = self.rng, "Se" if letter == "p" else "Sf"
        if (kind == "Se") != (node.kind == "J1"):
            return
        to, of = variable(node.domain, kind[1]), variable(node.domain, letter)
        period = Fraction(rng.choice([1, 2, 3, 5]), 10)
        component = rng.randint(1, node.width) if node.width > 1 else None
        error = self.coefficient(of.size, of.unit) - read(name, letter, component=component)
        gain = self.coefficient(to.size / of.size / 4, to.unit / of.unit)
        state, output = self.home.fresh("count"), self.home.fresh("held")
        following = read(state) / 2 + gain * error
        command = read(state) + gain * error * rng.choice([1, 2])
        start = Num(nice(rng, to.size), to.unit)
        self.add(Sampled(output, to.unit, command, state, start, following, period))
        for value in (state, output):
            self.readings.append(Reading((Step(value),), to))
        when = Num(period * rng.randint(1, 4), SECOND)
        size = self.coefficient(to.size, to.unit)
        switched = choose(call("<", Time(), when), size, -size / 2)
        commands: list[Expr] = [switched] * node.width
        commands[(component or 1) - 1] = read(output)
        value = commands[0] if node.width == 1 else vector(*commands)
        source = self.home.fresh("servo")
        self.add(Part(source, kind, (node.width,), ((kind[1], value),), varies=True))
        self.bond(End((Step(source),)), node.end)

    # --- elements -----------------------------------------------------------------------

    def element(self, kind: str, node: Node) -> None:
        before = len(self.statements)
        super().element(kind, node)
        letter = {"I": "p", "C": "q"}.get(kind)
        if letter is not None:
            part = next(
                s
                for s in self.statements[before:]
                if isinstance(s, Part) and s.type == kind and s.index is None
            )
            self.stores.append((part.name, letter, node))

    def _linear(self, to: Quantity, of: Quantity, width: int, *, symmetric: bool) -> Expr:
        """Mostly a full matrix, the diagonal of which outweighs each row."""
        rng = self.rng
        size, kind = to.size / of.size, to.unit / of.unit
        if width == 1 or rng.random() < 0.15:
            return self.coefficient(size, kind)
        table: list[list[Expr]] = [[ZERO] * width for _ in range(width)]
        for i in range(width):
            table[i][i] = Num(nice(rng, size, 1.5, 3.0), kind)
            for j in range(i):
                value = nice(rng, size / (width - 1), 0.3, 1.2) * rng.choice([-1, 1])
                table[i][j] = Num(value, kind)
                table[j][i] = Num(value if symmetric else -value, kind)
        return matrix(table)

    def _storage(self, part: Part, domain: Domain, width: int) -> Part:
        """A wide body mostly has a matrix."""
        if width == 1 or self.rng.random() < 0.4:
            return super()._storage(part, domain, width)
        state, answer = ("q", "e") if part.type == "C" else ("p", "f")
        of, to = variable(domain, state), variable(domain, answer)
        argument = "compliance" if part.type == "C" else "inertia"
        value = self._linear(of, to, width, symmetric=True)
        part = replace(part, arguments=((argument, value),))
        return self._with_initial(part, of, to, state, answer)

    def _with_initial(
        self, part: Part, of: Quantity, to: Quantity, state: str, answer: str
    ) -> Part:
        """An initial value on every second element, of its state or of what answers it."""
        rng = self.rng
        if not self.home.wishes.initials or rng.random() < 0.5:
            return part
        which = rng.choice([state, answer])
        quantity = of if which == state else to
        numbers = [
            Num(nice(rng, quantity.size) * rng.choice([-1, 1]), quantity.unit)
            for _ in range(part.width[0])
        ]
        value: Expr = numbers[0] if len(numbers) == 1 else vector(*numbers)
        return replace(part, arguments=(*part.arguments, (f"{which}0", value)))
