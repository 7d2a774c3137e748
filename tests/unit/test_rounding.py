"""Rounding noise is distinguished from small numbers."""

from __future__ import annotations

import math
from fractions import Fraction

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.rounding import RoundedEvaluator

VALUES = {Symbol(Kind.PARAM, 0): math.pi / 2, Symbol(Kind.PARAM, 1): 3.0}


def test_what_cancels_is_noise_and_what_is_small_is_not() -> None:
    dag = Dag()
    values = RoundedEvaluator(dag, VALUES.__getitem__)
    angle, count = dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.PARAM, 1)
    cosine = dag.call(Op.COS, angle)
    third = dag.div(dag.sub(dag.div(dag.one, count), dag.const(Fraction(1, 3))), dag.const(7))
    for noise in (cosine, dag.mul(cosine, dag.const(10**9)), third):
        assert values.value(noise).is_noise
    for small in (
        dag.const(Fraction(1, 10**17)),
        dag.div(dag.const(Fraction(1, 10**20)), count),
        dag.sub(dag.div(dag.one, count), dag.const(Fraction(333333333, 10**9))),
        dag.call(Op.EXP, dag.neg(dag.mul(count, dag.const(20)))),
    ):
        assert not values.value(small).is_noise


def test_a_choice_at_its_edge_is_taken_as_it_stands() -> None:
    dag = Dag()
    values = RoundedEvaluator(dag, VALUES.__getitem__)
    choice = dag.select(
        dag.call(Op.LE, dag.symbol(Kind.PARAM, 1), dag.const(3)), dag.const(5), dag.zero
    )
    assert values.value(choice).value == 5 and not values.value(choice).is_noise


def test_the_bound_covers_the_error_of_long_sums() -> None:
    """Sums of tenths, against their exact values."""
    dag = Dag()
    total, exact = dag.mul(dag.symbol(Kind.PARAM, 1), dag.zero), Fraction(0)
    values = RoundedEvaluator(dag, VALUES.__getitem__)
    root = dag.call(Op.SQRT, dag.const(Fraction(1, 100) + Fraction(1, 10**30)))  # no fraction
    for k in range(1, 300):
        total = dag.add(total, dag.mul(root, dag.const(Fraction((-1) ** k * k, 7))))
        exact += Fraction((-1) ** k * k, 70)
    found = values.value(total)
    assert abs(Fraction(found.value) - exact) <= Fraction(found.error)
    assert found.error < 1e-10
