"""Fingerprints distinguish zero, constant and equal, and never claim what is not so."""

from __future__ import annotations

import time
from fractions import Fraction

import numpy as np
import pytest

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.fingerprint import PRIME, Fingerprints
from bgc.algebra.linalg import multiply, transpose


@pytest.fixture
def dag() -> Dag:
    return Dag()


def test_rational_identities_are_seen(dag: Dag) -> None:
    x, y = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.PARAM, 3)
    prints = Fingerprints(dag)
    square = dag.mul(dag.add(x, y), dag.add(x, y))
    expanded = dag.add(dag.mul(x, x), dag.add(dag.mul(dag.const(2), dag.mul(x, y)), dag.mul(y, y)))
    assert square != expanded
    assert prints.equal(square, expanded)
    assert prints.is_zero(dag.sub(square, expanded))
    assert prints.is_zero(dag.sub(dag.div(x, y), dag.div(dag.mul(x, x), dag.mul(x, y))))
    assert not prints.is_zero(dag.sub(x, y))


def test_a_rotation_has_determinant_one(dag: Dag) -> None:
    angle = dag.symbol(Kind.STATE, 1)
    s, c = dag.call(Op.SIN, angle), dag.call(Op.COS, angle)
    prints = Fingerprints(dag)
    assert prints.constant(dag.add(dag.mul(s, s), dag.mul(c, c))) == 1
    assert prints.constant(dag.sub(dag.mul(s, s), dag.mul(c, c))) is None
    assert prints.constant(s) is None


def test_a_constant_behind_a_rotation_is_found(dag: Dag) -> None:
    """Also one that is not a fraction, a parameter, and their opposites; nothing that varies."""
    angle, load = dag.symbol(Kind.STATE, 1), dag.symbol(Kind.PARAM, 0)
    s, c = dag.call(Op.SIN, angle), dag.call(Op.COS, angle)
    root = dag.call(Op.SQRT, dag.const(3))

    def there_and_back(node: int) -> int:
        return dag.add(dag.mul(s, dag.mul(s, node)), dag.mul(c, dag.mul(c, node)))

    prints = Fingerprints(dag)
    for node in (dag.const(Fraction(2, 7)), root, dag.neg(root), load, dag.neg(load)):
        turned = there_and_back(node)
        assert turned != node
        assert prints.simplified(turned) == node
    assert prints.simplified(dag.mul(s, root)) == dag.mul(s, root)
    assert prints.simplified(load) == load


def test_simple_fractions_are_recovered(dag: Dag) -> None:
    x = dag.symbol(Kind.STATE, 0)
    prints = Fingerprints(dag)
    node = dag.div(dag.mul(dag.const(-22), x), dag.mul(x, dag.const(7)))
    assert prints.constant(node) == Fraction(-22, 7)
    assert prints.constant(dag.const(Fraction(1, 10**40))) == Fraction(1, 10**40)


@pytest.mark.parametrize(
    "op", [Op.SIN, Op.TAN, Op.ASIN, Op.ATAN, Op.SINH, Op.TANH, Op.CBRT, Op.ERF]
)
def test_odd_functions_are_odd(dag: Dag, op: Op) -> None:
    x, y = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.STATE, 1)
    prints = Fingerprints(dag)
    there, back = dag.call(op, dag.sub(x, y)), dag.call(op, dag.add(dag.neg(x), y))
    assert prints.is_zero(dag.add(there, back))
    assert not prints.equal(there, back)


def test_curves_of_functions_agree(dag: Dag) -> None:
    x = dag.symbol(Kind.STATE, 0)
    prints = Fingerprints(dag)
    s, c, e = dag.call(Op.SINH, x), dag.call(Op.COSH, x), dag.call(Op.EXP, x)
    assert prints.equal(dag.add(s, c), e)
    assert prints.constant(dag.mul(e, dag.call(Op.EXP, dag.neg(x)))) == 1
    quotient = dag.div(dag.call(Op.SIN, x), dag.call(Op.COS, x))
    assert prints.equal(dag.call(Op.TAN, x), quotient)


