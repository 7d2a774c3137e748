"""Proven intervals hold every value, for all operations, with numbers and with nodes as ends."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

import pytest

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.evaluate import Evaluator
from bgc.algebra.interpretation import Intervals, NodeIntervals
from bgc.algebra.rounding import RoundedEvaluator

OPERATIONS = [op for op in Op if op.row.arity and op.row.smooth]
NUMBERS = [0, 0.5, 1, -1, 2, -3, 1 / 3, 7, -0.7, 1e-300, -1e-200, 1e155, 1e300, math.pi / 2]
EXPONENTS = [2, 3, -1, -2, 0.5, -0.5, 1.7, 9, 10, 11, -9, -12, 2.5]
EDGES = [0.0, -0.0, 1.0, -1.0, 0.5, -2.0, 3.0, math.pi, 5e-324, -1e-310, 1e150, -1e308]
RANGES = {0: (0.5, 3.0), 1: (-math.inf, 0.0), 2: (-1e-9, math.inf), 3: (-2.0, 2.0)}


@pytest.fixture
def dag() -> Dag:
    return Dag()


def drawn(rng: random.Random, dag: Dag, count: int = 25) -> list[int]:
    """The nodes of a random graph: all operations, numbers, four states and four parameters."""
    nodes = [dag.symbol(kind, k) for kind in (Kind.STATE, Kind.PARAM) for k in range(4)]
    nodes += [dag.const(x) for x in rng.sample(NUMBERS, 4)]
    for _ in range(count):
        op = rng.choice(OPERATIONS)
        operands = [
            rng.choice(nodes[-12:] if rng.random() < 0.6 else nodes) for _ in op.row.arguments
        ]
        if op is Op.POW and rng.random() < 0.7:
            operands[1] = dag.const(rng.choice(EXPONENTS))
        if op in {Op.MUL, Op.ADD, Op.DIV} and rng.random() < 0.3:
            operands[1] = operands[0]
        nodes.append(dag.apply(op, tuple(operands)))
    return nodes


def values(rng: random.Random, count: int) -> Iterator[dict[Symbol, float]]:
    """Values of the symbols, at the edges of doubles and between them."""

    def anywhere() -> float:
        if rng.random() < 0.3:
            return rng.choice(EDGES)
        size = rng.choice([1, 1, 1, 3, 12, 300])
        return rng.choice((-1, 1)) * 10 ** rng.uniform(-size, size)

    for _ in range(count):
        point = {Symbol(Kind.STATE, k): anywhere() for k in range(4)}
        for k, (low, high) in RANGES.items():
            inside = min(max(anywhere(), low), high)
            point[Symbol(Kind.PARAM, k)] = rng.choice([inside, max(low, -9.0), min(high, 9.0)])
        yield point


def admissible(dag: Dag, node: int) -> tuple[float, float] | None:
    symbol = dag.symbol_of(node)
    return RANGES[symbol.index] if symbol is not None and symbol.kind is Kind.PARAM else None


def finite_below(dag: Dag, nodes: list[int], numbers: Evaluator) -> Iterator[tuple[int, float]]:
    """The nodes that are finite with all their operands, and their values."""
    finite: set[int] = set()
    for node in dag.reachable(nodes):
        value = numbers.value(node)
        if math.isfinite(value) and finite.issuperset(dag.operands(node)):
            finite.add(node)
            yield node, value


@pytest.mark.parametrize("seed", range(6))
def test_every_value_that_doubles_reach_is_within(seed: int) -> None:
    rng, bounded = random.Random(seed), 0
    for _ in range(60):
        dag = Dag()
        nodes = drawn(rng, dag)
        anyhow = Intervals(dag)
        within_ranges = Intervals(dag, lambda node, dag=dag: admissible(dag, node))
        for point in values(rng, 25):
            numbers = Evaluator(dag, point.__getitem__)
            for node, value in finite_below(dag, nodes, numbers):
                for intervals in (anyhow, within_ranges):
                    low, high = intervals.limits(node)
                    bounded += math.isfinite(low) + math.isfinite(high)
                    assert low <= value <= high, (Op(dag.op[node]), value, low, high, point)
    assert bounded > 10_000


@pytest.mark.parametrize("seed", range(4))
def test_nodes_as_ends_hold_all_values(seed: int) -> None:
    rng, bounded = random.Random(seed), 0
    for _ in range(60):
        dag = Dag()
        nodes = drawn(rng, dag)
        found = dict(zip(nodes, NodeIntervals(dag).values(nodes), strict=True))
        for point in values(rng, 15):
            numbers, ends = (
                Evaluator(dag, point.__getitem__),
                RoundedEvaluator(dag, point.__getitem__),
            )
            for node, value in finite_below(dag, nodes, numbers):
                if node not in found:
                    continue
                error = 8 * RoundedEvaluator(dag, point.__getitem__).value(node).error
                for end, sign in ((found[node].low, 1), (found[node].high, -1)):
                    if end is not None and math.isfinite(ends.value(end).value):
                        bounded += dag.level[node] > 1
                        low = min(sign * x for x in ends.value(end).limits)
                        if not math.isnan(low + error):
                            assert low <= sign * value + error, (Op(dag.op[node]), value, point)
    assert bounded > 1000


def test_every_operation_has_a_bound_somewhere(dag: Dag) -> None:
    """No rule is missing: of operands between bounds, the result is between bounds too."""
    inside = dag.mul(dag.const(0.4), dag.call(Op.SIN, dag.symbol(Kind.STATE, 0)))
    for op in OPERATIONS:
        moved = {Op.ACOSH: 2, Op.LOG: 1, Op.LOG10: 1, Op.DIV: 1}.get(op, 0)
        operand = dag.add(inside, dag.const(moved))
        other = dag.add(dag.call(Op.COS, dag.symbol(Kind.STATE, 1)), dag.const(2))
        operands = (operand, other, operand)[: op.row.arity]
        if op is Op.POW:
            operands = (other, operand)
        low, high = Intervals(dag).limits(dag.apply(op, operands))
        assert math.isfinite(low) and math.isfinite(high), op.name
        ends = NodeIntervals(dag).value(dag.apply(op, operands))
        assert ends.low is not None and ends.high is not None, op.name


@pytest.mark.parametrize("op", [op for op in OPERATIONS if op.row.arity == 1 and op is not Op.NOT])
def test_intervals_of_monotone_functions_are_tight(dag: Dag, op: Op) -> None:
    """At most twice as wide as the values found in between, but for jumps."""
    inside = dag.mul(dag.const(0.2), dag.call(Op.SIN, dag.symbol(Kind.STATE, 0)))
    centre = {Op.ACOSH: 2, Op.LOG: 1, Op.LOG10: 1}.get(op, 0.4)
    node = dag.apply(op, (dag.add(inside, dag.const(centre)),))
    low, high = Intervals(dag).limits(node)
    point = (Evaluator(dag, lambda symbol, k=k: k / 10).value(node) for k in range(63))
    found = list(point)
    assert low <= min(found) and max(found) <= high
    assert high - low <= 1.05 * (max(found) - min(found))


def limits_at(dag: Dag, mass: float) -> Intervals:
    """Intervals with every node of parameters near one value, numbers at their own."""
    return Intervals(dag, lambda node: (mass, mass) if dag.level[node] == 1 else None)


def test_sums_of_squares_and_a_positive_number_stay_away_from_zero(dag: Dag) -> None:
    x, y, m = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.TIME, 0), dag.symbol(Kind.PARAM, 0)
    square = dag.mul(x, x)
    for node in (
        dag.add(m, square),
        dag.neg(dag.add(square, dag.const(1))),
        dag.sub(dag.neg(dag.const(2)), dag.mul(m, dag.mul(y, y))),
        dag.add(dag.call(Op.EXP, x), m),
        dag.call(Op.SQRT, dag.add(m, square)),
        dag.add(m, dag.mul(y, dag.mul(m, y))),
        dag.add(m, dag.mul(y, dag.div(y, m))),
        dag.add(m, dag.mul(dag.mul(x, y), dag.mul(y, x))),
        dag.div(dag.add(m, square), m),
        dag.mul(dag.add(m, square), dag.neg(dag.const(2))),
        dag.select(dag.call(Op.LT, x, y), m, dag.add(m, square)),
    ):
        assert limits_at(dag, 2.0).excludes_zero(node)


def test_what_may_vanish_is_not_proven(dag: Dag) -> None:
    x, y, m = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.TIME, 0), dag.symbol(Kind.PARAM, 0)
    square, below = dag.mul(x, x), dag.sub(dag.const(-1), dag.mul(x, x))
    for node in (
        x,
        square,
        dag.call(Op.COS, x),
        dag.call(Op.EXP, x),
        dag.call(Op.SQRT, square),
        dag.call(Op.SQRT, dag.sub(square, dag.const(1))),
        dag.call(Op.CBRT, square),
        dag.pow(below, dag.const(0.3)),
        dag.pow(below, dag.const(11)),
        dag.pow(square, m),
        dag.sub(m, square),
        dag.mul(m, square),
        dag.div(m, dag.add(m, square)),
        dag.div(m, x),
        dag.select(dag.call(Op.LT, x, y), m, dag.neg(square)),
    ):
        expected = dag.op[node] == Op.POW and dag.value(dag.b[node]) == 11
        assert limits_at(dag, 2.0).excludes_zero(node) == expected
    assert not limits_at(dag, 0.0).excludes_zero(dag.add(m, square))


def test_signs(dag: Dag) -> None:
    x, p = dag.symbol(Kind.STATE), dag.symbol(Kind.PARAM, 0)
    signs = Intervals(dag, lambda node: admissible(dag, node))
    square = dag.mul(x, x)
    assert signs.sign(square) == 1
    assert signs.sign(dag.div(square, dag.neg(p))) == -1
    assert signs.sign(dag.mul(x, dag.div(p, x))) == 1
    assert signs.sign(dag.mul(x, p)) == 0
    assert signs.sign(dag.pow(dag.sub(dag.const(-1), square), dag.const(0.3))) == 1
    assert signs.sign(dag.pow(dag.sub(dag.const(-1), square), dag.const(-11))) == 0
    assert signs.sign(dag.pow(dag.neg(p), dag.const(9))) == -1
    assert signs.sign(dag.sub(p, dag.const(0.5))) == 1  # exactly zero at the end


def test_ranges_that_keep_levers_from_zero(dag: Dag) -> None:
    x, r, a = dag.symbol(Kind.STATE), dag.symbol(Kind.PARAM, 0), dag.symbol(Kind.PARAM, 1)
    point = {dag.symbol_of(r): 2.0, dag.symbol_of(a): -1.5}
    ranges = NodeIntervals(dag)

    def low(node: int) -> float:
        end = ranges.value(node).low
        assert end is not None
        return Evaluator(dag, point.__getitem__).value(end)

    assert low(dag.add(r, dag.mul(a, dag.call(Op.SIN, x)))) == 0.5
    assert low(dag.call(Op.SQRT, dag.add(dag.mul(r, r), dag.pow(x, dag.const(2))))) == 2
    assert low(dag.call(Op.MAX, x, r)) == 2
    assert low(dag.call(Op.COSH, x)) == 1
    moved = dag.add(r, dag.call(Op.SIN, x))
    assert low(dag.call(Op.ABS, moved)) == 1
    assert low(dag.call(Op.ABS, dag.neg(moved))) == 1
    clamped = dag.call(Op.MIN, dag.call(Op.MAX, x, r), dag.const(3))
    assert low(dag.mul(dag.neg(a), clamped)) == 3
    assert ranges.value(dag.call(Op.COS, x)).low == dag.const(-1)
    assert ranges.value(x).low is None


@pytest.mark.parametrize("op", [Op.SIN, Op.EXP, Op.LOG1P, Op.CBRT, Op.ERFC, Op.HYPOT, Op.POW])
def test_functions_of_the_library_have_four_units_of_error(dag: Dag, op: Op) -> None:
    """Functions on vector registers are not correctly rounded."""
    node = dag.apply(op, tuple(map(dag.const, (0.3, 0.7)[: op.row.arity])))
    low, high = Intervals(dag).limits(node)
    value = Evaluator(dag, {}.__getitem__).value(node)
    unit = math.ulp(value)
    assert value - 9 * unit < low <= value - 4 * unit < value + 4 * unit <= high
