"""The energy accounts of derived equations: what is stored, supplied and dissipated agrees."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from graphs import GraphBuilder, rlc
from test_equations import duffing, energy_defect, program_of, two_masses

from bgc.algebra.dag import Kind, Op
from bgc.ir.graph import ExplicitLaw, Form


@pytest.mark.parametrize("make", [rlc, two_masses, duffing])
def test_energy_is_kept_in_the_books(make: Callable[[], GraphBuilder]) -> None:
    g = make()
    g.accounts = ("residual",)
    assert abs(energy_defect(program_of(g))) < 1e-8


def test_a_field_that_is_no_energy_is_accounted_by_its_power() -> None:
    g = GraphBuilder()
    g.accounts = ("stored",)
    g.junction("J1", "x", "y")
    g.storage("C", "odd", [[2, 1], [0, 2]], Form.EFFORT)
    for name in ("x", "y"):
        g.storage("I", f"mass.{name}", 1)
        g.bond(name, "odd")
        g.bond(name, f"mass.{name}")
    program = program_of(g)
    assert program.states[-1].name == "odd.energy"
    assert abs(energy_defect(program)) < 1e-8


def test_energy_without_a_closed_form_is_integrated() -> None:
    g = GraphBuilder()
    g.accounts = ("stored",)
    g.junction("J1", "body")
    q = g.next_state(Kind.DISPLACEMENT)
    g.storage("C", "spring", ExplicitLaw(Form.EFFORT, (g.dag.call(Op.SINH, q),)))
    g.draw("mass : I(1); body -> spring, mass")
    program = program_of(g)
    assert [s.name for s in program.states] == ["spring.q", "mass.p", "spring.energy"]
    assert abs(energy_defect(program)) < 1e-8


def test_the_energy_of_a_piecewise_law_is_found() -> None:
    g = GraphBuilder()
    g.accounts = ("stored",)
    g.junction("J1", "body")
    q = g.next_state(Kind.DISPLACEMENT)
    force = g.dag.add(g.dag.mul(g.node(2), q), g.dag.mul(g.dag.call(Op.ABS, q), q))
    g.storage("C", "spring", ExplicitLaw(Form.EFFORT, (force,)))
    g.draw("mass : I(1); body -> spring, mass")
    program = program_of(g)
    assert len(program.states) == 2
    assert abs(energy_defect(program)) < 1e-8