def test_what_holds_for_half_the_values_is_not_claimed(dag: Dag) -> None:
    x = dag.symbol(Kind.STATE, 0)
    prints = Fingerprints(dag)
    root = dag.call(Op.SQRT, dag.mul(x, x))
    assert not prints.equal(root, x)
    assert not prints.equal(dag.call(Op.ABS, x), x)
    assert not prints.is_zero(dag.select(dag.call(Op.LT, x, dag.one), x, dag.zero))
    assert prints.equal(dag.call(Op.ABS, x), dag.call(Op.ABS, dag.neg(x)))


def test_fingerprints_grow_with_the_dag_in_linear_time(dag: Dag) -> None:
    prints = Fingerprints(dag)
    node = dag.symbol(Kind.STATE, 0)
    start = time.process_time()
    for k in range(20_000):
        node = dag.add(dag.mul(node, node), dag.const(k))
        prints.is_zero(node)
    assert time.process_time() - start < 2


def test_a_long_decimal_behind_a_rotation_is_not_taken_for_another_number() -> None:
    """Most residues are those of some fraction of nine digits."""
    dag = Dag()
    x = dag.symbol(Kind.STATE)
    sine, cosine = dag.call(Op.SIN, x), dag.call(Op.COS, x)
    one = dag.add(dag.mul(sine, sine), dag.mul(cosine, cosine))
    fingerprints = Fingerprints(dag)
    for k in range(1, 40):
        length = Fraction(123456789012 + 7 * k, 10**11)
        assert fingerprints.constant(dag.mul(dag.const(length), one)) in {None, length}
        short = Fraction(123456 + k, 10**5)
        assert fingerprints.constant(dag.mul(dag.const(short), one)) == short


def test_powers_of_two_are_told_apart() -> None:
    """Modulo the Mersenne prime 2^61 - 1 alone, 2^61 and 1 are the same; any prime has such."""
    dag = Dag()
    fingerprints = Fingerprints(dag)
    assert not fingerprints.equal(dag.const(PRIME + 1), dag.one)
    large = dag.const(2**61)
    assert not fingerprints.equal(large, dag.one)
    assert not fingerprints.is_zero(dag.sub(dag.mul(large, dag.symbol(Kind.STATE)), dag.one))


def test_square_roots_of_numbers_multiply_as_they_should() -> None:
    dag = Dag()
    prints = Fingerprints(dag)

    def root(number: int | Fraction) -> int:
        return dag.call(Op.SQRT, dag.const(number))

    assert prints.equal(root(20), dag.mul(dag.const(2), root(5)))
    assert prints.equal(dag.mul(root(6), root(Fraction(7, 10))), root(Fraction(42, 10)))
    assert prints.constant(dag.mul(root(149), root(149))) == 149
    assert prints.constant(dag.mul(root(2 * 10007**2), root(2))) == 2 * 10007
    assert not prints.equal(root(20), dag.mul(dag.const(-2), root(5)))
    assert not prints.equal(dag.add(root(2), root(3)), root(5))
    assert not prints.equal(root(151 * 157), dag.mul(root(151), root(157)))  # not proven


def test_an_axis_divided_by_its_norm_turns_about_itself() -> None:
    """`A n = n` and `A A' = 1` for a rotation by any angle about it."""
    dag = Dag()
    prints = Fingerprints(dag)
    angle = dag.symbol(Kind.STATE)
    norm = dag.call(Op.SQRT, dag.const(18))
    x, y, z = (dag.div(dag.const(k), norm) for k in (1, -4, -1))
    sine, cosine = dag.call(Op.SIN, angle), dag.call(Op.COS, angle)
    skew = ((dag.zero, dag.neg(z), y), (z, dag.zero, dag.neg(x)), (dag.neg(y), x, dag.zero))
    squared = multiply(dag, skew, skew)
    versine = dag.sub(dag.one, cosine)
    turn = tuple(
        tuple(
            dag.sum([dag.const(i == j), dag.mul(sine, s), dag.mul(versine, t)])
            for j, (s, t) in enumerate(zip(line, line2, strict=True))
        )
        for i, (line, line2) in enumerate(zip(skew, squared, strict=True))
    )
    for row, component in zip(turn, (x, y, z), strict=True):
        assert prints.equal(dag.dot(row, (x, y, z)), component)
    product = multiply(dag, turn, transpose(turn))
    assert [[prints.constant(node) for node in row] for row in product] == np.eye(3).tolist()
