"""Proofs that a node stays away from zero."""

from __future__ import annotations

import pytest

from bgc.algebra.bounds import Bounds
from bgc.algebra.dag import Dag, Kind, Op


@pytest.fixture
def dag() -> Dag:
    return Dag()


def bounds_of(dag: Dag, mass: float = 2.0) -> Bounds:
    """Bounds with every node of parameters at one value, numbers at their own."""

    def default(node: int) -> float:
        value = dag.value(node)
        return mass if value is None else float(value)

    return Bounds(dag, default)


def test_sums_of_squares_and_a_positive_number_stay_away_from_zero(dag: Dag) -> None:
    x, y, m = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.TIME, 0), dag.symbol(Kind.PARAM, 0)
    square = dag.mul(x, x)
    for node in (
        dag.add(m, square),
        dag.neg(dag.add(square, dag.const(1))),
        dag.sub(dag.neg(m), dag.mul(m, dag.mul(y, y))),
        dag.add(dag.call(Op.EXP, x), m),
        dag.call(Op.SQRT, dag.add(m, square)),
        dag.add(m, dag.mul(y, dag.mul(m, y))),
        dag.add(m, dag.mul(y, dag.div(y, m))),
        dag.div(dag.add(m, square), m),
        dag.mul(dag.add(m, square), dag.neg(m)),
        dag.select(dag.call(Op.LT, x, y), m, dag.add(m, square)),
    ):
        assert bounds_of(dag).is_bounded_away(node)


def test_what_may_vanish_is_not_proven(dag: Dag) -> None:
    x, y, m = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.TIME, 0), dag.symbol(Kind.PARAM, 0)
    square = dag.mul(x, x)
    for node in (
        x,
        square,
        dag.call(Op.COS, x),
        dag.call(Op.EXP, x),
        dag.sub(m, square),
        dag.mul(m, square),
        dag.div(m, dag.add(m, square)),
        dag.div(m, x),
        dag.select(dag.call(Op.LT, x, y), m, dag.neg(square)),
    ):
        assert not bounds_of(dag).is_bounded_away(node)
    assert not bounds_of(dag, mass=0.0).is_bounded_away(dag.add(m, square))
