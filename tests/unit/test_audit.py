"""The power balance that every program is checked for."""

from dataclasses import replace

import pytest
from graphs import rlc

from bgc.causality.assign import assign_causality
from bgc.equations.audit import assert_power_balance, power_defect
from bgc.equations.derive import derive_equations


@pytest.fixture
def program():
    graph = rlc().build()
    accounts = ("stored", "supplied", "dissipated")
    return derive_equations(
        assign_causality(replace(graph, scene=replace(graph.scene, accounts=accounts)))
    )


def test_derived_equations_keep_it(program):
    assert power_defect(program) < 1e-12


@pytest.mark.parametrize("which", [0, 1])
def test_a_sign_slipped_in_one_equation_is_a_bug_of_ours(program, which):
    states = list(program.states)
    slipped = program.dag.neg(states[which].derivative)
    states[which] = replace(states[which], derivative=slipped)
    with pytest.raises(AssertionError, match="power balance broken"):
        assert_power_balance(replace(program, states=tuple(states)))
