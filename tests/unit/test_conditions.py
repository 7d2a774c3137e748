"""Conditions on initial values: which rows a contradiction names."""

import random

from bgc.equations.storage.conditions import Answer, Condition, System


def condition(k: int) -> Condition:
    return Condition({}, 0, f"part{k}", None)


def test_a_contradiction_names_each_condition_behind_it_once():
    """Each row is reduced by all before it, so that lists of their conditions would double."""
    rng, size, system = random.Random(1), 40, System()
    rows = [[rng.uniform(1, 2) for _ in range(size + 1)] for _ in range(size)]
    conditions = [condition(k) for k in range(size + 1)]
    for row, each in zip(rows, conditions, strict=False):
        assert system.insert(row, each) is Answer.ADDS
    total = [sum(column) for column in zip(*rows, strict=True)]
    assert system.insert(total, conditions[-1]) is Answer.FOLLOWS
    total[-1] += 1
    assert system.insert(total, conditions[-1]) is Answer.CONTRADICTS
    assert system.behind == conditions[:-1]


def test_a_contradiction_leaves_out_what_has_no_part_in_it():
    system = System()
    first, other, third = (condition(k) for k in range(3))
    assert system.insert([1.0, 0.0, 0.0, 2.0], first) is Answer.ADDS
    assert system.insert([0.0, 1.0, 0.0, 5.0], other) is Answer.ADDS
    assert system.insert([2.0, 0.0, 0.0, 5.0], third) is Answer.CONTRADICTS
    assert system.behind == [first]
