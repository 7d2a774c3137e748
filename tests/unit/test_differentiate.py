"""Derivatives against differences, for every operation and for both ways of differentiating."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from programs import at, make_program, random_program, states

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.emission.differentiate import differentiate, forward_rows, operation_count
from bgc.emission.vertices import eliminated_rows


def value(dag: Dag, node: int, x: list[float], **others: object) -> float:
    return evaluate_nodes(dag, [node], at(x, **others))[0]


def test_a_choice_has_the_derivative_of_what_it_chooses() -> None:
    dag = Dag()
    x, y = states(dag, 2)
    node = dag.select(dag.call(Op.LT, x, y), dag.mul(x, x), dag.mul(dag.const(3), y))
    by_x, by_y = gradient(dag, node, [x, y])
    assert [value(dag, d, [2.0, 5.0]) for d in (by_x, by_y)] == [4.0, 0.0]
    assert [value(dag, d, [5.0, 2.0]) for d in (by_x, by_y)] == [0.0, 3.0]


@pytest.mark.parametrize(
    ("make", "slope"),
    [
        (lambda dag, x: dag.mul(dag.call(Op.ABS, x), x), 0.0),
        (lambda dag, x: dag.call(Op.SQRT, dag.mul(x, x)), 0.0),
        (lambda dag, x: dag.call(Op.HYPOT, x, dag.zero), 0.0),
        (lambda dag, x: dag.mul(dag.call(Op.SIGN, x), dag.call(Op.SQRT, dag.call(Op.ABS, x))), 0.0),
        (lambda dag, x: dag.call(Op.CBRT, x), 0.0),
        (lambda dag, x: dag.pow(x, dag.const(10)), 0.0),
        (lambda dag, x: dag.pow(x, dag.const(1.5)), 0.0),
        (lambda dag, x: dag.pow(x, dag.const(2)), 0.0),
        (lambda dag, x: dag.pow(x, dag.symbol(Kind.PARAM, 0)), 0.0),
    ],
    ids=["abs(x)*x", "norm", "hypot", "orifice", "cbrt", "x^10", "x^1.5", "x^2", "x^p"],
)
def test_derivatives_at_zero_are_finite(make: Callable[[Dag, int], int], slope: float) -> None:
    dag = Dag()
    (x,) = states(dag, 1)
    node = make(dag, x)
    for derivative in (
        gradient(dag, node, [x])[0],
        directional_derivative(dag, node, {x: dag.one}),
    ):
        assert value(dag, derivative, [0.0], p=[3.0]) == slope


def test_both_ways_give_the_same_rows() -> None:
    program = random_program(seed=4, size=6, operations=80)
    outputs = [state.derivative for state in program.states]
    dag = program.dag
    other = eliminated_rows(dag, outputs, budget=10**6)
    assert other is not None
    values = at([0.1, 0.2, -0.3, 0.4, 0.5, -0.6], t=0.7, p=[1, 2, 3], u=[0.3])
    for forward_row, other_row in zip(forward_rows(dag, outputs), other, strict=True):
        for column in {*forward_row, *other_row}:
            nodes = [row.get(column, dag.zero) for row in (forward_row, other_row)]
            first, second = evaluate_nodes(dag, nodes, values)
            assert first == pytest.approx(second, rel=1e-10, abs=1e-13)


def test_elimination_gives_up_beyond_its_budget() -> None:
    program = random_program(seed=4, size=6, operations=80)
    outputs = [state.derivative for state in program.states]
    assert eliminated_rows(program.dag, outputs, budget=len(program.dag)) is None


def product_of_all(dag: Dag, count: int) -> int:
    node = dag.one
    for x in states(dag, count):
        node = dag.mul(node, dag.call(Op.SIN, x))
    return node


def test_the_cheaper_way_is_kept() -> None:
    """One output of many states is not for forward, in which the product is made again for each."""
    dag = Dag()
    count = 40
    wide = make_program(dag, [product_of_all(dag, count), *[dag.zero] * (count - 1)])
    program, jacobian = differentiate(wide)
    assert len(jacobian.entries) == count
    assert operation_count(program.dag, jacobian) < 6 * count


def test_the_program_given_is_left_alone() -> None:
    program = random_program(seed=4, size=6, operations=80)
    before = len(program.dag)
    differentiate(program)
    assert len(program.dag) == before


def test_inputs_are_constants_and_time_is_not() -> None:
    dag = Dag()
    t, u = dag.symbol(Kind.TIME), dag.symbol(Kind.INPUT, 0)
    program, jacobian = differentiate(make_program(dag, [dag.mul(u, dag.mul(t, t))], inputs=1))
    assert jacobian.entries == ()
    (by_time,) = jacobian.by_time
    assert evaluate_nodes(program.dag, [by_time], at([0.0], t=3.0, u=[5.0])) == [30.0]
