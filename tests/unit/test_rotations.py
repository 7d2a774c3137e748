"""Inverses that are known without dividing by anything that could vanish."""

from __future__ import annotations

import pytest

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.linalg import multiply, transpose
from bgc.causality.rotations import Inverse, known_inverse
from bgc.ir.graph import Matrix


@pytest.fixture
def dag() -> Dag:
    return Dag()


def rotation(dag: Dag) -> Matrix:
    angle = dag.symbol(Kind.STATE, 0)
    s, c = dag.call(Op.SIN, angle), dag.call(Op.COS, angle)
    return ((c, dag.neg(s)), (s, c))


def assert_inverse(dag: Dag, matrix: Matrix, inverse: Inverse | None) -> None:
    assert inverse is not None
    prints = Fingerprints(dag)
    for i, row in enumerate(multiply(dag, matrix, inverse.matrix)):
        assert [prints.constant(node) for node in row] == [int(i == j) for j in range(len(row))]


def test_the_inverse_of_a_rotation_is_its_transpose(dag: Dag) -> None:
    matrix = rotation(dag)
    assert known_inverse(dag, Fingerprints(dag), matrix) == Inverse(transpose(matrix))


def test_a_constant_determinant_is_enough(dag: Dag) -> None:
    x, one, zero = dag.symbol(Kind.STATE, 0), dag.one, dag.zero
    shear = ((one, x, zero), (zero, one, x), (zero, zero, dag.const(2)))
    assert_inverse(dag, shear, known_inverse(dag, Fingerprints(dag), shear))
    mixed = ((x, dag.add(x, one)), (dag.sub(x, one), x))  # determinant 1
    assert_inverse(dag, mixed, known_inverse(dag, Fingerprints(dag), mixed))


def test_blocks_are_inverted_one_by_one(dag: Dag) -> None:
    (a, b), (c, d) = rotation(dag)
    x, zero = dag.symbol(Kind.STATE, 1), dag.zero
    carried = ((a, b, x, zero), (c, d, zero, x), (zero, zero, a, b), (zero, zero, c, d))
    assert_inverse(dag, carried, known_inverse(dag, Fingerprints(dag), carried))
    assert_inverse(
        dag, transpose(carried), known_inverse(dag, Fingerprints(dag), transpose(carried))
    )


@pytest.mark.parametrize("size", [2, 3])
def test_a_multiple_of_a_rotation_is_divided_by_its_factor(dag: Dag, size: int) -> None:
    factor = dag.symbol(Kind.PARAM, 0)
    for scale in (factor, dag.const(220_000_000), dag.call(Op.EXP, dag.const(1))):
        turned = [[dag.mul(scale, node) for node in row] for row in rotation(dag)]
        if size == 3:
            turned = [[scale, dag.zero, dag.zero], *([dag.zero, *row] for row in turned)]
        matrix = tuple(map(tuple, turned))
        inverse = known_inverse(dag, Fingerprints(dag), matrix)
        assert_inverse(dag, matrix, inverse)
        assert inverse is not None and inverse.divisors == (scale,)


def test_a_multiple_of_a_matrix_with_determinant_1_is_divided_by_its_factor(dag: Dag) -> None:
    x, zero, one = dag.symbol(Kind.STATE, 0), dag.zero, dag.one
    more = dag.add(one, dag.mul(x, x))
    scaled = [
        tuple(dag.mul(dag.symbol(Kind.PARAM, 0), node) for node in row)
        for row in ((one, x, zero), (x, more, x), (zero, x, more))
    ]
    assert_inverse(dag, tuple(scaled), known_inverse(dag, Fingerprints(dag), tuple(scaled)))


def test_blocks_may_have_factors_of_their_own(dag: Dag) -> None:
    (a, b), (c, d) = rotation(dag)
    one, two = dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.PARAM, 1)
    x, zero = dag.symbol(Kind.STATE, 1), dag.zero
    first = [[dag.mul(one, node) for node in row] for row in ((a, b), (c, d))]
    matrix = ((*first[0], x), (*first[1], x), (zero, zero, two))
    inverse = known_inverse(dag, Fingerprints(dag), matrix)
    assert_inverse(dag, matrix, inverse)
    assert inverse is not None and inverse.divisors == (one, two)


def test_what_may_vanish_is_not_inverted(dag: Dag) -> None:
    x = dag.symbol(Kind.STATE, 0)
    prints = Fingerprints(dag)
    assert known_inverse(dag, prints, ((x,),)) is None
    assert known_inverse(dag, prints, ((x, dag.zero), (dag.zero, dag.one))) is None
    assert known_inverse(dag, prints, ((dag.one, dag.zero),)) is None
