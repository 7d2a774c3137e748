"""An independent check of derived equations: all element and junction equations, in numbers.

`Check` evaluates every bond variable of a program at a random state and puts the values into
the raw equations of the flat graph. It shares nothing with the derivation but the data.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from fractions import Fraction
from typing import assert_never

import numpy as np
from graphs import GraphBuilder

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.ir.defaults import default_values
from bgc.ir.graph import (
    EnergyLaw,
    ExplicitLaw,
    FlatGraph,
    Form,
    Gyrator,
    Gyristor,
    Junction,
    LinearLaw,
    Resistor,
    Source,
    Storage,
    Transformer,
    ports_of,
)
from bgc.ir.program import Program


def observe_everything(g: GraphBuilder) -> None:
    """Observe every effort, flow, charge and momentum, named by its symbol."""
    for bond in range(len(g.bonds)):
        g.observe(f"e{bond}", g.effort(bond))
        g.observe(f"f{bond}", g.flow(bond))
    for state in g.states:
        g.observe(f"x{state.index}", g.dag.symbol(Kind.STATE, state.index))
    graph = g.build()
    for element in graph.elements:
        if isinstance(element, Storage):
            momenta = _with_momentum(g.dag, element)
            for k in range(len(element.ports)):
                index = element.first_state + k
                if element.kind in ("C", "IC"):
                    g.observe(f"q{index}", g.dag.symbol(Kind.DISPLACEMENT, index))
                if k in momenta:
                    g.observe(f"p{index}", g.dag.symbol(Kind.MOMENTUM, index))


@dataclass
class Point:
    """Values of all observations at a state, and their rates along the equations."""

    values: dict[str, float]
    rates: dict[str, float]


def evaluate_at_random(program: Program, seed: int = 1) -> Point:
    """Observations and their rates, the rates by central differences along the flow.

    Algebraic states are solved for, with Newton's method.
    """
    dag = program.dag
    rng = random.Random(seed)
    leaves: dict[Symbol, float] = dict(default_values(dag, program.parameters))
    leaves[Symbol(Kind.TIME, 0)] = 0.3
    for k in range(program.inputs):
        leaves[Symbol(Kind.INPUT, k)] = rng.uniform(-1, 1)
    size = len(program.states)
    start = np.array([rng.uniform(-1, 1) for _ in range(size)])
    entries = [] if program.mass is None else program.mass
    explicit = program.mass is None
    differential = [k for k in range(size) if explicit or any(m.row == k for m in entries)]
    assert all(m.row == m.column for m in entries), "rates are not explicit"
    algebraic = [k for k in range(size) if k not in differential]
    derivatives = [s.derivative for s in program.states]
    nodes = [o.node for o in program.observations]

    def rates_at(state: np.ndarray, now: dict[Symbol, float]) -> np.ndarray:
        return np.array(evaluate_nodes(dag, derivatives, now | _states(list(state))))

    def consistent(state: np.ndarray, now: dict[Symbol, float]) -> np.ndarray:
        state = state.copy()
        for _ in range(50 if algebraic else 0):
            residual = rates_at(state, now)[algebraic]
            if not np.isfinite(residual).all() or np.abs(residual).max() < 1e-13:
                break
            jacobian = np.empty((len(algebraic), len(algebraic)))
            for column, k in enumerate(algebraic):
                there, back = state.copy(), state.copy()
                there[k] += 1e-6
                back[k] -= 1e-6
                change = rates_at(there, now)[algebraic] - rates_at(back, now)[algebraic]
                jacobian[:, column] = change / 2e-6
            state[algebraic] -= np.linalg.solve(jacobian, residual)
        return state

    state = consistent(start, leaves)
    slopes = rates_at(state, leaves)
    values = evaluate_nodes(dag, nodes, leaves | _states(list(state)))
    step = 1e-5

    def moved(h: float) -> list[float]:
        now = leaves | {Symbol(Kind.TIME, 0): 0.3 + h}
        at = state.copy()
        at[differential] += h * slopes[differential]
        return evaluate_nodes(dag, nodes, now | _states(list(consistent(at, now))))

    rates = [(a - b) / (2 * step) for a, b in zip(moved(step), moved(-step), strict=True)]
    names = [o.name for o in program.observations]
    return Point(dict(zip(names, values, strict=True)), dict(zip(names, rates, strict=True)))


def _states(state: list[float]) -> dict[Symbol, float]:
    return {Symbol(Kind.STATE, k): x for k, x in enumerate(state)}


def largest_misfit(graph: FlatGraph, point: Point) -> float:
    """The largest residual of all raw equations, relative to the values in them."""
    dag, value, rate = graph.dag, point.values, point.rates
    leaves: dict[Symbol, float] = dict(default_values(dag, graph.parameters))
    leaves[Symbol(Kind.TIME, 0)] = 0.3
    kinds = {
        "e": Kind.EFFORT,
        "f": Kind.FLOW,
        "q": Kind.DISPLACEMENT,
        "p": Kind.MOMENTUM,
        "x": Kind.STATE,
    }
    for name, x in value.items():
        if name[0] in kinds and name[1:].isdigit():
            leaves[Symbol(kinds[name[0]], int(name[1:]))] = x
    worst = 0.0

    def number(node: int) -> float:
        return evaluate_nodes(dag, [node], leaves)[0]

    def zero(*terms: float, loose: float = 1.0) -> None:
        nonlocal worst
        worst = max(worst, abs(sum(terms)) / (1 + max(map(abs, terms), default=0)) / loose)

    for element in graph.elements:
        match element:
            case Junction():
                e = [value[f"e{p.bond}"] for p in element.ports]
                f = [value[f"f{p.bond}"] for p in element.ports]
                same, summed = (e, f) if element.kind == "J0" else (f, e)
                for x in same[1:]:
                    zero(x, -same[0])
                zero(*(p.sign * x for p, x in zip(element.ports, summed, strict=True)))
            case Source():
                letter = "e" if element.kind == "Se" else "f"
                zero(value[f"{letter}{element.port.bond}"], -number(element.value))
            case Storage():
                momenta = _with_momentum(dag, element)
                for k, port in enumerate(element.ports):
                    index = element.first_state + k
                    e, f = value[f"e{port.bond}"], port.sign * value[f"f{port.bond}"]
                    if element.kind in ("C", "IC"):
                        zero(rate[f"q{index}"], -f, loose=1e4)
                    if element.kind == "I":
                        zero(rate[f"p{index}"], -e, loose=1e4)
                    match element.law:
                        case LinearLaw(form=form, matrix=matrix):
                            letter = "q" if element.kind == "C" else "p"
                            own = "e" if element.kind == "C" else "f"
                            states = [
                                value[f"{letter}{element.first_state + j}"]
                                for j in range(len(element.ports))
                            ]
                            answers = [
                                value[f"{own}{p.bond}"] * (p.sign if own == "f" else 1)
                                for p in element.ports
                            ]
                            inverse = form in (Form.DISPLACEMENT, Form.MOMENTUM)
                            left, right = (states, answers) if inverse else (answers, states)
                            row = [number(n) * x for n, x in zip(matrix[k], right, strict=True)]
                            zero(-left[k], *row)
                        case ExplicitLaw(nodes=nodes):
                            zero(number(nodes[k]), -(e if element.kind == "C" else f))
                        case EnergyLaw(energy=energy):
                            own = (
                                Symbol(Kind.DISPLACEMENT, index),
                                Symbol(Kind.MOMENTUM, index),
                            )
                            by_charge, by_momentum = (
                                _slope(dag, energy, leaves, symbol) for symbol in own
                            )
                            if element.kind == "IC" and k in momenta:
                                zero(rate[f"p{index}"], by_charge, -e, loose=1e4)
                            elif element.kind != "I":
                                zero(by_charge, -e)
                            if k in momenta:
                                zero(by_momentum, -f)
            case Resistor():
                e_own = [value[f"e{p.bond}"] for p in element.ports]
                f_own = [p.sign * value[f"f{p.bond}"] for p in element.ports]
                resists = element.law.form is Form.EFFORT
                left, right = (e_own, f_own) if resists else (f_own, e_own)
                for k in range(len(element.ports)):
                    match element.law:
                        case LinearLaw(matrix=matrix):
                            row = [number(n) * x for n, x in zip(matrix[k], right, strict=True)]
                            zero(-left[k], *row)
                        case ExplicitLaw(nodes=nodes):
                            own_flows = {
                                Symbol(Kind.FLOW, p.bond): x
                                for p, x in zip(element.ports, f_own, strict=True)
                            }
                            (law,) = evaluate_nodes(dag, [nodes[k]], leaves | own_flows)
                            zero(law, -left[k])
            case Transformer() | Gyrator():
                one, two = element.ports1, element.ports2
                turned = isinstance(element, Transformer) and element.given in ("f1", "e2")
                if turned:
                    one, two = two, one
                m = [[number(n) for n in row] for row in element.matrix]
                e1, f1 = [value[f"e{p.bond}"] for p in one], [value[f"f{p.bond}"] for p in one]
                e2, f2 = [value[f"e{p.bond}"] for p in two], [value[f"f{p.bond}"] for p in two]
                if isinstance(element, Gyrator):
                    f2, e2 = e2, f2
                for i in range(len(two)):
                    zero(-f2[i], *(m[i][j] * f1[j] for j in range(len(one))))
                for j in range(len(one)):
                    zero(-e1[j], *(m[i][j] * e2[i] for i in range(len(two))))
            case Gyristor():
                f_own = [p.sign * value[f"f{p.bond}"] for p in element.ports]
                for k, port in enumerate(element.ports):
                    row = [number(n) * x for n, x in zip(element.matrix[k], f_own, strict=True)]
                    zero(-value[f"e{port.bond}"], *row)
            case _:
                assert_never(element)
    return worst


def power_imbalance(graph: FlatGraph, point: Point) -> float:
    """The sum of the powers into all elements but junctions, relative to their sizes and 1."""
    powers = [
        port.sign * point.values[f"e{port.bond}"] * point.values[f"f{port.bond}"]
        for element in graph.elements
        if not isinstance(element, Junction)
        for port in ports_of(element)
    ]
    return abs(sum(powers)) / (1 + sum(map(abs, powers)))


def _with_momentum(dag: Dag, storage: Storage) -> set[int]:
    """The ports of a storage element whose momentum its energy holds."""
    if not isinstance(storage.law, EnergyLaw):
        return set() if storage.kind == "C" else set(range(len(storage.ports)))
    held = {dag.symbol_of(node) for node in dag.reachable([storage.law.energy])}
    first = storage.first_state
    return {k for k in range(len(storage.ports)) if Symbol(Kind.MOMENTUM, first + k) in held}


def _slope(dag: Dag, node: int, at: dict[Symbol, float], symbol: Symbol) -> float:
    """A partial derivative of a quadratic node, by central differences (exact but for rounding)."""
    there = [
        evaluate_nodes(dag, [node], at | {symbol: at.get(symbol, 0.0) + h})[0] for h in (-1, 1)
    ]
    return (there[1] - there[0]) / 2


_PRIME = 2**31 - 1  # products of residues fit into 64 bits


def pencil_degree(graph: FlatGraph) -> int | None:
    """The number of states that a linear graph has: the degree of det(s E - A), modulo a prime.

    None of a singular pencil, whose graph has no or no single solution.
    """
    rows = _pencil_rows(graph)
    size = len(rows)
    columns = {c for a, b in rows for c in (*a, *b)}
    columns |= {(letter, bond) for letter in "ef" for bond in range(len(graph.bonds))}
    assert len(columns) == size, (size, len(columns))
    order = {column: k for k, column in enumerate(sorted(columns))}
    moving = [i for i, (_, b) in enumerate(rows) if b]
    whole = np.zeros((size, size + len(moving)), dtype=np.int64)
    rate = np.zeros((len(moving), size), dtype=np.int64)
    for i, (a, b) in enumerate(rows):
        for column, x in a.items():
            whole[i, order[column]] -= x
        for column, x in b.items():
            whole[i, order[column]] += 7919 * x
    for n, i in enumerate(moving):
        whole[i, size + n] = 1
        for column, x in rows[i][1].items():
            rate[n, order[column]] = x % _PRIME
    if _reduce(whole, size) < size:
        return None
    # Finite eigenvalues of the pencil are nonzero ones of (s E - A)^-1 E; infinite ones vanish
    # in its powers.
    power = _times(rate, whole[:, size:])
    rank = _reduce(power.copy(), len(moving))
    while True:
        power = _times(power, power)
        lower = _reduce(power.copy(), len(moving))
        if lower == rank:
            return rank
        rank = lower


def _times(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    total = np.zeros((left.shape[0], right.shape[1]), dtype=np.int64)
    for k in range(left.shape[1]):
        total = (total + left[:, k : k + 1] * right[k : k + 1, :]) % _PRIME
    return total


def _reduce(table: np.ndarray, width: int) -> int:
    """Gauss and Jordan's elimination in place, modulo the prime; the rank of the first columns."""
    table %= _PRIME
    rank = 0
    for column in range(width):
        found = np.flatnonzero(table[rank:, column])
        if not len(found):
            continue
        table[[rank, rank + found[0]]] = table[[rank + found[0], rank]]
        table[rank] = table[rank] * pow(int(table[rank, column]), -1, _PRIME) % _PRIME
        others = np.flatnonzero(table[:, column])
        others = others[others != rank]
        factors = table[others, column : column + 1]
        table[others] = (table[others] - factors * table[rank]) % _PRIME
        rank += 1
    return rank


