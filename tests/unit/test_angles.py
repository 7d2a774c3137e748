"""Sines and cosines of the angles that people mount things at are exact."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from bgc.algebra.dag import Dag, Op
from bgc.algebra.evaluate import evaluate_nodes

PI = Fraction(math.pi)
FUNCTIONS = {Op.SIN: math.sin, Op.COS: math.cos, Op.TAN: math.tan}


@pytest.mark.parametrize("op", FUNCTIONS)
def test_values_are_those_of_the_function(op: Op) -> None:
    dag = Dag()
    for degrees in range(-720, 721, 5):
        if op is Op.TAN and degrees % 180 == 90:
            continue
        node = dag.call(op, dag.const(degrees * (PI / 180)))
        (value,) = evaluate_nodes(dag, [node], {})
        assert value == pytest.approx(FUNCTIONS[op](math.radians(degrees)), rel=1e-13, abs=1e-14)


def test_quarter_turns_are_zeros_and_ones() -> None:
    dag = Dag()
    for quarter, (cosine, sine) in enumerate([(1, 0), (0, 1), (-1, 0), (0, -1)] * 2):
        angle = dag.const(quarter * PI / 2)
        assert dag.value(dag.call(Op.COS, angle)) == cosine
        assert dag.value(dag.call(Op.SIN, angle)) == sine


def test_a_pole_and_other_angles_are_left_alone() -> None:
    dag = Dag()
    for op, angle in ((Op.TAN, PI / 2), (Op.SIN, PI / 5), (Op.COS, Fraction("1.5707963267948966"))):
        assert dag.op[dag.call(op, dag.const(angle))] == op
