"""The rules of the graph: what becomes one node, and what is folded."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from programs import at, make_program, random_program, states

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.evaluate import evaluate_nodes
from bgc.emission.simplification import number_values, optimise


@pytest.fixture
def dag() -> Dag:
    return Dag()


def test_equal_nodes_are_one(dag: Dag) -> None:
    x, y = states(dag, 2)
    assert dag.add(x, y) == dag.add(y, x)
    assert dag.mul(x, y) == dag.mul(y, x)
    assert dag.const(0.5) == dag.const(Fraction(1, 2))


def test_signs_move_outwards(dag: Dag) -> None:
    x, y = states(dag, 2)
    difference = dag.sub(x, y)
    assert dag.sub(y, x) == dag.neg(difference)
    assert dag.add(x, dag.neg(y)) == difference
    assert dag.add(dag.neg(y), x) == difference
    assert dag.mul(dag.neg(x), dag.neg(y)) == dag.mul(x, y)
    assert dag.mul(dag.const(-2), x) == dag.neg(dag.mul(dag.const(2), x))
    assert dag.div(dag.neg(x), y) == dag.neg(dag.div(x, y))
    assert dag.sub(dag.neg(x), y) == dag.neg(dag.add(x, y))


def test_zeros_and_ones_vanish(dag: Dag) -> None:
    (x,) = states(dag, 1)
    zero, one = dag.zero, dag.one
    assert dag.add(x, zero) == dag.mul(x, one) == dag.div(x, one) == dag.sub(x, zero) == x
    assert dag.mul(x, zero) == dag.sub(x, x) == dag.div(zero, x) == zero
    assert dag.pow(x, zero) == one
    assert dag.select(one, x, zero) == x


def test_constants_fold_exactly(dag: Dag) -> None:
    third = dag.div(dag.one, dag.const(3))
    assert dag.add(third, dag.add(third, third)) == dag.one
    assert dag.call(Op.SQRT, dag.const(Fraction(9, 4))) == dag.const(1.5)
    assert dag.op[dag.call(Op.SQRT, dag.const(2))] == Op.SQRT


def test_long_constants_are_left_alone(dag: Dag) -> None:
    long = dag.const(Fraction(1, 3) ** 200)
    product = dag.mul(long, long)
    assert dag.value(product) is None
    assert evaluate_nodes(dag, [product], {}) == [pytest.approx(3.0**-400, rel=1e-12)]


def test_a_division_by_zero_is_kept(dag: Dag) -> None:
    (x,) = states(dag, 1)
    assert dag.op[dag.div(x, dag.zero)] == Op.DIV
    assert dag.op[dag.div(dag.zero, dag.zero)] == Op.DIV


def test_small_whole_powers_are_products(dag: Dag) -> None:
    (x,) = states(dag, 1)
    assert dag.pow(x, dag.const(3)) == dag.mul(dag.mul(x, x), x)
    assert dag.pow(x, dag.const(-1)) == dag.div(dag.one, x)
    assert dag.pow(x, dag.const(Fraction(1, 2))) == dag.call(Op.SQRT, x)


def test_levels_are_those_of_the_operands(dag: Dag) -> None:
    p, t = dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.TIME)
    assert dag.level[dag.call(Op.SIN, dag.const(0.5))] == Level.CONST
    assert dag.level[dag.mul(p, dag.const(2))] == Level.PARAM
    assert dag.level[dag.mul(p, t)] == Level.TIME
    assert dag.level[dag.mul(dag.mul(p, t), *states(dag, 1))] == Level.STATE


def test_a_copy_grows_on_its_own(dag: Dag) -> None:
    x, y = states(dag, 2)
    total = dag.add(x, y)
    other = dag.copy()
    assert other.add(x, y) == total
    size = len(dag)
    other.mul(x, y)
    assert len(dag) == size


def test_substitution_simplifies_again(dag: Dag) -> None:
    x, y = states(dag, 2)
    node = dag.add(dag.mul(x, y), dag.call(Op.SIN, x))
    assert dag.substitute([node, y], {x: dag.zero}) == [dag.zero, y]


@given(st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_optimisation_keeps_every_value(seed: int) -> None:
    program = random_program(seed=seed, size=4, operations=60)
    better = optimise(program)
    values = at([0.3, -0.2, 0.9, 0.5], t=0.4, p=[1.1, 0.6, 1.7], u=[0.2])
    for old, new in zip(program.states, better.states, strict=True):
        before = evaluate_nodes(program.dag, [old.derivative, old.initial], values)
        after = evaluate_nodes(better.dag, [new.derivative, new.initial], values)
        assert after == pytest.approx(before, rel=1e-9, abs=1e-12)
    assert len(better.dag) <= len(program.dag) + len(program.states)


def test_optimisation_finds_what_hashing_does_not(dag: Dag) -> None:
    x, y = states(dag, 2)
    square = dag.mul(dag.add(x, y), dag.add(x, y))
    expanded = dag.add(dag.add(dag.mul(x, x), dag.mul(y, y)), dag.mul(dag.const(2), dag.mul(x, y)))
    sine, cosine = dag.call(Op.SIN, x), dag.call(Op.COS, x)
    circle = dag.add(dag.mul(sine, sine), dag.mul(cosine, cosine))
    program = optimise(make_program(dag, [dag.sub(square, expanded), circle]))
    assert program.states[0].derivative == program.dag.zero
    assert program.states[1].derivative == program.dag.one


def test_optimisation_computes_functions_of_what_turns_out_a_number(dag: Dag) -> None:
    """`max(2, 1)` and `if 0 < 2` whose 2 only value numbering finds; and what is made of them."""
    x, y = states(dag, 2)
    rest = dag.sub(dag.mul(dag.add(x, y), dag.sub(x, y)), dag.mul(x, x))
    two = dag.add(dag.add(rest, dag.mul(y, y)), dag.const(2))
    assert dag.value(two) is None
    largest = dag.call(Op.MAX, two, dag.one)
    chosen = dag.select(dag.call(Op.LT, dag.zero, two), x, y)
    program = optimise(make_program(dag, [dag.mul(largest, y), chosen]))
    values = [s.derivative for s in program.states]
    assert evaluate_nodes(program.dag, values, at([3.0, 5.0])) == [10.0, 3.0]
    assert all(op not in {Op.MAX, Op.SELECT} for op in program.dag.op)


def test_optimisation_keeps_functions_that_are_more_accurate(dag: Dag) -> None:
    """`expm1(x)` equals `exp(x) - 1`, but near zero only the function keeps its digits."""
    (x,) = states(dag, 1)
    exponential, small = dag.call(Op.EXP, x), dag.call(Op.EXPM1, x)
    outputs = [dag.sub(exponential, dag.one), dag.sub(dag.one, exponential), small, dag.neg(small)]
    program = optimise(make_program(dag, [dag.zero], outputs=outputs))
    found = evaluate_nodes(program.dag, [o.node for o in program.observations], at([1e-12]))
    assert found[2:] == [math.expm1(1e-12), -math.expm1(1e-12)]


def test_optimisation_keeps_the_symbols_of_each_function_apart(dag: Dag) -> None:
    """A state that cancels from a node is not read by an equal one of the start."""
    (x,) = states(dag, 1)
    s = dag.symbol(Kind.START, 0)
    more = dag.add(s, dag.one)
    cancelled = dag.sub(dag.mul(dag.add(s, x), more), dag.mul(x, more))
    alone = dag.mul(s, more)
    for roots in ([cancelled, alone], [alone, cancelled]):
        simple, new = number_values(dag, roots)
        assert not simple.symbols_in([new[alone]], Kind.STATE)


def test_optimisation_shares_reciprocals(dag: Dag) -> None:
    x, y, z = states(dag, 3)
    program = optimise(make_program(dag, [dag.div(x, z), dag.div(y, z), dag.zero]))
    assert sum(op == Op.DIV for op in program.dag.op) == 1
    values = evaluate_nodes(
        program.dag, [s.derivative for s in program.states], at([3.0, 5.0, 4.0])
    )
    assert values == [0.75, 1.25, 0.0]


def test_nothing_raises_on_a_float_that_is_not_finite(dag: Dag) -> None:
    with pytest.raises((OverflowError, ValueError)):
        dag.const(math.inf)