_Column = tuple[str, int]  # the effort or flow of a bond, the charge or momentum of a port
_PencilRow = tuple[dict[_Column, int], dict[_Column, int]]  # A and E of an equation


def _pencil_rows(graph: FlatGraph) -> list[_PencilRow]:
    """All equations of elements and junctions; of sources only that their value is given."""
    dag = graph.dag
    defaults = default_values(dag, graph.parameters)

    def number(node: int) -> int:
        exact = Fraction(evaluate_nodes(dag, [node], defaults)[0]).limit_denominator(10**6)
        return exact.numerator * pow(exact.denominator, -1, _PRIME) % _PRIME

    rows: list[_PencilRow] = []

    def e(bond: int) -> _Column:
        return ("e", bond)

    def f(bond: int) -> _Column:
        return ("f", bond)

    for element in graph.elements:
        match element:
            case Junction():
                same, summed = (e, f) if element.kind == "J0" else (f, e)
                first = element.ports[0].bond
                rows.extend(({same(p.bond): 1, same(first): -1}, {}) for p in element.ports[1:])
                rows.append(({summed(p.bond): p.sign for p in element.ports}, {}))
            case Source():
                rows.append(({(e if element.kind == "Se" else f)(element.port.bond): 1}, {}))
            case Storage(law=EnergyLaw()):
                rows.extend(_rows_of_energy(dag, element))
            case Storage(law=LinearLaw(matrix=matrix, form=form)):
                inverse = form in (Form.DISPLACEMENT, Form.MOMENTUM)
                plain = element.kind == "C"
                for k, port in enumerate(element.ports):
                    answer, rate = (e, f) if plain else (f, e)
                    s = [p.sign if plain else 1 for p in element.ports]  # of the rate
                    t = [1 if plain else p.sign for p in element.ports]  # of the answer
                    # rate = s * capacity * answer, or s * answer = response * rate
                    if inverse:
                        a = {rate(port.bond): s[k]}
                        b = {
                            answer(p.bond): t[j] * number(matrix[k][j])
                            for j, p in enumerate(element.ports)
                        }
                    else:
                        b = {answer(port.bond): t[k]}
                        a = {
                            rate(p.bond): s[j] * number(matrix[k][j])
                            for j, p in enumerate(element.ports)
                        }
                    rows.append((a, b))
            case Resistor(law=LinearLaw(matrix=matrix, form=form)):
                left, right = (e, f) if form is Form.EFFORT else (f, e)
                for k, port in enumerate(element.ports):
                    own = [p.sign if left is e else 1 for p in element.ports]
                    a = {
                        right(p.bond): own[j] * number(matrix[k][j])
                        for j, p in enumerate(element.ports)
                    }
                    a[left(port.bond)] = -1 if left is e else -port.sign
                    rows.append((a, {}))
            case Transformer() | Gyrator():
                one, two = element.ports1, element.ports2
                if isinstance(element, Transformer) and element.given in ("f1", "e2"):
                    one, two = two, one
                f2, e2 = (e, f) if isinstance(element, Gyrator) else (f, e)
                m = [[number(n) for n in row] for row in element.matrix]
                for i, p in enumerate(two):
                    a = {f(q.bond): m[i][j] for j, q in enumerate(one)}
                    a[f2(p.bond)] = -1
                    rows.append((a, {}))
                for j, p in enumerate(one):
                    a = {e2(q.bond): m[i][j] for i, q in enumerate(two)}
                    a[e(p.bond)] = -1
                    rows.append((a, {}))
            case Gyristor(matrix=matrix):
                for k, port in enumerate(element.ports):
                    a = {
                        f(p.bond): p.sign * number(x)
                        for p, x in zip(element.ports, matrix[k], strict=True)
                    }
                    rows.append(({**a, e(port.bond): -1}, {}))
            case _:
                raise AssertionError(f"the pencil has no rows for {element}")
    return rows


