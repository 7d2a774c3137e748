"""Ranges of nodes that vary hold all their values, whatever the parameters are."""

import math
import random

import pytest

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.ranges import Ranges

ONE = [Op.NEG, Op.SIN, Op.COS, Op.TANH, Op.ERF, Op.SIGN, Op.ATAN, Op.ASINH, Op.SINH, Op.CBRT,
       Op.EXP, Op.COSH, Op.ABS]  # fmt: skip
TWO = [Op.ADD, Op.SUB, Op.MUL, Op.MAX, Op.MIN, Op.LT, Op.HYPOT]


def drawn(rng, dag, depth):
    """An expression of two states and two parameters."""
    if depth == 0 or rng.random() < 0.1:
        kind = rng.choice([Kind.STATE, Kind.PARAM])
        number = dag.const(rng.choice([-2, -1, 1, 3]))
        return rng.choice([dag.symbol(kind, rng.randrange(2)), number])
    a, b = drawn(rng, dag, depth - 1), drawn(rng, dag, depth - 1)
    match rng.randrange(6):
        case 0 | 1:
            return dag.call(rng.choice(ONE), a)
        case 2:
            return dag.select(dag.call(Op.LT, a, b), a, b)
        case 3:
            return dag.pow(a, dag.const(rng.choice([2, 3, 4])))
        case 4:
            square = dag.call(Op.SQRT, dag.add(dag.mul(a, a), dag.one))
            return dag.div(square, rng.choice([dag.const(-4), dag.symbol(Kind.PARAM, 0)]))
        case _:
            return dag.apply(rng.choice(TWO), (a, b))


@pytest.mark.parametrize("seed", range(3))
def test_values_lie_in_their_ranges(seed):
    rng, bounded = random.Random(seed), 0
    for _ in range(300):
        dag = Dag()
        node = drawn(rng, dag, 4)
        found = Ranges(dag).of(node)
        bounded += found.low is not None or found.high is not None
        for _ in range(6):
            values = {dag.symbol_of(dag.symbol(Kind.PARAM, k)): rng.gauss(0, 2) for k in (0, 1)}
            ends = [end for end in (found.low, found.high) if end is not None]
            limits = dict(zip(ends, evaluate_nodes(dag, ends, values), strict=True))
            for k in (0, 1):
                values[dag.symbol_of(dag.symbol(Kind.STATE, k))] = rng.choice([1, 30]) * rng.gauss(
                    0, 1
                )
            (value,) = evaluate_nodes(dag, [node], values)
            if not math.isfinite(value):
                continue
            slack = 1e-9 * (
                1 + abs(value) + sum(abs(x) for x in limits.values() if math.isfinite(x))
            )
            low = limits.get(found.low, -math.inf)
            high = limits.get(found.high, math.inf)
            assert math.isnan(low) or low <= value + slack
            assert math.isnan(high) or value <= high + slack
    assert bounded > 100


def test_ranges_that_keep_levers_from_zero():
    dag = Dag()
    x, r, a = dag.symbol(Kind.STATE), dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.PARAM, 1)
    values = {dag.symbol_of(r): 2.0, dag.symbol_of(a): -1.5}
    ranges = Ranges(dag)

    def low(node):
        (found,) = evaluate_nodes(dag, [ranges.of(node).low], values)
        return found

    assert low(dag.add(r, dag.mul(a, dag.call(Op.SIN, x)))) == 0.5
    assert low(dag.call(Op.SQRT, dag.add(dag.mul(r, r), dag.pow(x, dag.const(2))))) == 2
    assert low(dag.call(Op.MAX, x, r)) == 2
    assert low(dag.call(Op.COSH, x)) == 1
    clamped = dag.call(Op.MIN, dag.call(Op.MAX, x, r), dag.const(3))
    assert low(dag.mul(dag.neg(a), clamped)) == 3
    assert ranges.of(dag.call(Op.COS, x)).low == dag.const(-1)
    assert ranges.of(x).low is None
