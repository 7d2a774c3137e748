"""Free motions: what odd gyrator loops and compliances alone leave open, and what keeps them."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from dense import (
    evaluate_at_random,
    largest_misfit,
    observe_everything,
    pencil_degree,
    power_imbalance,
)
from graphs import GraphBuilder, causal_of, drawn
from hypothesis import example, given, settings
from hypothesis import strategies as st
from random_graphs import random_graph
from refusals import codes_of, refusal
from test_equations import assert_solves_everything, energy_defect, initials, program_of

from bgc.algebra.dag import Kind, Op, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.derive import derive_equations
from bgc.ir.graph import EnergyLaw, ExplicitLaw, Form, Node


def ring(
    g: GraphBuilder, kinds: str, moduli: tuple[Node, Node, Node], **initial: float
) -> GraphBuilder:
    """Three elements on a ring of three gyrators, whose regions no two colours fit.

    Their values are 2, 3 and 4; `f01=5` gives element 1 the initial flow 5.
    """
    for k, kind in enumerate(kinds):
        g.junction("J1", f"n{k}")
        start = {key[:2]: value for key, value in initial.items() if key[2:] == str(k)}
        if kind in "CI":
            g.storage(kind, f"{kind}{k}", k + 2, **start)
        elif kind == "R":
            g.resistor(f"R{k}", k + 2)
        else:
            g.source("Se", f"{kind}{k}", g.node(k + 2))
        g.bond(f"n{k}", f"{kind}{k}")
    for k, modulus in enumerate(moduli):
        g.gyrator(f"g{k}", ((modulus,),))
        g.bond(f"n{k}", f"g{k}")
        g.bond(f"g{k}", f"n{(k + 1) % 3}")
    return g


def constant_ring(kinds: str, **initial: float) -> GraphBuilder:
    g = GraphBuilder()
    return ring(g, kinds, (g.node(2), g.node(3), g.node(5)), **initial)


# --- odd loops of gyrators ----------------------------------------------------------------------


def test_storage_that_a_ring_joins_is_named_by_what_it_is_merged_from() -> None:
    program = program_of(constant_ring("CCC"))
    assert [s.name for s in program.states] == ["C0.merged.q", "C2.merged.q"]


def test_a_ring_without_storage_on_its_free_motion_is_refused_by_its_gyrators() -> None:
    diagnostic = refusal(lambda: program_of(constant_ring("EEE")))
    assert diagnostic.code in {"BG508", "BG523"}


def test_a_modulus_of_a_ring_may_vanish_where_another_is_certain() -> None:
    """Two of its moduli vanish at an angle of 0, where the equations stay as good as elsewhere."""
    g = GraphBuilder()
    angle = g.state("angle", 0.5)
    turning = g.dag.call(Op.SIN, angle)
    ring(g, "CCC", (g.node(3), turning, turning))
    g.derivative(angle, g.dag.one)
    g.accounts = ("residual",)
    program = assert_solves_everything(g)
    assert len(program.states) == 2 + 1
    assert abs(energy_defect(program)) < 1e-6
    at_zero = {Symbol(Kind.STATE, k): x for k, x in enumerate([0.3, -0.2, 0.0])}
    values = evaluate_nodes(program.dag, [s.derivative for s in program.states], at_zero)
    assert all(map(math.isfinite, values))


def test_a_ring_all_of_whose_moduli_may_vanish_is_refused() -> None:
    g = GraphBuilder()
    angle = g.state("angle", 0.5)
    g.derivative(angle, g.node(1))
    turning = [g.dag.call(op, angle) for op in (Op.SIN, Op.COS, Op.TANH)]
    ring(g, "CCC", (turning[0], turning[1], turning[2]))
    assert codes_of(program_of, g) == ["BG513"]


NEARLY_ALIKE = "a : J1; b : J1; x : J0; y : J0; n : J1; m : J1; push : Se(1); hold : Se(2)"


def springs_side_by_side(*stiffness: float | list[list[int]]) -> GraphBuilder:
    """Springs, the last perhaps a field of two, on one effort, with a leak."""
    g = drawn("node : J0; leak : R(1); node -> leak")
    for k, value in enumerate(stiffness):
        rows = value if isinstance(value, list) else [[value]]
        g.storage("C", f"c{k}", rows, Form.EFFORT)  # type: ignore[arg-type]
        for _ in rows:
            g.bond("node", f"c{k}")
    return g


def test_a_field_that_cancels_itself_is_refused_without_naming_it_twice() -> None:
    diagnostic = refusal(program_of, springs_side_by_side([[1, 0], [0, -1]]))
    assert diagnostic.code == "BG512"
    assert diagnostic.message.startswith("the storage of `c0` is not independent")


def test_only_linear_inertias_must_resist_each_motion_well() -> None:
    """Two flows that move both inertias nearly alike: the small difference is not rounding."""
    linear, nonlinear = drawn(NEARLY_ALIKE), drawn(NEARLY_ALIKE)
    for g in (linear, nonlinear):
        g.transformer("t", ((g.dag.const(Fraction(100001, 100000)),),))
        for k, node in enumerate("nm"):
            if g is linear:
                g.storage("I", f"i{k}", 1)
            else:
                cubic(g, "I", f"i{k}", 1)
            g.bond(node, f"i{k}")
        g.draw("push -> a; hold -> b; a -> x; b -> x; a -> y; b -> t; t -> y; x -> n; y -> m")
    assert codes_of(program_of, linear) == ["BG513"]
    assert [s.kind for s in program_of(nonlinear).states][:2] == ["momentum"] * 2


@pytest.mark.parametrize("springs", [1, 2])
def test_a_lever_that_only_moduli_hold_is_refused(springs: int) -> None:
    """Its speed is undetermined where all its moduli vanish."""
    g = GraphBuilder()
    angle = g.state("angle", 0.5)
    g.derivative(angle, g.dag.one)
    g.draw("push : Se(3); lever : J1; push -> lever")
    for k in range(springs):
        g.transformer(f"t{k}", ((g.dag.call((Op.SIN, Op.COS)[k], angle),),))
        g.storage("C", f"spring{k}", k + 2)
        g.bond("lever", f"t{k}")
        g.bond(f"t{k}", f"spring{k}")
    diagnostic = refusal(program_of, g)
    assert diagnostic.code == "BG512"
    assert "`spring0`" in diagnostic.message and "may become zero" in diagnostic.message


def cubic(g: GraphBuilder, kind: str, name: str, slope: int) -> None:
    """A C or I that answers with `slope x + x^3`."""
    x = g.next_state(Kind.DISPLACEMENT if kind == "C" else Kind.MOMENTUM)
    node = g.dag.add(g.dag.mul(g.node(slope), x), g.dag.mul(x, g.dag.mul(x, x)))
    g.storage(kind, name, ExplicitLaw(Form.EFFORT if kind == "C" else Form.FLOW, (node,)))


def test_a_ring_of_cubic_capacitors_is_solved_by_iteration() -> None:
    """Their flows too, which follow from how fast the unknown of the iteration changes."""
    g = GraphBuilder()
    for k in range(3):
        g.junction("J1", f"n{k}")
        cubic(g, "C", f"C{k}", k + 1)
        g.bond(f"n{k}", f"C{k}")
    for k in range(3):
        g.gyrator(f"g{k}", k + 2)
        g.bond(f"n{k}", f"g{k}")
        g.bond(f"g{k}", f"n{(k + 1) % 3}")
    program = assert_solves_everything(g)
    assert [s.kind for s in program.states] == ["displacement"] * 2 + ["algebraic"]


@pytest.mark.parametrize("kind", ["C", "I"])
def test_cubic_storage_in_parallel_is_merged_and_its_rates_are_known(kind: str) -> None:
    g = GraphBuilder()
    g.junction("J0" if kind == "C" else "J1", "node")
    for k in range(2):
        cubic(g, kind, f"x{k}", k + 1)
        g.bond("node", f"x{k}")
    g.draw("leak : R(1); node -> leak")
    program = assert_solves_everything(g)
    assert [s.name for s in program.states if s.kind != "algebraic"] == [
        "node.q" if kind == "C" else "node.p"
    ]


def test_a_dependent_inertia_that_is_not_symmetric_is_refused() -> None:
    g = GraphBuilder()
    g.junction("J1", "body")
    g.storage("I", "odd", [[2, 1], [0, 3]])
    g.draw("mass : I(1); body -> odd, odd, mass")
    diagnostic = refusal(program_of, g)
    assert diagnostic.code == "BG512"
    assert diagnostic.message.endswith("the inertia of `odd` is not symmetric")


# --- initial values -----------------------------------------------------------------------------


def at_start(g: GraphBuilder, *nodes: Node) -> list[float]:
    """The values of nodes at the start."""
    for k, node in enumerate(nodes):
        g.observe(f"o{k}", node)
    program = program_of(g)
    start = evaluate_nodes(program.dag, [s.initial for s in program.states], {})
    at = {Symbol(Kind.STATE, k): x for k, x in enumerate(start)}
    return evaluate_nodes(program.dag, [o.node for o in program.observations], at)


@pytest.mark.parametrize(
    "given",
    [{}, {"q00": 2}, {"f01": 3}, {"p02": 5}, {"f01": 3, "f02": 4}, {"e00": 1, "f02": 1}],
    ids=str,
)
def test_initial_values_keep_the_balance_on_a_ring_of_one_c(given: dict[str, float]) -> None:
    """On n0: the effort of C0 and that of g0, 2 f of I1, against that of g2, 5 f of I2."""
    g = constant_ring("CII", **given)
    q, f1, f2 = at_start(g, g.q("C0"), g.flow(1), g.flow(2))
    assert q / 2 + 2 * f1 == pytest.approx(5 * f2, abs=1e-12)
    told = {"q00": q, "e00": q / 2, "f01": f1, "f02": f2, "p02": 4 * f2}
    assert {key: told[key] for key in given} == pytest.approx(given)


@pytest.mark.parametrize(
    "given", [{}, {"q00": 2}, {"e01": 1}, {"q01": 3, "q02": -1}, {"e00": 1, "q02": 2}], ids=str
)
def test_initial_values_keep_the_balance_on_a_ring_of_three_c(given: dict[str, float]) -> None:
    """With e0 = 5 f2 - 2 f1, e1 = 2 f0 - 3 f2, e2 = 3 f1 - 5 f0: 3 e0 + 5 e1 + 2 e2 = 0."""
    g = constant_ring("CCC", **given)
    q0, q1, q2 = at_start(g, g.q("C0"), g.q("C1"), g.q("C2"))
    e0, e1, e2 = q0 / 2, q1 / 3, q2 / 4
    assert 3 * e0 + 5 * e1 + 2 * e2 == pytest.approx(0, abs=1e-12)
    told = {"q00": q0, "e00": e0, "q01": q1, "e01": e1, "q02": q2}
    assert {key: told[key] for key in given} == pytest.approx(given)


@pytest.mark.parametrize(
    ("kinds", "given", "culprit"),
    [
        ("CII", {"q00": 2, "f01": 3, "f02": 4}, "`f0` of `I2`"),
        ("CCC", {"q00": 2, "q01": 3, "e02": 4}, "`e0` of `C2`"),
    ],
)
def test_initial_values_that_break_the_balance_name_the_culprit(
    kinds: str, given: dict[str, float], culprit: str
) -> None:
    diagnostic = refusal(lambda: program_of(constant_ring(kinds, **given)))
    assert diagnostic.code == "BG516"
    assert diagnostic.message.startswith(f"{culprit} contradicts the initial values of ")


def springs_in_parallel(**initial: float) -> GraphBuilder:
    """A cubic and a linear spring on one effort: q^3 = q / 2."""
    g = GraphBuilder()
    g.junction("J0", "node")
    q = g.next_state(Kind.DISPLACEMENT)
    cubic = ExplicitLaw(Form.EFFORT, (g.dag.mul(q, g.dag.mul(q, q)),))
    g.storage("C", "cubic", cubic, **({"q0": initial["cubic"]} if "cubic" in initial else {}))
    g.storage("C", "plain", 2, **({"q0": initial["plain"]} if "plain" in initial else {}))
    g.draw("leak : R(1); node -> cubic, plain, leak")
    return g


def test_joined_charges_of_laws_that_are_not_linear_follow_what_is_given() -> None:
    assert set(initials(program_of(springs_in_parallel())).values()) == {0}
    start = initials(program_of(springs_in_parallel(cubic=2, plain=16)))
    assert start["node.q"] == 18
    start = initials(program_of(springs_in_parallel(cubic=2)))
    assert start["node.q"] == pytest.approx(18, rel=1e-14)
    assert codes_of(program_of, springs_in_parallel(cubic=2, plain=10)) == ["BG516"]


# --- sources that prescribe what is stored ------------------------------------------------------


def prescribed(kind: str, value: str) -> GraphBuilder:
    """Two C beside an Se, or two I in series with an Sf: nothing of them is independent."""
    g = GraphBuilder()
    if value == "constant":
        node = g.node(3)
    elif value == "time":
        node = g.dag.call(Op.SIN, g.dag.symbol(Kind.TIME))
    elif value == "device":
        node = g.dag.symbol(Kind.INPUT)
    else:
        x = g.state("x", 0.5)
        g.derivative(x, g.dag.neg(x))
        node = g.dag.mul(x, x)
    g.source("Se" if kind == "C" else "Sf", "drive", node)
    g.junction("J0" if kind == "C" else "J1", "node")
    g.storage(kind, "one", 2)
    g.storage(kind, "two", 1)
    g.draw("drive -> node -> one, two")
    return g


@pytest.mark.parametrize("kind", ["C", "I"])
@pytest.mark.parametrize("value", ["constant", "time", "state"])
def test_what_a_source_bears_is_derived(kind: str, value: str) -> None:
    g = prescribed(kind, value)
    g.accounts = ("residual",)
    program = assert_solves_everything(g)
    assert len(program.states) == (1 if value == "state" else 0)
    assert abs(energy_defect(program)) < 1e-8


@pytest.mark.parametrize("kind", ["C", "I"])
def test_what_a_device_bears_is_refused_by_name_only_where_it_is_read(kind: str) -> None:
    g = prescribed(kind, "device")
    g.observe("stored", g.q("one") if kind == "C" else g.p("one"))
    assert program_of(g).states == ()
    g.observe("reaction", g.flow(0) if kind == "C" else g.effort(0))
    diagnostic = refusal(program_of, g)
    assert diagnostic.code == "BG522"
    assert "`one`" in diagnostic.message or "drive" in diagnostic.message


# --- IC fields ----------------------------------------------------------------------------------


def solenoid(g: GraphBuilder) -> None:
    """An IC whose first port stores by a momentum, the second by its charge: p^2/(2 L(q)) + q^2."""
    p, q = g.next_state(Kind.MOMENTUM, 0), g.next_state(Kind.DISPLACEMENT, 1)
    inductance = g.dag.add(g.node(2), g.dag.call(Op.SIN, q))
    energy = g.dag.div(g.dag.mul(p, p), g.dag.mul(g.node(2), inductance))
    g.storage("IC", "coil", EnergyLaw(g.dag.add(energy, g.dag.mul(q, q))), width=2)


@pytest.mark.parametrize("joined", ["nothing", "inertia", "compliance", "both"])
def test_an_ic_of_an_inertia_and_a_compliance_merges_by_port(joined: str) -> None:
    g = GraphBuilder()
    solenoid(g)
    g.draw(
        "winding : J1; armature : J0; winding -> coil; armature -> coil; wire : R(1); "
        "winding -> wire; friction : R(3); armature -> friction"
    )
    if joined in ("inertia", "both"):
        g.draw("leakage : I(0.5); winding -> leakage")
    if joined in ("compliance", "both"):
        g.draw("spring : C(2); armature -> spring")
    g.accounts = ("residual",)
    observe_everything(g)
    program = program_of(g)
    kinds = [s.kind for s in program.states]
    assert kinds.count("momentum") == 1
    assert kinds.count("displacement") == 2  # the inertia's charge, which nothing reads, and q
    if program.mass is None:
        assert abs(energy_defect(program)) < 1e-8


def test_a_momentum_that_an_energy_does_not_hold_cannot_be_observed() -> None:
    g = GraphBuilder()
    solenoid(g)
    g.draw("winding, armature : J1; winding -> coil; armature -> coil")
    g.observe("p", g.p("coil", 1))
    assert codes_of(program_of, g) == ["BG518"]


# --- random graphs ------------------------------------------------------------------------------


@settings(max_examples=150, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), gyrators=st.sampled_from([0.0, 0.25, 0.6]))
@pytest.mark.slow
def test_random_graphs_are_solved_or_refused(seed: int, gyrators: float) -> None:
    """Every regular graph is solved right, every other refused with a diagnostic."""
    check_random_graph(seed, 6, gyrators)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
@example(5311505)  # a resistance that is skew in part is refused
def test_random_graphs_with_moduli_that_turn_are_solved_or_refused(seed: int) -> None:
    """Moduli vanish now and then, so more is refused; what is accepted is right."""
    g = random_graph(seed, 6, gyrators=0.4, sources=0.15, turning=0.3)
    observe_everything(g)
    graph = g.build()
    try:
        program = derive_equations(causal_of(graph))
    except BgError:
        return
    point = evaluate_at_random(program, seed)
    assert largest_misfit(graph, point) < 1e-8
    assert power_imbalance(graph, point) < 1e-12


@pytest.mark.parametrize("seed", [3005, 3010, 3021, 3029])
def test_random_graphs_of_hundreds_of_elements(seed: int) -> None:
    check_random_graph(seed, 60, 0.3, sources=0.02)


def check_random_graph(seed: int, size: int, gyrators: float, sources: float = 0.2) -> None:
    g = random_graph(seed, size, gyrators=gyrators, sources=sources)
    degree = pencil_degree(g.build())
    observe_everything(g)
    g.accounts = ("residual",)  # has the compiler balance the powers too
    graph = g.build()
    try:
        program = derive_equations(causal_of(graph))
    except BgError:
        assert degree is None
        return
    assert degree is not None
    assert len([s for s in program.states if s.kind != "declared"]) == degree
    point = evaluate_at_random(program, seed)
    assert largest_misfit(graph, point) < 1e-8
    assert power_imbalance(graph, point) < 1e-12
