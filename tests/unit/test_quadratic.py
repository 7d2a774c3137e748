"""Quadratic forms with definitions, minimised in the DAG, against dense linear algebra."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.evaluate import Evaluator, evaluate_nodes
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.quadratic import (
    ConstrainedEnergy,
    Definition,
    Form,
    Minimum,
    Order,
    SingularFormError,
    inline,
    minimise,
    minimise_in_order,
)
from bgc.equations.storage.constrained_energy import is_minimum


class Problem:
    """A form over numbered variables whose entries are symbols of the state."""

    def __init__(self, seed: int = 0) -> None:
        self.dag = Dag()
        self.rng = random.Random(seed)
        self.values: dict[Symbol, float] = {}
        self.form = Form({}, {})
        self.definitions: list[Definition] = []
        self._indices = count()

    def entry(self, value: float | None = None) -> int:
        """A symbol with a random value."""
        symbol = Symbol(Kind.STATE, next(self._indices))
        self.values[symbol] = self.rng.uniform(0.5, 1.5) if value is None else value
        return self.dag.symbol(symbol.kind, symbol.index)

    def mass(self, i: int, j: int, node: int) -> None:
        """Set an entry and its mirror image."""
        self.form.matrix.setdefault(i, {})[j] = node
        self.form.matrix.setdefault(j, {})[i] = node

    def solve(self, minima: list[Minimum], known: dict[int, float]) -> dict[int, float]:
        """The values of all variables from the minima and the definitions, as they come."""
        found = dict(known)
        waiting: list[Minimum | Definition] = [*minima, *self.definitions]
        while waiting:
            late = []
            for item in waiting:
                if item.row.keys() <= found.keys():
                    total = sum(self.number(c) * found[k] for k, c in item.row.items())
                    if isinstance(item, Minimum):
                        total = (self.number(item.offset) - total) / self.number(item.pivot)
                    found[item.variable] = total
                else:
                    late.append(item)
            assert len(late) < len(waiting), "variables follow from each other in a circle"
            waiting = late
        return found

    def number(self, node: int) -> float:
        """The value of a node."""
        return evaluate_nodes(self.dag, [node], self.values)[0]


def random_problem(seed: int, free: int, defined: int, known: int) -> Problem:
    """Variables 0.. free, then known ones, then defined ones by any before them."""
    problem = Problem(seed)
    rng, first = problem.rng, free + known
    for number in range(first, first + defined):
        others = rng.sample(range(number), min(number, rng.randint(1, 3)))
        row = {k: problem.dag.one if rng.random() < 0.3 else problem.entry() for k in others}
        problem.definitions.insert(0, Definition(number, row))
    for number in range(first + defined):
        if number < free or (number >= first and rng.random() < 0.7):
            problem.mass(number, number, problem.entry(2.0))
            other = rng.randrange(first, first + defined) if defined else number
            if other > number and rng.random() < 0.5 and other in problem.form.matrix:
                problem.mass(number, other, problem.entry(0.3))
    problem.form.vector.update({k: problem.entry() for k in range(free)})
    return problem


def dense_minimum(problem: Problem, free: int, known: dict[int, float]) -> np.ndarray:
    """`u = (N' Q N)^-1 (b - N' Q N_s s)` by NumPy."""
    size = free + len(known) + len(problem.definitions)
    rows = np.eye(size)[:, : free + len(known)]
    for definition in reversed(problem.definitions):
        rows[definition.variable] = sum(
            problem.number(c) * rows[k] for k, c in definition.row.items()
        )
    matrix = np.zeros((size, size))
    for i, row in problem.form.matrix.items():
        for j, node in row.items():
            matrix[i, j] = problem.number(node)
    whole = rows.T @ matrix @ rows
    pull = np.array([problem.number(problem.form.vector[k]) for k in range(free)])
    driven = whole[:free, free:] @ np.array(list(known.values()))
    return np.linalg.solve(whole[:free, :free], pull - driven)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(0, 12), st.integers(0, 2))
def test_both_orders_give_the_minimum(seed: int, free: int, defined: int, known: int) -> None:
    problem = random_problem(seed, free, defined, known)
    given_values = {free + k: 0.7 - k for k in range(known)}
    expected = dense_minimum(problem, free, given_values)
    for order in Order:
        minima = minimise_in_order(
            problem.dag,
            Fingerprints(problem.dag),
            problem.form,
            problem.definitions,
            range(free),
            order,
        )
        found = problem.solve(minima, given_values)
        actual = np.array([found[k] for k in range(free)])
        np.testing.assert_allclose(actual, expected, rtol=1e-9, atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(0, 12), st.integers(0, 2))
def test_the_check_in_numbers_finds_each_wrong_part(
    seed: int, free: int, defined: int, known: int
) -> None:
    problem = random_problem(seed, free, defined, known)
    dag, rng = problem.dag, random.Random(seed)
    energy = ConstrainedEnergy(problem.form, problem.definitions, range(free))
    minima = minimise(dag, Fingerprints(dag), energy.form, energy.definitions, energy.free)
    numbers = Evaluator(dag, problem.values.__getitem__)
    assert is_minimum(numbers, energy, minima)
    place = rng.randrange(free)
    right = minima[place]
    wrong = [
        replace(right, offset=dag.neg(right.offset)),
        replace(right, pivot=dag.neg(right.pivot)),
    ]
    if right.row:
        k = rng.choice(list(right.row))
        wrong.append(replace(right, row={**right.row, k: dag.neg(right.row[k])}))
    for one in wrong:
        changed = [*minima[:place], one, *minima[place + 1 :]]
        different = numbers.value(right.offset) or len(right.row) > 0
        assert not different or not is_minimum(numbers, energy, changed)


def test_the_check_is_relative_to_the_terms_of_each_sum() -> None:
    problem = Problem()
    problem.mass(0, 0, problem.entry(1e-14))
    problem.mass(2, 2, problem.entry(1e-14))
    problem.definitions.append(Definition(2, {0: problem.entry(3.0), 1: problem.entry(2.0)}))
    problem.form.vector[0] = problem.entry(1e-14)
    energy = ConstrainedEnergy(problem.form, problem.definitions, [0])
    numbers = Evaluator(problem.dag, problem.values.__getitem__)
    fingerprints = Fingerprints(problem.dag)
    (right,) = minimise(problem.dag, fingerprints, problem.form, energy.definitions, [0])
    assert is_minimum(numbers, energy, [right])
    assert not is_minimum(numbers, energy, [replace(right, offset=problem.dag.zero)])


def chain(length: int) -> tuple[Problem, list[int]]:
    """Planar links: three flows each, that follow from those of the link before and its own."""
    problem = Problem()
    before: list[int] = []
    free = []
    for link in range(length):
        own, *flows = range(4 * link, 4 * link + 4)
        free.append(own)
        for flow in flows:
            row = {k: problem.entry() for k in (*before, own)}
            problem.definitions.insert(0, Definition(flow, row))
            problem.mass(flow, flow, problem.entry(2.0))
        problem.form.vector[own] = problem.entry()
        before = flows
    return problem, free


def bars(length: int) -> tuple[Problem, list[int]]:
    """Links of two rotations and two translations; those of all translations are defined first."""
    problem, free = Problem(), []
    rotating, moving = [], []
    for link in range(length):
        own, a, b, x, y = range(5 * link, 5 * link + 5)
        free.append(own)
        turns, base = (a - 5, b - 5) if link else (), (x - 5, y - 5) if link else ()
        for flow in (a, b):
            rotating.append(Definition(flow, {k: problem.entry() for k in (*turns, own)}))
        for flow in (x, y):
            moving.append(Definition(flow, {k: problem.entry() for k in (*base, *turns)}))
        for flow in (a, b, x, y):
            problem.mass(flow, flow, problem.entry(2.0))
        problem.form.vector[own] = problem.entry()
    problem.definitions = [*reversed(moving), *reversed(rotating)]
    return problem, free


def operations(
    length: int, order: Order | None, made: Callable[[int], tuple[Problem, list[int]]] = chain
) -> int:
    problem, free = made(length)
    arguments = (problem.dag, Fingerprints(problem.dag), problem.form, problem.definitions, free)
    minima = minimise(*arguments) if order is None else minimise_in_order(*arguments, order)
    nodes = [n for m in minima for n in (m.pivot, m.offset, *m.row.values())]
    return sum(problem.dag.op[n] > Op.SYMBOL for n in problem.dag.reachable(nodes))


def test_operations_grow_in_proportion_to_a_chain() -> None:
    assert operations(40, None) / operations(20, None) < 2.1
    assert operations(40, Order.SUBSTITUTIONS_FIRST) / operations(20, Order.SUBSTITUTIONS_FIRST) > 3


def test_operations_grow_in_proportion_however_the_definitions_are_ordered() -> None:
    counts = [operations(length, None, bars) for length in (10, 20, 30)]
    assert counts[2] - counts[1] < 1.05 * (counts[1] - counts[0])


def test_the_cheaper_order_is_taken() -> None:
    for length in (1, 2, 3, 20):
        orders = [operations(length, order) for order in Order]
        assert operations(length, None) == min(orders)


def test_a_form_that_does_not_rise_is_singular() -> None:
    """Two variables that only their sum has inertia."""
    problem = Problem()
    one = problem.dag.one
    problem.definitions = [Definition(2, {0: one, 1: problem.entry()})]
    problem.mass(2, 2, problem.entry())
    with pytest.raises(SingularFormError):
        minimise(problem.dag, Fingerprints(problem.dag), problem.form, problem.definitions, [0, 1])


def test_definitions_that_only_rename_are_seen_through() -> None:
    dag = Dag()
    minus, modulus = dag.const(-1), dag.symbol(Kind.STATE, 0)
    definitions = [
        Definition(4, {3: dag.one, 2: dag.one}),
        Definition(3, {1: modulus}),
        Definition(2, {0: minus, 9: modulus}),
        Definition(9, {}),
    ]
    inlined = {d.variable: d.row for d in inline(dag, definitions)}
    assert inlined[4] == {3: dag.one, 0: minus}
