"""Equations: right on textbook circuits, on merged storage, loops and random graphs."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import pytest
from dense import evaluate_at_random, largest_misfit, observe_everything
from graphs import GraphBuilder, causal_of, drawn, rlc
from joints import chain_of_bodies
from refusals import codes_of
from test_causality import chain, pendulum

from bgc.algebra.dag import Kind, Op, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.infix import infix_lines
from bgc.equations.derive import derive_equations
from bgc.ir.graph import EnergyLaw, ExplicitLaw, Form, Node
from bgc.ir.program import MassEntry, Program


def program_of(g: GraphBuilder) -> Program:
    return derive_equations(causal_of(g.build()))


def text(program: Program) -> list[str]:
    def name(symbol: Symbol) -> str:
        if symbol.kind is Kind.STATE:
            return program.states[symbol.index].name
        if symbol.kind is Kind.PARAM:
            return program.parameters[symbol.index].name
        return f"{symbol.kind.name.lower()}{symbol.index}"

    rates = [(f"{s.name}'", s.derivative) for s in program.states]
    return infix_lines(program.dag, rates, name)


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


def test_series_circuit() -> None:
    g = rlc(2, 1, 4)
    assert text(program_of(g)) == [
        "coil.p' = 1 - 0.25 * capacitor.q - 2 * coil.p",
        "capacitor.q' = coil.p",
    ]
    assert_solves_everything(g)


def test_parallel_circuit() -> None:
    g = drawn(
        "node : J0; coil : I(1, p0=1); capacitor : C(1, q0=1); resistor : R(1); "
        "node -> coil, capacitor, resistor"
    )
    program = program_of(g)
    assert text(program) == [
        "coil.p' = capacitor.q",
        "capacitor.q' = -(capacitor.q + coil.p)",
    ]
    assert initials(program) == {"coil.p": 1, "capacitor.q": 1}


def test_motor_with_a_gyrator() -> None:
    g = GraphBuilder()
    for name, value in {"L": 0.5, "R": 1, "k": 0.01, "J": 0.01, "b": 0.1}.items():
        g.param(name, value)
    g.draw(
        "supply : Se(1); winding, shaft : J1; coil : I(L); wire : R(R); motor : GY(k); "
        "rotor : I(J); bearing : R(b); supply -> winding -> coil, wire, motor; "
        "motor -> shaft -> rotor, bearing"
    )
    program = assert_solves_everything(g)
    assert [(s.name, s.kind) for s in program.states] == [
        ("coil.p", "momentum"),
        ("rotor.p", "momentum"),
    ]
    assert {p.message for p in program.positive} == {
        "the inertia of `coil` must be positive",
        "the inertia of `rotor` must be positive",
    }


# --- merged storage ---------------------------------------------------------------------------


def two_masses(**initial: float) -> GraphBuilder:
    g = drawn("force : Se(1); body : J1")
    g.storage("I", "m2", 2, **({"f0": initial["f0"]} if "f0" in initial else {}))
    g.storage("I", "m3", 3, **({"p0": initial["p0"]} if "p0" in initial else {}))
    g.draw("drag : R(1); force -> body -> m2, m3, drag")
    return g


def test_masses_on_one_junction_are_one_momentum() -> None:
    g = two_masses()
    program = assert_solves_everything(g)
    assert [s.name for s in program.states] == ["body.p"]
    assert text(program) == ["body.p' = 1 - body.p / 5"]


def test_initial_values_of_merged_masses_follow_what_is_given() -> None:
    assert initials(program_of(two_masses())) == {"body.p": 0}
    assert initials(program_of(two_masses(f0=2))) == {"body.p": 10}
    assert initials(program_of(two_masses(p0=6))) == {"body.p": 10}
    assert initials(program_of(two_masses(f0=2, p0=6))) == {"body.p": 10}
    assert codes_of(program_of, two_masses(f0=2, p0=7)) == ["BG516"]


def test_capacitors_in_parallel_share_their_charge() -> None:
    g = drawn("node : J0; c1 : C(1, e0=3); c2 : C(2); leak : R(1); node -> c1, c2, leak")
    program = assert_solves_everything(g)
    assert len(program.states) == 1
    assert initials(program) == {program.states[0].name: 9}


def test_pendulum_of_a_mass_behind_a_modulated_transformer() -> None:
    g = GraphBuilder()
    angle = g.state("theta", 0.5)
    g.derivative(angle, g.flow(0))
    pendulum(g.dag.call(Op.COS, angle), g)
    program = assert_solves_everything(g)
    assert [s.name for s in program.states] == ["angle.p", "theta"]


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(("rigid", "states"), [(True, 5 + 2), (False, 9 + 2 + 4)])
def test_bodies_on_joints(rigid: bool, states: int, reverse: bool) -> None:
    g = chain_of_bodies(3, rigid=rigid, reverse=reverse)
    g.accounts = ("residual",)
    program = assert_solves_everything(g)
    assert len(program.states) == states
    assert program.positive == ()
    assert abs(energy_defect(program)) < 1e-6


def test_inertias_that_do_not_add_up_to_a_regular_mass_are_refused() -> None:
    """One mass behind two modulated transformers: its momentum does not determine both flows."""
    g = GraphBuilder()
    angle = g.state("angle", 0.5)
    g.derivative(angle, g.node(1))
    g.draw("sum : J0; mass : I(1); sum -> mass")
    for k, op in enumerate((Op.SIN, Op.COS)):
        g.junction("J1", f"arm{k}")
        g.source("Se", f"push{k}", g.node(1))
        g.transformer(f"lever{k}", ((g.dag.call(op, angle),),))
        g.bond(f"push{k}", f"arm{k}")
        g.bond(f"arm{k}", f"lever{k}")
        g.bond(f"lever{k}", "sum")
    assert codes_of(program_of, g) == ["BG513"]


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


def test_a_linear_loop_of_resistors_is_solved() -> None:
    g = drawn(
        "supply : Se(1); left, right : J1; node : J0; r1 : R(2); r2 : R(3); r3 : R(4); c : C(1); "
        "supply -> left -> r1, node; node -> r2, right; right -> r3, c"
    )
    assert assert_solves_everything(g).mass is None


def diode(g: GraphBuilder) -> None:
    """A diode between a resistor and a capacitor: its current is only known implicitly."""
    g.draw("supply : Se(1); loop : J1; wire : R(1)")
    current = g.dag.sub(g.dag.call(Op.EXP, g.effort(2)), g.dag.one)
    g.resistor("diode", ExplicitLaw(Form.FLOW, (current,)))
    g.draw("c : C(1); supply -> loop -> wire, diode, c")


def test_a_nonlinear_loop_becomes_algebraic_states() -> None:
    g = GraphBuilder()
    diode(g)
    program = program_of(g)
    kinds = [s.kind for s in program.states]
    assert kinds[0] == "displacement"
    assert set(kinds[1:]) == {"algebraic"}
    assert program.mass == (MassEntry(0, 0, program.dag.one),)


def test_a_source_that_follows_its_own_flow_is_a_resistance() -> None:
    g = GraphBuilder()
    g.source("Se", "drop", g.dag.mul(g.node(-2), g.flow(0)))
    g.draw("loop : J1; c : C(1); drop -> loop -> c")
    program = assert_solves_everything(g)
    assert text(program) == ["c.q' = -(c.q / 2)"]


def test_a_feedback_that_cancels_a_resistance_has_no_solution() -> None:
    g = GraphBuilder()
    g.source("Se", "boost", g.dag.mul(g.node(2), g.flow(0)))
    g.draw("loop : J1; r : R(2); c : C(1); boost -> loop -> r, c")
    assert codes_of(program_of, g) == ["BG520"]


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


def test_an_energy_gives_the_law() -> None:
    program = program_of(duffing())
    values = {Symbol(Kind.STATE, 0): 0.5, Symbol(Kind.STATE, 1): 2.0}
    rates = evaluate_nodes(program.dag, [s.derivative for s in program.states], values)
    assert rates == pytest.approx([2.0, -(0.5 + 0.125)])


def test_an_energy_of_momentum_and_charge_is_an_ic_field() -> None:
    """A pendulum with its angle as charge: H = p^2/(2 m(q)) + cos q."""
    g = GraphBuilder()
    q, p = g.next_state(Kind.DISPLACEMENT), g.next_state(Kind.MOMENTUM)
    mass = g.dag.add(g.node(2), g.dag.call(Op.SIN, q))
    energy = g.dag.add(
        g.dag.div(g.dag.mul(p, p), g.dag.mul(g.node(2), mass)), g.dag.call(Op.COS, q)
    )
    g.storage("IC", "arm", EnergyLaw(energy), q0=1, p0=2)
    g.draw("joint : J1; friction : R(3); joint -> arm, friction")
    program = program_of(g)
    assert [s.name for s in program.states] == ["arm.p", "arm.q"]
    at = {Symbol(Kind.STATE, 0): 2.0, Symbol(Kind.STATE, 1): 1.0}
    rates = evaluate_nodes(program.dag, [s.derivative for s in program.states], at)
    m, dm = 2 + math.sin(1), math.cos(1)
    flow = 2 / m
    assert rates == pytest.approx([-3 * flow + 2 * dm / m**2 + math.sin(1), flow])


def test_a_law_may_not_hold_a_foreign_variable() -> None:
    g = rlc()
    law = ExplicitLaw(Form.EFFORT, (g.dag.mul(g.flow(1), g.next_state(Kind.DISPLACEMENT)),))
    g.storage("C", "odd", law)
    g.bond("loop", "odd")
    assert codes_of(program_of, g) == ["BG510"]


def test_a_massless_inertia_is_refused() -> None:
    assert codes_of(program_of, rlc(l=0)) == ["BG511"]


def test_efforts_and_flows_at_the_start_are_converted() -> None:
    g = GraphBuilder()
    g.junction("J1", "body")
    g.storage("C", "spring", [[4]], Form.EFFORT, e0=8)
    g.draw("mass : I(3, f0=2); body -> spring, mass")
    assert initials(program_of(g)) == {"spring.q": 2, "mass.p": 6}


def test_an_initial_effort_of_a_nonlinear_spring_is_converted() -> None:
    g = GraphBuilder()
    g.junction("J1", "body")
    q = g.next_state(Kind.DISPLACEMENT)
    g.storage("C", "spring", ExplicitLaw(Form.EFFORT, (g.dag.mul(q, g.dag.mul(q, q)),)), e0=8)
    g.draw("mass : I(1); body -> spring, mass")
    assert initials(program_of(g))["spring.q"] == pytest.approx(2, rel=1e-14)


# --- plain equations --------------------------------------------------------------------------


def test_declared_states_and_equations() -> None:
    """x' = z, 0 = x + z - 1, and 2 x' + y' = -y as a row of the mass matrix."""
    g = GraphBuilder()
    x, y = g.state("x", 1), g.state("y", 2)
    z = g.unknown("z", 5)
    dag = g.dag
    g.derivative(x, z)
    g.equation(dag.sub(dag.add(x, z), dag.one))
    g.equation(dag.add(dag.mul(g.node(2), g.rate(y)), y))
    program = program_of(g)
    assert [(s.name, s.kind) for s in program.states] == [
        ("x", "declared"),
        ("y", "declared"),
        ("z", "algebraic"),
    ]
    assert program.mass == (MassEntry(0, 0, dag.one), MassEntry(1, 1, dag.const(2)))
    assert initials(program) == {"x": 1, "y": 2, "z": 5}


def test_equations_must_hold_their_unknowns() -> None:
    g = GraphBuilder()
    z, w = g.unknown("z"), g.unknown("w")
    g.equation(g.dag.sub(z, g.dag.one))
    g.equation(g.dag.sub(z, g.dag.const(2)))
    assert w
    assert codes_of(program_of, g) == ["BG531"]


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
