"""Causality: independent flows, strokes with their reasons, refusals that name the culprits."""

from __future__ import annotations

import sys

import pytest
from graphs import GraphBuilder, causal_of, rlc
from hypothesis import given, settings
from hypothesis import strategies as st
from random_graphs import random_graph
from refusals import codes_of

from bgc.algebra.dag import Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.certificates import Certifier
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.derive import derive_equations
from bgc.ir.causal import BasisKind
from bgc.ir.graph import Form, Junction, Node, Source, Transformer, ports_of


def codes(g: GraphBuilder) -> list[str]:
    return codes_of(lambda: causal_of(g.build()))

    # the resistor's flow is the independent one: its law gives the effort, the capacitor's the
    # equation for it


@pytest.mark.parametrize(("source", "junction"), [("Se", "J1"), ("Sf", "J0")])
def test_source_without_load(source: str, junction: str) -> None:
    g = GraphBuilder()
    g.source(source, "supply", g.node(1))
    g.junction(junction, "node")
    g.bond("supply", "node")
    assert codes(g) == ["BG508"]


def pendulum(ratio: Node, g: GraphBuilder) -> None:
    """A rod's angle on a junction without an element; its mass behind a modulated transformer."""
    g.draw("weight : Se(1); angle, height : J1")
    g.transformer("rod", ((ratio,),))
    g.draw(
        "mass : I(1); friction : R(1); angle -> rod -> height -> mass; weight -> height; "
        "angle -> friction"
    )


def test_a_modulus_that_varies_is_never_divided_by() -> None:
    g = GraphBuilder()
    angle = g.state("theta", 0)
    g.derivative(angle, g.flow(0))
    pendulum(g.dag.call(Op.COS, angle), g)
    causal = causal_of(g.build())
    (basis,) = causal.basis
    assert basis.kind is BasisKind.INERTIA
    assert basis.bond_class == causal.class_of[0]
    assert causal.positive == ()


def test_an_inertia_behind_a_modulus_that_varies_is_moved_by_one_flow() -> None:
    """A spring and a damper beside the modulus are not motions of the inertia."""
    g = GraphBuilder()
    angle = g.state("theta", 0.2)
    g.derivative(angle, g.node(1))
    g.draw("node : J0; shaft : J1")
    g.transformer("gear", ((g.dag.call(Op.COS, angle),),))
    g.draw(
        "spring : C(1); damper : R(1); body : I(1); node -> gear -> shaft; node -> spring, damper; "
        "shaft -> body"
    )
    causal = causal_of(g.build())
    assert sorted(b.kind.name for b in causal.basis) == ["INERTIA", "RESISTANCE"]
    (moving,) = (b.bond_class for b in causal.basis if b.kind is BasisKind.INERTIA)
    assert moving == causal.class_of[0]  # node -> gear
    derive_equations(causal)


def test_a_parameter_that_is_divided_by_is_watched() -> None:
    g = GraphBuilder()
    ratio = g.param("n", 2)
    g.source("Sf", "drive", g.node(1))
    g.transformer("gear", ((ratio,),))
    g.draw("load : R(1); load -> gear -> drive")
    causal = causal_of(g.build())
    assert [p.node for p in causal.positive] == [ratio]
    assert causal.positive[0].message == "the modulus of `gear` must not be zero"


def test_a_parameter_that_is_zero_is_no_divisor() -> None:
    g = GraphBuilder()
    ratio = g.param("n", 0)
    g.source("Sf", "drive", g.node(1))
    g.transformer("gear", ((ratio,),))
    g.draw("load : R(1); load -> gear -> drive")
    assert codes(g) == ["BG503"]


@pytest.mark.parametrize("moved", ["R", "I"])
def test_a_rigid_chain_may_close_on_inertias_only(moved: str) -> None:
    g = GraphBuilder()
    angle = g.state("theta", 0)
    g.derivative(angle, g.flow(0))
    g.source("Sf", "drive", g.node(1))
    g.transformer("rod", ((g.dag.call(Op.COS, angle),),))
    if moved == "I":
        g.storage("I", "mass", 1)
    else:
        g.resistor("mass", 1)
    g.draw("mass -> rod -> drive")
    if moved == "R":
        assert codes(g) == ["BG502"]
        return
    graph = g.build()
    (closure,) = causal_of(graph).closures
    assert [graph.elements[k].name for k in closure.elements] == ["rod"]


@pytest.mark.parametrize("reverse", [False, True])
def test_a_rotation_may_be_drawn_either_way(reverse: bool) -> None:
    """So may a multiple of one, whose factor is watched where it is divided by."""
    g = GraphBuilder()
    angle, flux = g.state("theta", 0), g.param("flux", 0.2)
    s, c = (g.dag.mul(flux, g.dag.call(op, angle)) for op in (Op.SIN, Op.COS))
    for k in (1, 2):
        g.source("Sf", f"held{k}", g.node(1))
        g.resistor(f"load{k}", 1)
    g.derivative(angle, g.node(1))
    g.transformer("turn", ((c, g.dag.neg(s)), (s, c)))
    near, far = ("held", "load") if reverse else ("load", "held")
    for k in (1, 2):
        g.bond("turn", f"{far}{k}")
        g.bond(f"{near}{k}", "turn")
    causal = causal_of(g.build())
    assert {b.kind for b in causal.basis} == {BasisKind.FLOW_SOURCE}
    assert [p.node for p in causal.positive] == [flux] * (not reverse)


