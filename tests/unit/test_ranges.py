"""Ranges of terms of time alone: which terms are watched, and bounds of every operation."""

from __future__ import annotations

import numpy as np
import pytest
from programs import CompiledModel, at, make_program, states

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.intervals import UNKNOWN
from bgc.algebra.operations import ROWS
from bgc.emission.emit import emit_model
from bgc.emission.timed_terms import find_timed_terms

FUNCTIONS = [op for op in Op if op.row.name]
OPERATORS = [
    *(Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.POW, Op.SELECT),
    *(Op.LT, Op.LE, Op.EQ, Op.AND, Op.OR, Op.NOT),
]
ABOVE_ONE = {Op.ACOSH}
WITHIN_ONE = {Op.ASIN, Op.ACOS, Op.ATANH}


@pytest.fixture
def dag() -> Dag:
    return Dag()


def terms_of(dag: Dag, node: int) -> list[int]:
    return [term for term, _ in find_timed_terms(make_program(dag, [node], inputs=1), ())]


def test_summands_are_watched_without_their_factors(dag: Dag) -> None:
    (x,), t, u = states(dag, 1), dag.symbol(Kind.TIME), dag.symbol(Kind.INPUT, 0)
    wave, pulse = dag.call(Op.SIN, dag.mul(u, t)), dag.call(Op.EXP, dag.neg(dag.mul(t, t)))
    force = dag.add(dag.mul(dag.const(3), wave), dag.sub(t, dag.div(pulse, u)))
    assert set(terms_of(dag, dag.mul(x, force))) == {wave, pulse}
    product = dag.mul(wave, pulse)
    assert terms_of(dag, dag.add(x, dag.neg(product))) == [product]


def test_what_is_linear_in_time_or_depends_on_states_is_not(dag: Dag) -> None:
    (x,), t, u = states(dag, 1), dag.symbol(Kind.TIME), dag.symbol(Kind.INPUT, 0)
    for node in (dag.mul(u, t), dag.call(Op.SIN, u), dag.call(Op.SIN, dag.mul(x, t))):
        assert terms_of(dag, node) == []


def of_time(dag: Dag, op: Op) -> int:
    """The operation on operands that move with time, twice where it takes two, and bend."""
    t = dag.symbol(Kind.TIME)
    wave = dag.call(Op.SIN, dag.add(dag.mul(t, t), t))
    if op in ABOVE_ONE:
        wave = dag.add(dag.const(3), wave)
    elif op in WITHIN_ONE:
        wave = dag.mul(dag.const(0.9), wave)
    elif op in {Op.POW, Op.LOG, Op.LOG10, Op.LOG1P, Op.SQRT, Op.DIV}:
        wave = dag.add(dag.const(1.5), wave)
    other = dag.add(dag.const(2), dag.call(Op.COS, t))
    operands = (wave, dag.const(0.7) if op is Op.FMOD else other, t)
    made = dag.apply(int(op), operands[: ROWS[op].arity])
    bend = dag.mul(dag.const(1e-9), dag.mul(t, t))  # also where it is constant
    return dag.mul(made, dag.add(dag.one, bend))


def test_bounds_hold_for_every_operation_and_become_tight(dag: Dag, tmp_path) -> None:
    known = [
        op for op in (*OPERATORS, *FUNCTIONS) if op in OPERATORS or op.row.bounds is not UNKNOWN
    ]
    nodes = {op: of_time(dag, op) for op in known}
    nodes |= {op: of_time(dag, op) for op in OPERATORS}
    (x,) = states(dag, 1)
    rates = [dag.add(x, node) for node in nodes.values()]
    program = make_program(dag, rates, inputs=1)
    emitted = emit_model(program, "0")
    lowered = emitted.lowered
    assert lowered.ranges is not None
    watched = [store.node for store in lowered.ranges.stores]
    assert len(watched) >= 2 * len(nodes)
    released = [0.0, *[np.nan] * len(lowered.switches)]
    model = CompiledModel(emitted, tmp_path)
    for low, width in ((0.1, 2.0), (0.9, 0.3), (1.7, 1e-6), (2.9, 1e-9)):
        times = np.linspace(low, low + width, 101)
        found = model.ranges(low, low + width)
        points = [at([0.0] * len(rates), t=t, u=released) for t in times]
        values = np.array([evaluate_nodes(lowered.program.dag, watched, p) for p in points])
        for k, node in enumerate(watched):
            bounds, column = found[k // 2, k % 2], values[:, k]
            slack = 1e-12 * (1 + np.abs(column).max())
            assert bounds[0] <= column.min() + slack, (lowered.program.dag.op[node], low, width)
            assert bounds[1] >= column.max() - slack, (lowered.program.dag.op[node], low, width)
            if width == 1e-9 and np.ptp(column) < 1e-6 and k % 2 == 0:
                assert bounds[1] - bounds[0] < 1e-5, lowered.program.dag.op[node]


def test_a_choice_that_is_not_certain_has_both_values(dag: Dag, tmp_path) -> None:
    t = dag.symbol(Kind.TIME)
    square = dag.mul(t, t)
    node = dag.select(dag.call(Op.LT, t, dag.const(2)), square, dag.mul(dag.const(10), square))
    rates = [dag.add(*states(dag, 1), node)]
    model = CompiledModel(emit_model(make_program(dag, rates, inputs=1), "0"), tmp_path)
    for span, expected in (((0, 1), (0, 1)), ((1, 2.5), (1, 62.5)), ((3, 4), (90, 160))):
        np.testing.assert_allclose(model.ranges(*span)[0, 0], expected)