def _rows_of_energy(dag: Dag, element: Storage) -> list[_PencilRow]:
    """`q' = f`, `p' = e - dH/dq`, `f = dH/dp` of a quadratic energy, in its charges and momenta."""
    assert isinstance(element.law, EnergyLaw)
    energy, first, momenta = element.law.energy, element.first_state, _with_momentum(dag, element)
    places = range(first, first + len(element.ports))
    charges = [] if element.kind == "I" else [Symbol(Kind.DISPLACEMENT, k) for k in places]
    symbols = charges + [Symbol(Kind.MOMENTUM, first + k) for k in sorted(momenta)]
    names = {Kind.DISPLACEMENT: "q", Kind.MOMENTUM: "p"}

    def slope(symbol: Symbol) -> dict[_Column, int]:
        def at(*chosen: Symbol) -> float:
            values = {s: float(chosen.count(s)) for s in symbols}
            return evaluate_nodes(dag, [energy], values)[0]

        entries = {s: at(s, symbol) - at(s) - at(symbol) + at() for s in symbols}
        assert all(x == round(x) for x in entries.values()), "a random energy is not whole"
        return {(names[s.kind], s.index): round(x) for s, x in entries.items()}

    rows: list[_PencilRow] = []
    for k, port in enumerate(element.ports):
        q, p = ("q", first + k), ("p", first + k)
        effort, flow = ("e", port.bond), ("f", port.bond)
        by_charge = {} if element.kind == "I" else slope(Symbol(Kind.DISPLACEMENT, first + k))
        if element.kind != "I":
            rows.append(({flow: port.sign}, {q: 1}))
        if k in momenta:
            rows.append(({effort: 1} | {c: -x for c, x in by_charge.items()}, {p: 1}))
            rows.append((slope(Symbol(Kind.MOMENTUM, first + k)) | {flow: -port.sign}, {}))
        else:
            rows.append((by_charge | {effort: -1}, {}))
    return rows
