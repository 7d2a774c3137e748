"""Random linear bond graphs, well and ill posed, all arrows pointing at random."""

from __future__ import annotations

import random
from fractions import Fraction

from graphs import GraphBuilder

from bgc.algebra.dag import Kind, Op
from bgc.ir.graph import EnergyLaw, Form, Matrix, Node

_ELEMENTS = ["R", "R", "C", "I", "C", "I"]


def random_graph(
    seed: int,
    size: int = 6,
    *,
    gyrators: float = 0.25,
    sources: float = 0.25,
    fields: float = 0.25,
    turning: float = 0,
) -> GraphBuilder:
    """A graph of up to `size` junctions and twice as many elements.

    The shares are those of gyrators among the edges, of sources among the elements, and of
    fields for each junction: C, I and R with a matrix, C, I and IC with an energy, gyristors,
    transformers and gyrators with a matrix. `turning` is the share of moduli that follow an
    angle.
    """
    rng = random.Random(seed)
    g = GraphBuilder()
    count = rng.randint(1, size)
    for k in range(count):
        g.junction(rng.choice(["J0", "J1"]), f"j{k}")
    edges = [(rng.randrange(max(0, k - 6), k), k) for k in range(1, count)]
    for _ in range(rng.choice([0, 0, 0, 1, 2, count // 6]) if count > 2 else 0):
        a, b = rng.sample(range(count), 2)
        edges.append((a, b))
    for i, (a, b) in enumerate(edges):
        _join(g, rng, f"t{i}", a, b, (gyrators, turning))
    for i in range(rng.randint(1, 2 * size)):
        kind = rng.choice(["Se", "Sf"] if rng.random() < sources else _ELEMENTS)
        _element(g, rng, kind, f"{kind}{i}")
        _bond(g, rng, f"j{rng.randrange(count)}", f"{kind}{i}")
    for i in range(count):
        if rng.random() < fields:
            _field(g, rng, f"field{i}", count)
    g.drop_unbonded()
    return g


def _bond(g: GraphBuilder, rng: random.Random, a: str, b: str) -> None:
    """A bond whose arrow points either way."""
    g.bond(a, b) if rng.random() < 0.5 else g.bond(b, a)


def _join(
    g: GraphBuilder,
    rng: random.Random,
    name: str,
    a: int,
    b: int,
    shares: tuple[float, float],
) -> None:
    """Two junctions joined by a bond, a transformer or a gyrator."""
    gyrators, turning = shares
    choice = rng.random()
    value = Fraction(rng.choice([-3, -2, -1, 2, 3, 5]), rng.choice([1, 1, 2, 3]))
    modulus: Matrix = ((g.node(value),),)
    if rng.random() < turning:
        modulus = ((_turned(g, modulus[0][0]),),)
    if choice < gyrators:
        g.gyrator(name, modulus)
    elif choice < gyrators + 0.25:
        g.transformer(name, modulus, given=rng.choice(["f2", "f1"]))
    else:
        _bond(g, rng, f"j{a}", f"j{b}")
        return
    if rng.random() < 0.5:
        a, b = b, a
    g.bond(f"j{a}", name)
    g.bond(name, f"j{b}")


def _turned(g: GraphBuilder, node: Node) -> Node:
    """A modulus that follows an angle, which turns at a given rate; it vanishes now and then."""
    if not g.states:
        g.derivative(g.state("angle", 0.3), g.node(2))
    return g.dag.mul(node, g.dag.call(Op.COS, g.dag.symbol(Kind.STATE, 0)))


def _element(g: GraphBuilder, rng: random.Random, kind: str, name: str) -> None:
    value = Fraction(rng.randint(1, 9), rng.randint(1, 5))
    if kind == "R":
        g.resistor(name, value, rng.choice([Form.EFFORT, Form.FLOW]))
    elif kind in ("C", "I"):
        g.storage(kind, name, value, rng.choice(_forms(kind)))
    else:
        g.source(kind, name, g.node(value))


def _field(g: GraphBuilder, rng: random.Random, name: str, count: int) -> None:
    """A field on junctions at random."""
    kind = rng.choice(["C", "I", "R", "damper", "H", "H", "IC", "IC", "TF", "GY", "gyristor"])
    width = rng.choice([2, 2, 3])
    if kind in ("TF", "GY"):
        _matrix_two_port(g, rng, kind, name, count)
        return
    if kind in ("C", "I"):
        g.storage(kind, name, _definite(rng, width), rng.choice(_forms(kind)))
    elif kind == "R":
        a, b, c = rng.randint(2, 5), rng.randint(2, 5), rng.choice([-1, 1])
        width = 2
        g.resistor(name, [[a, c], [-c, b]], rng.choice([Form.EFFORT, Form.FLOW]))
    elif kind == "damper":  # between two flows or efforts: positive semidefinite only
        a, width = rng.randint(1, 5), 2
        g.resistor(name, [[a, -a], [-a, a]], rng.choice([Form.EFFORT, Form.FLOW]))
    elif kind == "gyristor":
        width = 3
        x, y, z = (rng.randint(-3, 3) for _ in range(3))
        g.gyristor(name, g.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]]))
    else:
        width = 2
        kind = rng.choice(["C", "I"]) if kind == "H" else kind
        g.storage(kind, name, EnergyLaw(_energy(g, rng, kind)), width=width)
    for _ in range(width):
        _bond(g, rng, f"j{rng.randrange(count)}", name)


def _matrix_two_port(g: GraphBuilder, rng: random.Random, kind: str, name: str, count: int) -> None:
    height = rng.choice([1, 2, 2])
    matrix: Matrix = tuple(
        tuple(g.node(rng.randint(-2, 3)) for _ in range(2)) for _ in range(height)
    )
    if kind == "GY":
        g.gyrator(name, matrix)
        given = "f2"
    else:
        given = rng.choice(["f2", "f1"])
        g.transformer(name, matrix, given=given)
    one, two = (2, height) if given == "f2" else (height, 2)
    for _ in range(one):
        g.bond(f"j{rng.randrange(count)}", name)
    for _ in range(two):
        g.bond(name, f"j{rng.randrange(count)}")


def _definite(rng: random.Random, width: int) -> list[list[int | float | Fraction | str]]:
    """A symmetric positive definite matrix: its diagonal outweighs the rest."""
    rows: list[list[int | float | Fraction | str]] = [[0] * width for _ in range(width)]
    for i in range(width):
        rows[i][i] = rng.randint(3, 6)
        for j in range(i):
            rows[i][j] = rows[j][i] = rng.choice([-1, 0, 1])
    return rows


def _energy(g: GraphBuilder, rng: random.Random, kind: str) -> Node:
    """A quadratic energy of two ports, positive definite; an IC's first port may lack momentum."""
    q = [g.next_state(Kind.DISPLACEMENT, k) for k in range(2)]
    p = [g.next_state(Kind.MOMENTUM, k) for k in range(2)]
    held = {"C": q, "I": p, "IC": rng.choice([[*q, *p], [*q, p[1]], [q[1], *p]])}[kind]
    dag, rows = g.dag, _definite(rng, len(held))
    terms = []
    for i, a in enumerate(held):
        terms.append(dag.mul(g.node(Fraction(rows[i][i]) / 2), dag.mul(a, a)))
        terms += [dag.mul(g.node(rows[i][j]), dag.mul(a, held[j])) for j in range(i)]
    return dag.sum(terms)


def _forms(kind: str) -> list[Form]:
    return [Form.EFFORT, Form.DISPLACEMENT] if kind == "C" else [Form.FLOW, Form.MOMENTUM]
