"""DAG nodes as text: brackets only where they are needed, shared parts named once."""

from fractions import Fraction

import pytest

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.infix import infix_lines, number


def lines(*roots, dag):
    names = {Kind.STATE: "xyz", Kind.PARAM: "abc"}
    equations = [(f"r{k}", node) for k, node in enumerate(roots)]
    return infix_lines(dag, equations, lambda symbol: names[symbol.kind][symbol.index])


@pytest.fixture
def dag():
    return Dag()


@pytest.fixture
def xy(dag):
    return dag.symbol(Kind.STATE, 0), dag.symbol(Kind.STATE, 1)


def test_brackets_stand_where_an_operator_does_not_associate(dag, xy):
    x, y = xy
    a = dag.symbol(Kind.PARAM, 0)
    assert lines(dag.sub(x, dag.sub(y, a)), dag=dag) == ["r0 = x - (y - a)"]
    assert lines(dag.div(x, dag.mul(y, a)), dag=dag) == ["r0 = x / (y * a)"]
    assert lines(dag.mul(dag.add(x, y), a), dag=dag) == ["r0 = a * (x + y)"]


def test_powers_bind_their_signed_base(dag, xy):
    x, _ = xy
    assert lines(dag.pow(dag.neg(x), dag.const(13)), dag=dag) == ["r0 = (-x)^13"]
    assert lines(dag.neg(dag.pow(x, dag.const(13))), dag=dag) == ["r0 = -x^13"]


def test_a_part_used_twice_is_named_once(dag, xy):
    x, y = xy
    total = dag.add(x, y)
    sine = dag.call(Op.SIN, total)
    assert lines(dag.mul(total, sine), dag=dag) == ["t1 = x + y", "r0 = t1 * sin(t1)"]


def test_a_choice_inside_an_operation_is_bracketed(dag, xy):
    x, y = xy
    choice = dag.select(dag.call(Op.LT, x, y), x, y)
    assert lines(dag.add(dag.one, choice), dag=dag) == ["r0 = 1 + (if x < y then x else y)"]


def test_the_text_is_linear_in_the_nodes_not_in_the_tree(dag, xy):
    node = xy[0]
    for _ in range(200):
        node = dag.call(Op.SIN, dag.add(node, dag.mul(node, xy[1])))
    assert len("\n".join(lines(node, dag=dag))) < 20_000


def test_numbers_are_whole_or_the_shortest_decimal():
    assert number(Fraction(3)) == "3"
    assert number(Fraction(0.1)) == "0.1"
    assert number(Fraction(1, 3)) == repr(1 / 3)
    assert number(Fraction(10) ** 20) == "1e+20"
