"""Equations: right on textbook circuits, on merged storage, loops and random graphs."""

from __future__ import annotations

import time
from dataclasses import replace

import pytest
from dense import evaluate_at_random, largest_misfit, observe_everything
from graphs import GraphBuilder, causal_of, drawn, rlc
from refusals import codes_of
from test_causality import chain

from bgc.algebra.dag import Kind, Op, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.equations.derive import derive_equations
from bgc.ir.graph import EnergyLaw, ExplicitLaw, Form, Node
from bgc.ir.program import Program


def program_of(g: GraphBuilder) -> Program:
    return derive_equations(causal_of(g.build()))


def initials(program: Program) -> dict[str, float]:
    values = evaluate_nodes(program.dag, [s.initial for s in program.states], {})
    return {s.name: v for s, v in zip(program.states, values, strict=True)}


def assert_solves_everything(g: GraphBuilder) -> Program:
    observe_everything(g)
    graph = g.build()
    program = derive_equations(causal_of(graph))
    for seed in (1, 2):
        assert largest_misfit(graph, evaluate_at_random(program, seed)) < 1e-9
    return program


def energy_defect(program: Program) -> float:
    """d stored/dt - supplied + dissipated at a random state, by central differences."""
    dag = program.dag
    states = [Symbol(Kind.STATE, k) for k in range(len(program.states))]
    at = {s: 0.3 + 0.1 * s.index for s in states} | {Symbol(Kind.TIME, 0): 0.0}
    rates = evaluate_nodes(dag, [s.derivative for s in program.states], at)
    e = program.energy
    supplied, dissipated = evaluate_nodes(dag, [e.supplied, e.dissipated], at)

    def stored(h: float) -> float:
        moved = {s: at[s] + h * v for s, v in zip(states, rates, strict=True)}
        moved[Symbol(Kind.TIME, 0)] = h
        return evaluate_nodes(dag, [e.stored], moved)[0]

    return (stored(1e-5) - stored(-1e-5)) / 2e-5 - supplied + dissipated


# --- textbook ---------------------------------------------------------------------------------


# --- merged storage ---------------------------------------------------------------------------


def two_masses(**initial: float) -> GraphBuilder:
    g = drawn("force : Se(1); body : J1")
    g.storage("I", "m2", 2, **({"f0": initial["f0"]} if "f0" in initial else {}))
    g.storage("I", "m3", 3, **({"p0": initial["p0"]} if "p0" in initial else {}))
    g.draw("drag : R(1); force -> body -> m2, m3, drag")
    return g


def test_initial_values_of_merged_masses_follow_what_is_given() -> None:
    assert initials(program_of(two_masses())) == {"body.p": 0}
    assert initials(program_of(two_masses(f0=2))) == {"body.p": 10}
    assert initials(program_of(two_masses(p0=6))) == {"body.p": 10}
    assert initials(program_of(two_masses(f0=2, p0=6))) == {"body.p": 10}
    assert codes_of(program_of, two_masses(f0=2, p0=7)) == ["BG516"]


def test_a_source_on_a_mass_needs_its_rate_only_where_it_is_read() -> None:
    g = GraphBuilder()
    g.source("Sf", "drive", g.dag.call(Op.SIN, g.dag.symbol(Kind.TIME)))
    g.draw("body : J1; mass : I(2); drive -> body -> mass")
    program = assert_solves_everything(g)
    assert program.states == ()


def test_the_rate_of_a_device_is_not_known() -> None:
    g = GraphBuilder()
    g.source("Sf", "drive", g.dag.symbol(Kind.INPUT))
    g.draw("body : J1; mass : I(2); drive -> body -> mass")
    assert program_of(g).states == ()
    g.observe("force", g.effort(0))
    assert codes_of(program_of, g) == ["BG522"]


# --- loops ------------------------------------------------------------------------------------


# --- laws -------------------------------------------------------------------------------------