@pytest.mark.parametrize("reverse", [False, True])
def test_an_inertia_that_a_modulus_reads_stays_independent(reverse: bool) -> None:
    """The modulus is known by its momentum; by that of the other it would follow from itself."""
    g = GraphBuilder()
    for name in ("near", "far"):
        g.storage("I", name, [[2, 0], [0, 2]], Form.MOMENTUM)
        g.draw(f"{name}1, {name}2 : J1")
    s, c = (g.dag.call(op, g.p("near", 1)) for op in (Op.SIN, Op.COS))
    g.transformer("turn", ((c, g.dag.neg(s)), (s, c)))
    near = [g.bond(f"near{k}", "near") for k in (1, 2)]
    first, last = ("far", "near") if reverse else ("near", "far")
    for k in (1, 2):
        g.bond(f"far{k}", "far")
        g.bond(f"{first}{k}", "turn")
    for k in (1, 2):
        g.bond("turn", f"{last}{k}")
    causal = causal_of(g.build())
    assert {b.bond_class for b in causal.basis} == {causal.class_of[bond] for bond in near}


def test_a_gyrator_that_turns_holds_the_flows_before_it() -> None:
    """With no effort behind a rotation there is no flow before it, whatever its angle."""
    g = GraphBuilder()
    angle, flux = g.state("theta", 0), g.param("flux", 3e8)
    s, c = (g.dag.mul(flux, g.dag.call(op, angle)) for op in (Op.SIN, Op.COS))
    g.draw("body1, body2 : I(1); free1, free2, moved1, moved2 : J1")
    g.gyrator("turn", ((c, g.dag.neg(s)), (s, c)))
    g.derivative(angle, g.node(1))
    g.draw("moved1 -> body1, turn; moved2 -> body2, turn; turn -> free1; turn -> free2")
    causal = causal_of(g.build())
    assert [p.node for p in causal.positive] == [flux]
    assert {b.kind for b in causal.basis} <= {BasisKind.INDETERMINATE}


def test_parallel_bonds_are_warned_of() -> None:
    g = rlc()
    g.draw("again : J1; loop -> again; loop -> again")
    assert [w.code for w in causal_of(g.build()).warnings] == ["BG505"]


def test_a_flow_that_goes_round_is_warned_of() -> None:
    g = rlc()
    g.draw("node : J0; ring : J1; node -> ring -> node")
    warnings = causal_of(g.build()).warnings
    assert [w.code for w in warnings] == ["BG504", "BG507"]
    assert "`node`" in warnings[0].message


@settings(max_examples=150, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_strokes_obey_the_rules_of_every_element(seed: int) -> None:
    """A J0 is given one effort, a J1 one flow; a transformer as many as rows, sources theirs."""
    graph = random_graph(seed, gyrators=0).build()
    try:
        causal = causal_of(graph)
    except BgError:
        return
    if causal.warnings:
        return
    for element in graph.elements:
        ports = ports_of(element)
        count = sum(causal.strokes[p.bond].at_head == (p.sign > 0) for p in ports)
        match element:
            case Junction():
                assert count == (1 if element.kind == "J0" else len(ports) - 1)
            case Transformer():
                assert count == len(element.matrix)
            case Source():
                assert count == (1 if element.kind == "Sf" else 0)
            case _:
                pass


def test_the_work_on_a_chain_grows_with_its_length() -> None:
    assert calls_for_chain(400) < 4.4 * calls_for_chain(100)


def calls_for_chain(size: int) -> int:
    """The function calls, of Python and of C, in the assignment of causality to a chain."""
    g = GraphBuilder()
    chain(g, size)
    graph, calls = g.build(), 0

    def count(frame: object, event: str, argument: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        causal = causal_of(graph)
    finally:
        sys.setprofile(before)
    assert len(causal.basis) == size
    return calls


def chain(g: GraphBuilder, size: int) -> None:
    """Masses joined by springs, the first one to the wall."""
    for k in range(size):
        g.junction("J1", f"body{k}")
        g.junction("J0", f"gap{k}")
        g.storage("I", f"mass{k}", 1)
        g.storage("C", f"spring{k}", 1)
        g.bond(f"body{k}", f"mass{k}")
        g.bond(f"gap{k}", f"spring{k}")
        g.bond(f"gap{k}", f"body{k}")
        if k:
            g.bond(f"body{k - 1}", f"gap{k}")


def test_a_pivot_is_small_below_a_tenth_of_its_row() -> None:
    g = GraphBuilder()
    certifier = Certifier(g.dag, Fingerprints(g.dag), ())
    row = [g.node(x) for x in (3, 20, 100)]
    found = [certifier.size_in(node, row) for node in row]
    assert [size.is_small for size in found if size is not None] == [True, False, False]
