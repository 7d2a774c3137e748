"""Signs by values: at random points, and where all that varies is zero."""

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.signs import Signs


def test_a_square_has_no_certain_sign_since_it_vanishes_at_zero():
    dag = Dag()
    x, k = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.PARAM, 0)
    defaults = {dag.symbol_of(k): 2.0}
    signs = Signs(dag, defaults)
    square = dag.mul(x, x)
    assert signs.is_certain(dag.add(square, k)) and signs.is_certain(dag.neg(k))
    assert not signs.is_certain(square) and not signs.is_certain(x)
    pivots = [square, dag.add(square, k), k, dag.one]
    assert [signs.rank(pivot) for pivot in pivots] == [3, 2, 1, 0]


def test_a_rounding_error_has_no_sign():
    dag = Dag()
    a, b = dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.PARAM, 1)
    signs = Signs(dag, {dag.symbol_of(a): 0.1, dag.symbol_of(b): 0.3})
    noise = dag.sub(dag.mul(dag.const(3), a), b)  # 5.6e-17 in doubles
    assert [signs.rank(node) for node in (a, noise)] == [1, 3]