def duffing() -> GraphBuilder:
    g = GraphBuilder()
    g.junction("J1", "body")
    q = g.next_state(Kind.DISPLACEMENT)
    square = g.dag.mul(q, q)
    half, quarter = g.node(0.5), g.node(0.25)
    energy = g.dag.add(g.dag.mul(half, square), g.dag.mul(quarter, g.dag.mul(square, square)))
    g.storage("C", "spring", EnergyLaw(energy), q0=1)
    g.draw("mass : I(1); body -> spring, mass")
    return g


def test_a_law_may_not_hold_a_foreign_variable() -> None:
    g = rlc()
    law = ExplicitLaw(Form.EFFORT, (g.dag.mul(g.flow(1), g.next_state(Kind.DISPLACEMENT)),))
    g.storage("C", "odd", law)
    g.bond("loop", "odd")
    assert codes_of(program_of, g) == ["BG510"]


def test_an_initial_effort_of_a_nonlinear_spring_is_converted() -> None:
    g = GraphBuilder()
    g.junction("J1", "body")
    q = g.next_state(Kind.DISPLACEMENT)
    g.storage("C", "spring", ExplicitLaw(Form.EFFORT, (g.dag.mul(q, g.dag.mul(q, q)),)), e0=8)
    g.draw("mass : I(1); body -> spring, mass")
    assert initials(program_of(g))["spring.q"] == pytest.approx(2, rel=1e-14)


# --- plain equations --------------------------------------------------------------------------


def test_initial_values_may_depend_on_each_other_but_not_in_a_circle() -> None:
    g = GraphBuilder()
    x = g.state("x", 2)
    index = len(g.states)
    g.state("y", 0)
    g.states[index] = type(g.states[index])(
        index, "y", "", g.dag.mul(x, g.dag.const(3)), g.dag.one, None, g.states[0].span
    )
    g.derivative(x, g.dag.one)
    assert initials(program_of(g)) == {"x": 2, "y": 6}
    y = g.dag.symbol(Kind.STATE, index)
    g.states[0] = replace(g.states[0], initial=g.dag.add(y, g.dag.one))
    assert codes_of(program_of, g) == ["BG532"]


# --- scales -----------------------------------------------------------------------------------


def test_scales_weigh_charges_by_the_energy_of_the_inertia_beside_them() -> None:
    g = rlc(2, 4, 9)
    program = program_of(g)
    scales = evaluate_nodes(program.dag, [s.scale for s in program.states], {})
    assert scales == [4, pytest.approx(6)]


# --- size -------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1000])
def test_long_chains_are_derived_in_about_a_second(size: int) -> None:
    g = GraphBuilder()
    chain(g, size)
    causal = causal_of(g.build())
    start = time.process_time()
    program = derive_equations(causal)
    assert time.process_time() - start < 2
    assert len(program.states) == 2 * size


def node_count(program: Program, roots: list[Node]) -> int:
    return len(program.dag.reachable(roots))


def test_a_ladder_of_resistors_stays_sparse() -> None:
    g = GraphBuilder()
    size = 60
    for k in range(size):
        g.junction("J1", f"a{k}")
        g.junction("J0", f"b{k}")
        g.resistor(f"r{k}", k + 1)
        g.resistor(f"s{k}", 2)
        g.bond(f"a{k}", f"r{k}")
        g.bond(f"b{k}", f"s{k}")
        g.bond(f"a{k}", f"b{k}")
        if k:
            g.bond(f"b{k - 1}", f"a{k}")
    g.draw("supply : Se(1); supply -> a0; c : C(1)")
    g.bond(f"b{size - 1}", "c")
    program = program_of(g)
    assert node_count(program, [s.derivative for s in program.states]) < 20 * size


def test_a_parameter_that_a_loop_divides_by_is_watched() -> None:
    g = GraphBuilder()
    g.param("G", 2)
    g.source("Sf", "drive", g.node(1))
    g.resistor("leak", "G", Form.FLOW)
    g.bond("drive", "leak")
    g.observe("e", g.effort(0))
    program = program_of(g)
    assert [p.message for p in program.positive] == ["the algebraic loop at `leak.e` is singular"]
