"""Sequential assignment of causality: the order of the strokes, and where they contradict."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from graphs import causal_of
from hypothesis import given, settings
from hypothesis import strategies as st
from random_graphs import random_graph

from bgc.causality.procedure import place_in_order
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import strokes_of
from bgc.ir.causal import Rule
from bgc.ir.graph import FlatGraph, Junction, Source, ports_of
from bgc.options import Options
from bgc.runtime.cli.app import application

WRONG = Path(__file__).parent.parent / "wrong"


@settings(max_examples=100, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_every_stroke_has_its_place_in_the_order(seed: int) -> None:
    """Each bond once and with its own stroke; sources first, and nothing follows from nothing."""
    graph = random_graph(seed, turning=0.3).build()
    try:
        causal = causal_of(graph)
    except BgError:
        return
    found = place_in_order(graph, causal.strokes)
    assert not found.contradiction
    assert sorted(item.bond for item in found.placements) == list(range(len(graph.bonds)))
    for bond, stroke in enumerate(found.strokes):
        assert stroke is not None and stroke.at_head == causal.strokes[bond].at_head
    choices = [item.stroke.rule for item in found.placements if item.choice]
    order = {Rule.FIXED: 0, Rule.PREFERRED: 1}
    assert choices == sorted(choices, key=lambda rule: order.get(rule, 2))


@settings(max_examples=200, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_a_graph_with_a_contradiction_is_refused_or_has_a_ring(seed: int) -> None:
    """A ring of bonds is warned of; a row that sources fill is refused where equations are made."""
    graph = random_graph(seed, sources=0.5, turning=0.3, gyrators=0).build()
    if place_in_order(graph).contradiction:
        assert not _is_plain(graph)


def _is_plain(graph: FlatGraph) -> bool:
    """Test whether a graph has causality without a ring of bonds and without a closing row."""
    try:
        causal = causal_of(graph)
    except BgError:
        return False
    return not causal.warnings and not causal.closures


@pytest.mark.parametrize(
    ("seed", "why"),
    [(46, "no bond brings the flow"), (4238, "both bring"), (5722, "cannot give both sides")],
)
def test_each_kind_of_contradiction_is_found(seed, why):
    graph = random_graph(seed, sources=0.6).build()
    assert why in place_in_order(graph).contradiction
    assert not _is_plain(graph)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_strokes_before_a_contradiction_obey_the_junctions(seed: int) -> None:
    graph = random_graph(seed, sources=0.6).build()
    found = place_in_order(graph)
    strokes = found.strokes
    for element in graph.elements:
        placed = [p for p in ports_of(element) if strokes[p.bond] is not None]
        receives = [strokes[p.bond].at_head == (p.sign > 0) for p in placed]
        match element:
            case Source():
                assert all(r == (element.kind == "Sf") for r in receives)
            case Junction() if {p.bond for p in placed}.isdisjoint(found.at_fault):
                assert receives.count(element.kind == "J0") <= 1


@pytest.mark.parametrize(
    ("name", "contradiction", "at_fault"),
    [
        ("two_efforts_on_one_junction", "`b` sets the effort, but `node` has one effort, which "
         "`a` brings", 2),
        ("two_flows_on_one_junction", "`b` sets the flow, but `node` has one flow, which `a` "
         "brings", 2),
        ("gear_between_two_drives", "`brake` sets the flow, but `gear` passes on the flow", 2),
    ],
)  # fmt: skip
def test_a_graph_without_causality_is_shown_up_to_its_contradiction(name, contradiction, at_fault):
    found, refusal = strokes_of(WRONG / f"{name}.bg", Options())
    assert refusal is not None
    assert found.contradiction == contradiction and len(found.at_fault) == at_fault


def test_the_commands_show_what_leads_to_a_contradiction(tmp_path):
    source = WRONG / "two_efforts_on_one_junction.bg"
    target = tmp_path / "drawn.dot"
    for command in (["causality", str(source)], ["graph", str(source), "-o", str(target)]):
        done = CliRunner().invoke(application, command)
        assert done.exit_code == 1 and "both set the same effort" in done.stderr
        if command[0] == "causality":
            assert "contradiction  `b` sets the effort, but `node` has one effort" in done.stdout
    assert target.read_text().count("#c62828") == 2


def test_steps_number_the_choices():
    file = WRONG.parent / "models" / "dc_motor.bg"
    done = CliRunner().invoke(application, ["causality", str(file), "--steps"])
    rows = [line for line in done.stdout.splitlines()[2:] if line.split()[0].isdigit()]
    assert [(row.split()[0], row.split()[4]) for row in rows] == [
        ("1", "fixed"), ("2", "preferred"), ("3", "preferred"),
    ]  # fmt: skip
