"""Junctions and what joins them: bonds, parts, transformers, gyrators, muxes."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from draw_pieces import Pieces
from draw_values import Node, Reading, Template
from program_laws import (
    DOMAINS,
    Domain,
    Quantity,
    nice,
    variable,
)
from program_tree import (
    Assign,
    End,
    Expr,
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
)


class ModelDraw(Pieces):
    """Draws the statements of one model."""

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
