"""Draw whole programs at random: models in models, loops, slots, fields, laws, scenes.

Every program is of a kind that an engineer could write: its units agree, its parts are passive,
its variables have the sizes of their domain. Whether it is well posed is not known beforehand;
the reference decides.
"""

from __future__ import annotations

import random
from fractions import Fraction

from draw_coupled import CoupledDraw
from draw_network import ModelDraw
from draw_values import Reading, Template, Wishes
from program_laws import (
    DOMAINS,
    nice,
    signal_of_time,
    variable,
)
from program_tree import (
    End,
    Expr,
    Interface,
    Model,
    Num,
    Observed,
    Part,
    Port,
    Program,
    Scene,
    Step,
    Time,
    Unit,
    Value,
)

COUPLED = 100_000  # the first of the seeds with wide bodies and moduli that read flows

TIMED = 200_000  # the first of those with tables and sampled parts too


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
        for _ in range(rng.choice([1, 2, 3, 4] if self.wishes.coupled else [0, 1, 1, 2])):
            self.two_ports.append(self._two_port_model())
        if rng.random() < 0.4:
            self._one_port_family()
        main = self._model(self.fresh("Main"), 0)
        least = [2, 3] if self.wishes.coupled else [1, 2]
        main.network(rng.choice([*least, 2, 3, 3, 4, self.wishes.size]))
        main.dress()
        template = main.finish()
        scene = self._scene(main, template)
        return Program(tuple(self.models), tuple(self.interfaces), scene, seed)

    def _model(self, name: str, depth: int) -> ModelDraw:
        draw = CoupledDraw if self.wishes.coupled else ModelDraw
        return draw(self, name, depth)

    def _two_port_model(self) -> Template:
        """A part between two nodes of one domain."""
        rng = self.rng
        if self.two_ports and self.wishes.coupled and rng.random() < 0.7:
            domain, width = self.two_ports[-1].domain, self.two_ports[-1].width
        else:
            domain, width = rng.choice(DOMAINS), rng.choice([1, 1, 1, 2, 3])
        draw = self._model(self.fresh(rng.choice(["Strut", "Line", "Shaft", "Link"])), 1)
        kind = rng.choice(["J0", "J1"])
        first = draw.node(kind, domain, width)
        base, tip = self.fresh("base"), self.fresh("tip")
        draw.add(Port(base, "in", width))
        draw.add(Port(tip, "out", width))
        draw.bond(End((Step(base),)), first.end)
        last = first
        if rng.random() < (0.7 if self.wishes.coupled else 0.4):
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
            draw = self._model(self.fresh(rng.choice(["Soft", "Hard", "Damped"])), 1)
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


def draw_program(seed: int, *, initials: bool = True) -> Program:
    """The program of a seed; `COUPLED` and `TIMED` are the first seeds with further features."""
    wishes = Wishes(initials, coupled=seed >= COUPLED, timed=seed >= TIMED)
    return Drawer(seed, wishes).program(seed)


__all__ = ["COUPLED", "TIMED", "draw_program"]
