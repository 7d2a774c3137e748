"""Closed forms: laws turned round, and powers integrated."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.inversion import solve_for
from bgc.algebra.polynomials import antiderivative
from bgc.ir.graph import Node

Law = Callable[[Dag, Node], Node]
X = Symbol(Kind.STATE, 0)


def affine(dag: Dag, x: Node) -> Node:
    return dag.sub(dag.const(3), dag.div(dag.mul(dag.const(2), x), dag.const(5)))


def orifice(dag: Dag, x: Node) -> Node:
    return dag.add(dag.mul(dag.mul(dag.const(2), dag.call(Op.ABS, x)), x), dag.one)


def hardening(dag: Dag, x: Node) -> Node:
    return dag.mul(dag.const(-4), dag.mul(x, dag.mul(x, x)))


def diode(dag: Dag, x: Node) -> Node:
    return dag.sub(dag.call(Op.EXP, dag.div(x, dag.const(0.5))), dag.const(-1))


def saturation(dag: Dag, x: Node) -> Node:
    return dag.neg(dag.call(Op.TANH, dag.mul(dag.const(3), x)))


def valve(dag: Dag, x: Node) -> Node:
    root = dag.call(Op.SQRT, dag.call(Op.ABS, x))
    return dag.mul(dag.mul(dag.const(3), dag.call(Op.SIGN, x)), root)


def broken_power(dag: Dag, x: Node) -> Node:
    moved = dag.add(x, dag.one)
    size = dag.pow(dag.call(Op.ABS, moved), dag.const(0.75))
    return dag.div(dag.mul(moved, size), dag.const(-2))


def laminar_and_turbulent(dag: Dag, x: Node) -> Node:
    turbulent = dag.mul(dag.const(3), dag.mul(x, dag.call(Op.ABS, x)))
    return dag.neg(dag.add(dag.mul(dag.const(2), x), turbulent))


def two_powers(dag: Dag, x: Node) -> Node:
    return dag.add(x, dag.mul(x, dag.mul(x, x)))


def arc(dag: Dag, x: Node) -> Node:
    return dag.mul(dag.const(2), dag.call(Op.ATAN, dag.mul(dag.const(5), x)))


@pytest.mark.parametrize(
    "law",
    [
        affine,
        orifice,
        hardening,
        diode,
        saturation,
        valve,
        broken_power,
        laminar_and_turbulent,
        two_powers,
        arc,
    ],
)
@pytest.mark.parametrize("value", [-0.7, 0.3])
def test_laws_are_turned_round(law: Law, value: float) -> None:
    dag = Dag()
    x = dag.symbol(Kind.STATE, 0)
    node = law(dag, x)
    (target,) = evaluate_nodes(dag, [node], {X: value})
    solved = solve_for(dag, node, dag.const(target), x)
    assert solved is not None
    assert evaluate_nodes(dag, [solved], {}) == [pytest.approx(value)]


def square(dag: Dag, x: Node) -> Node:
    return dag.mul(x, x)


def falling_and_rising(dag: Dag, x: Node) -> Node:
    return dag.sub(dag.mul(x, dag.call(Op.ABS, x)), x)


def sine(dag: Dag, x: Node) -> Node:
    return dag.call(Op.SIN, x)


def by_a_state(dag: Dag, x: Node) -> Node:
    return dag.mul(dag.symbol(Kind.STATE, 1), x)


@pytest.mark.parametrize("law", [square, falling_and_rising, sine, by_a_state])
def test_what_is_not_one_to_one_is_left(law: Law) -> None:
    dag = Dag()
    x = dag.symbol(Kind.STATE, 0)
    assert solve_for(dag, law(dag, x), dag.one, x) is None


@pytest.mark.parametrize("law", [affine, orifice, hardening, square, two_powers])
@pytest.mark.parametrize("value", [-0.7, 0.3])
def test_sums_of_powers_are_integrated(law: Law, value: float) -> None:
    dag = Dag()
    x = dag.symbol(Kind.STATE, 0)
    node = law(dag, x)
    energy = antiderivative(dag, node, x)
    assert energy is not None
    step = 1e-6
    high, low = (evaluate_nodes(dag, [energy], {X: value + h})[0] for h in (step, -step))
    (slope,) = evaluate_nodes(dag, [node], {X: value})
    assert (high - low) / (2 * step) == pytest.approx(slope)
    assert evaluate_nodes(dag, [energy], {X: 0.0}) == [0]


@pytest.mark.parametrize(
    ("law", "target"),
    [(lambda dag, x: dag.call(Op.ATAN, x), 1.6), (lambda dag, x: dag.call(Op.SQRT, x), -0.1)],
)
def test_what_a_law_never_gives_is_answered_by_no_number(law: Law, target: float) -> None:
    dag = Dag()
    x = dag.symbol(Kind.STATE, 0)
    solved = solve_for(dag, law(dag, x), dag.const(target), x)
    assert solved is not None
    assert math.isnan(evaluate_nodes(dag, [solved], {})[0])


def test_parameters_whose_signs_decide_are_told() -> None:
    dag = Dag()
    x, k = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.PARAM, 0)
    law = dag.add(dag.mul(k, x), dag.mul(dag.const(3), dag.mul(x, dag.call(Op.ABS, x))))
    told: list[Node] = []
    assert solve_for(dag, law, dag.one, x) is None
    assert solve_for(dag, law, dag.one, x, lambda node: (0.0, 3.0)) is None
    assert solve_for(dag, law, dag.one, x, lambda node: (2.0, 3.0), told.append) is not None
    assert told == [k]


def test_other_laws_have_no_closed_energy() -> None:
    dag = Dag()
    assert (
        antiderivative(dag, sine(dag, dag.symbol(Kind.STATE, 0)), dag.symbol(Kind.STATE, 0)) is None
    )
