"""Rows put in sequence: raw rows where these serve, elimination in what is left."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.certificates import Certifier
from bgc.causality.sequence import sequence_rows
from bgc.ir.causal import Row, RowEnd, Step

Entries = dict[int, int]  # class -> coefficient


def sequenced(dag: Dag, rows: list[Entries], dependents: list[int]) -> tuple[Step, ...]:
    """Rows over classes, each a bond of its own; the given steps only say which depend."""
    size = 1 + max(number for row in rows for number in row)
    fingerprints = Fingerprints(dag)
    steps, _ = sequence_rows(
        dag,
        fingerprints,
        Certifier(dag, fingerprints, ()),
        range(size),
        [Row(0, tuple(RowEnd(k, 1, entry) for k, entry in row.items())) for row in rows],
        [Step(k, number, (), ()) for k, number in enumerate(dependents)],
    )
    return steps


def check(dag: Dag, rows: list[Entries], dependents: list[int]) -> tuple[Step, ...]:
    """The guarantees of `Step`: rows are put together again, no dependent class is used later."""
    steps = sequenced(dag, rows, dependents)
    fingerprints = Fingerprints(dag)
    assert sorted(step.dependent for step in steps) == sorted(dependents)
    assert sorted(step.row for step in steps) == list(range(len(rows)))
    working = {step.row: dict(step.working) for step in steps}
    for place, step in enumerate(steps):
        assert not any(step.dependent in dict(later.working) for later in steps[place + 1 :])
        whole = dict(step.working)
        for row, factor in step.factors:
            for number, entry in working[row].items():
                whole[number] = dag.add(whole.get(number, dag.zero), dag.mul(factor, entry))
        for number in whole | rows[step.row]:
            entries = (whole.get(number, dag.zero), rows[step.row].get(number, dag.zero))
            assert fingerprints.equal(*entries)
    return steps


def test_a_chain_keeps_its_moduli() -> None:
    dag = Dag()
    moduli = [dag.symbol(Kind.STATE, k) for k in range(5)]
    rows = [{k: dag.neg(modulus), k + 1: dag.one} for k, modulus in enumerate(moduli)]
    steps = check(dag, rows, [1, 2, 3, 4, 5])
    assert all(not step.factors for step in steps)
    assert [step.dependent for step in steps] == [5, 4, 3, 2, 1]


def test_a_loop_is_eliminated() -> None:
    """Two rows that each hold both dependent classes, before and after them a row each."""
    dag = Dag()
    one, two = dag.one, dag.const(2)
    turn = dag.symbol(Kind.STATE, 0)
    rows = [
        {0: turn, 1: one},
        {1: turn, 2: one, 3: one},
        {2: one, 3: two},
        {3: turn, 4: one},
    ]
    steps = check(dag, rows, [1, 2, 3, 4])
    assert [bool(step.factors) for step in steps].count(True) == 1


def test_what_cannot_be_divided_by_leaves_the_steps_as_they_were() -> None:
    dag = Dag()
    turns = [dag.symbol(Kind.STATE, k) for k in range(4)]
    rows = [{0: dag.one, 1: turns[0], 2: turns[1]}, {0: dag.one, 1: turns[2], 2: turns[3]}]
    steps = sequenced(dag, rows, [1, 2])
    assert [step.working for step in steps] == [(), ()]


@settings(max_examples=60, deadline=None)
@given(st.randoms(use_true_random=False), st.integers(1, 8), st.integers(1, 3))
def test_steps_are_as_promised(rng, size: int, free: int) -> None:
    """Rows that are triangular once shuffled, with a few entries above the diagonal."""
    dag = Dag()
    rows = []
    for k in range(size):
        row = {free + k: dag.const(rng.choice([1, -1, 2]))}
        for other in range(free + k):
            if rng.random() < 0.4:
                row[other] = dag.symbol(Kind.STATE, rng.randrange(6))
        if k + 1 < size and rng.random() < 0.2:
            row[free + k + 1] = dag.const(rng.choice([3, 5]))
        rows.append(row)
    order = list(range(size))
    rng.shuffle(order)
    steps = sequenced(dag, [rows[k] for k in order], [free + k for k in order])
    if any(step.working for step in steps):
        check(dag, [rows[k] for k in order], [free + k for k in order])
