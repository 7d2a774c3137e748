"""Random linear bond graphs, well and ill posed, all arrows pointing at random."""

from __future__ import annotations

import random
from fractions import Fraction

from graphs import GraphBuilder

from bgc.graph import Form


def random_graph(seed: int, size: int = 6, *, gyrators: bool = True) -> GraphBuilder:
    """A graph of up to `size` junctions and twice as many elements."""
    rng = random.Random(seed)
    g = GraphBuilder()
    count = rng.randint(1, size)

    def bond(a: str, b: str) -> None:
        g.bond(a, b) if rng.random() < 0.5 else g.bond(b, a)

    for k in range(count):
        g.junction(rng.choice(["J0", "J1"]), f"j{k}")
    edges = [(rng.randrange(k), k) for k in range(1, count)]
    for _ in range(rng.choice([0, 0, 0, 1, 2]) if count > 2 else 0):
        a, b = rng.sample(range(count), 2)
        edges.append((a, b))
    for i, (a, b) in enumerate(edges):
        choice = rng.random()
        if choice < 0.5:
            bond(f"j{a}", f"j{b}")
            continue
        modulus = Fraction(rng.choice([-3, -2, -1, 2, 3, 5]), rng.choice([1, 1, 2, 3]))
        if choice < 0.75 or not gyrators:
            g.transformer(f"t{i}", modulus, given=rng.choice(["f2", "f1"]))
        else:
            g.gyrator(f"t{i}", modulus)
        if rng.random() < 0.5:
            a, b = b, a
        g.bond(f"j{a}", f"t{i}")
        g.bond(f"t{i}", f"j{b}")
    for i in range(rng.randint(1, 2 * size)):
        kind = rng.choice(["R", "R", "C", "I", "C", "I", "Se", "Sf"])
        _element(g, rng, kind, f"{kind}{i}")
        bond(f"j{rng.randrange(count)}", f"{kind}{i}")
    if rng.random() < 0.3:
        _field(g, rng)
        for _ in range(2):
            bond(f"j{rng.randrange(count)}", "field")
    g.drop_unbonded()
    return g


def _element(g: GraphBuilder, rng: random.Random, kind: str, name: str) -> None:
    value = Fraction(rng.randint(1, 9), rng.randint(1, 5))
    if kind == "R":
        g.resistor(name, value, rng.choice([Form.EFFORT, Form.FLOW]))
    elif kind in ("C", "I"):
        g.storage(kind, name, value, rng.choice(_forms(kind)))
    else:
        g.source(kind, name, g.node(value))


def _field(g: GraphBuilder, rng: random.Random) -> None:
    a, b, c = rng.randint(2, 5), rng.randint(2, 5), rng.choice([-1, 1])
    kind = rng.choice("CIR")
    if kind == "R":
        g.resistor("field", [[a, c], [-c, b]], rng.choice([Form.EFFORT, Form.FLOW]))
    else:
        g.storage(kind, "field", [[a, c], [c, b]], rng.choice(_forms(kind)))


def _forms(kind: str) -> list[Form]:
    return [Form.EFFORT, Form.DISPLACEMENT] if kind == "C" else [Form.FLOW, Form.MOMENTUM]
