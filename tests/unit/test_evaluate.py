"""Numbers for nodes: doubles as Python and NumPy give them, C's results at the edges."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.evaluate import Repeated, apply, evaluate_nodes, to_double

INF, NAN = math.inf, math.nan
reals = st.floats(-50, 50)


@given(reals, reals)
def test_a_formula_of_two_symbols(x: float, y: float) -> None:
    dag = Dag()
    a, b = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.PARAM, 4)
    root = dag.sub(dag.mul(dag.call(Op.SIN, a), b), dag.call(Op.HYPOT, a, dag.const(3)))
    chosen = dag.select(dag.call(Op.LT, a, b), root, dag.neg(a))
    values = {Symbol(Kind.STATE, 0): x, Symbol(Kind.PARAM, 4): y}
    expected = math.sin(x) * y - math.hypot(x, 3)
    assert evaluate_nodes(dag, [root, chosen], values) == [expected, expected if x < y else -x]


def test_time_is_linear_in_shared_nodes() -> None:
    dag = Dag()
    node = dag.symbol(Kind.STATE)
    for _ in range(20_000):
        node = dag.mul(dag.add(node, node), dag.const(0.5))
    assert evaluate_nodes(dag, [node], {Symbol(Kind.STATE, 0): 3.0}) == [3.0]


def test_a_symbol_without_a_value_is_a_key_error() -> None:
    dag = Dag()
    with pytest.raises(KeyError):
        evaluate_nodes(dag, [dag.symbol(Kind.TIME)], {})


def test_nodes_evaluated_repeatedly_have_the_values_of_each_point() -> None:
    """Also where a matrix is inverted, or its inverse is a constant."""
    dag = Dag()
    x, y = (dag.symbol(Kind.STATE, k) for k in range(2))
    rows = dag.inverted([[x, dag.one], [dag.const(2), y]])
    fixed = dag.call(Op.SIN, dag.const(3))
    roots = [*rows[0], *rows[1], dag.mul(fixed, x), fixed, dag.select(dag.call(Op.LT, x, y), x, y)]
    repeated = Repeated(dag, roots)
    for point in ((1.5, 4.0), (-2.0, 0.5), (1.5, 4.0), (INF, 1.0)):
        values = {Symbol(Kind.STATE, k): v for k, v in enumerate(point)}
        assert str(repeated.at(values)) == str(evaluate_nodes(dag, roots, values))
    with pytest.raises(KeyError):
        repeated.at({Symbol(Kind.STATE, 0): 1.0})


@pytest.mark.parametrize(
    ("op", "operands", "expected"),
    [
        (Op.DIV, (1.0, 0.0), INF),
        (Op.DIV, (1.0, -0.0), -INF),
        (Op.DIV, (-1.0, 0.0), -INF),
        (Op.DIV, (0.0, 0.0), NAN),
        (Op.POW, (10.0, 400.0), INF),
        (Op.POW, (-10.0, 401.0), -INF),
        (Op.POW, (-10.0, 400.0), INF),
        (Op.POW, (-8.0, 1 / 3), NAN),
        (Op.POW, (0.0, -1.0), INF),
        (Op.EXP, (1e4,), INF),
        (Op.SINH, (-1e4,), -INF),
        (Op.COSH, (-1e4,), INF),
        (Op.LOG, (0.0,), -INF),
        (Op.LOG, (-1.0,), NAN),
        (Op.LOG1P, (-1.0,), -INF),
        (Op.SQRT, (-1.0,), NAN),
        (Op.ASIN, (2.0,), NAN),
        (Op.ACOSH, (0.5,), NAN),
        (Op.ATANH, (-1.0,), -INF),
        (Op.ATANH, (2.0,), NAN),
        (Op.SIN, (INF,), NAN),
        (Op.FMOD, (7.5, -2.0), 1.5),
        (Op.FMOD, (1.0, 0.0), NAN),
        (Op.FLOOR, (-INF,), -INF),
        (Op.FLOOR, (-0.5,), -1.0),
        (Op.CEIL, (NAN,), NAN),
        (Op.SIGN, (-3.0,), -1.0),
        (Op.SIGN, (NAN,), NAN),
        (Op.MIN, (NAN, 1.0), NAN),
        (Op.MAX, (1.0, NAN), NAN),
        (Op.POW, (-0.0, -1.0), -INF),
        (Op.CBRT, (-8.0,), -2.0),
        (Op.SELECT, (0.0, 1.0, 2.0), 2.0),
        (Op.NOT, (0.0,), 1.0),
    ],
)
def test_edges_are_those_of_c(op: Op, operands: tuple[float, ...], expected: float) -> None:
    found = apply(op, *operands)
    assert found == expected or (math.isnan(found) and math.isnan(expected))


@pytest.mark.parametrize(
    ("op", "function"),
    [
        (Op.TAN, math.tan),
        (Op.ATAN, math.atan),
        (Op.TANH, math.tanh),
        (Op.ASINH, math.asinh),
        (Op.EXPM1, math.expm1),
        (Op.ERF, math.erf),
        (Op.ABS, abs),
    ],
)
@given(x=reals)
def test_functions_are_those_of_the_library(
    op: Op, function: Callable[[float], float], x: float
) -> None:
    assert apply(op, x) == function(x)


def test_long_fractions_become_doubles() -> None:
    assert to_double(Fraction(1, 3)) == 1 / 3
    assert to_double(Fraction(10) ** 400) == INF
    assert to_double(-(Fraction(10) ** 400)) == -INF
