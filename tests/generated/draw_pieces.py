"""Larger pieces: chains in loops, fields, gyroscopic forces, equations, pendulums."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from draw_elements import Elements
from draw_values import Node, Reading
from program_laws import (
    Quantity,
    characteristic,
    energy,
    nice,
    variable,
)
from program_tree import (
    PLAIN,
    Assign,
    Bond,
    End,
    Equation,
    Expr,
    For,
    Law,
    Num,
    Own,
    Part,
    Statement,
    Step,
    Time,
    Value,
    call,
    matrix,
    read,
    unit,
)


class Pieces(Elements):
    """Draws larger pieces."""

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
