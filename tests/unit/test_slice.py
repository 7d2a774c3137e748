"""Slicing keeps what is read, and only that."""

from __future__ import annotations

from graphs import GraphBuilder, causal_of, rlc

from bgc.algebra.dag import Kind
from bgc.equations.derive import derive_equations
from bgc.ir.program import Dropped, Program, Reason
from bgc.slicing.slice import slice_program


def program_of(g: GraphBuilder) -> Program:
    return derive_equations(causal_of(g.build()))


def cascade() -> GraphBuilder:
    g = GraphBuilder()
    for k in (1, 2):
        g.source("Se", f"s{k}", g.node(1) if k == 1 else g.q("c1"))
        g.junction("J1", f"j{k}")
        g.resistor(f"r{k}", 1)
        g.param(f"C{k}", 1)
        g.storage("C", f"c{k}", f"C{k}")
        g.bond(f"s{k}", f"j{k}")
        g.fan(f"j{k}", f"r{k}", f"c{k}")
    return g


def names(program: Program) -> list[str]:
    return [state.name for state in program.states]


def test_a_state_that_reaches_no_output_is_dropped() -> None:
    g = cascade()
    g.observe("first", g.q("c1"))
    program = slice_program(program_of(g))
    assert names(program) == ["c1.q"]
    assert program.dropped == (Dropped("c2.q", Reason.UNREAD),)
    assert [p.message for p in program.positive] == ["the compliance of `c1` must be positive"]


def test_what_an_output_depends_on_by_way_of_others_is_kept() -> None:
    g = cascade()
    g.observe("second", g.q("c2"))
    assert names(slice_program(program_of(g))) == ["c1.q", "c2.q"]


def test_states_are_renumbered() -> None:
    g = GraphBuilder()
    x = g.state("x", 1)
    y = g.state("y", 2)
    g.derivative(x, g.dag.one)
    g.derivative(y, g.dag.neg(y))
    g.observe("y", y)
    program = slice_program(program_of(g))
    assert names(program) == ["y"]
    first = program.dag.symbol(Kind.STATE, 0)
    assert program.observations[0].node == first
    assert program.states[0].derivative == program.dag.neg(first)


def test_kept_names_and_accounts_count() -> None:
    g = cascade()
    g.observe("first", g.q("c1"))
    g.kept = ("c2",)
    assert names(slice_program(program_of(g))) == ["c1.q", "c2.q"]
    g.kept = ()
    g.accounts = ("residual",)
    assert names(slice_program(program_of(g))) == ["c1.q", "c2.q"]


def test_a_scene_that_reads_nothing_keeps_everything() -> None:
    assert names(slice_program(program_of(rlc()))) == ["coil.p", "capacitor.q"]
