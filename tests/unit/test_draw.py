import re
import shutil
from dataclasses import replace

import pytest
from graphs import GraphBuilder, rlc

from bgc.causality.assign import assign_causality
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.graph import FlatGraph
from bgc.printing.draw import lay_out, to_dot

needs_dot = pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")


def edges(text: str) -> dict[tuple[str, str], str]:
    found = re.findall(r"n(\d+) -> n(\d+) \[(.*)\];", text)
    return {(tail, head): facts for tail, head, facts in found}


def wide(graph: FlatGraph) -> FlatGraph:
    """Call all bonds the components of one wide bond."""
    bonds = [
        replace(bond, wide="supply -> load", component=k + 1, width=len(graph.bonds))
        for k, bond in enumerate(graph.bonds)
    ]
    return replace(graph, bonds=tuple(bonds))


def pair() -> FlatGraph:
    g = GraphBuilder()
    g.source("Se", "supply[1]", g.node(1))
    g.source("Se", "supply[2]", g.node(2))
    g.storage("I", "load", [[1, 0], [0, 2]])
    g.bond("supply[1]", "load")
    g.bond("supply[2]", "load")
    return g.build()


def test_strokes_stand_where_the_effort_is_given():
    drawn = edges(to_dot(assign_causality(rlc().build())))
    assert "arrowhead=teelvee" in drawn["0", "1"]  # the supply gives the loop its effort
    assert "arrowhead=teelvee" in drawn["1", "2"]  # the loop gives the coil its effort
    assert "arrowtail=tee" in drawn["1", "3"]  # the capacitor gives the loop its effort
    assert "capacitor" in drawn["1", "3"]  # the reason


def test_the_drawing_is_the_same_each_time():
    assert to_dot(assign_causality(rlc().build())) == to_dot(assign_causality(rlc().build()))


def test_a_wide_bond_is_one_double_line_between_parts_drawn_once():
    text = to_dot(assign_causality(wide(pair())))
    ((_, facts),) = edges(text).items()
    assert 'label="2"' in facts and "black:invis:black" in facts
    assert text.count("<b>Se</b>") == 1
    assert ">supply<" in text


def test_scalar_bonds_of_an_array_stay_apart():
    assert len(edges(to_dot(assign_causality(pair())))) == 2


def test_parts_of_parts_stand_in_their_boxes():
    g = GraphBuilder()
    g.source("Se", "crane.motor.supply", g.node(1))
    g.storage("I", "crane.boom", 1)
    g.bond("crane.motor.supply", "crane.boom")
    text = to_dot(assign_causality(g.build()))
    assert 'subgraph "cluster_crane"' in text
    assert 'subgraph "cluster_crane.motor"' in text
    assert ">boom<" in text


@needs_dot
def test_graphviz_takes_it():
    assert b"</svg>" in lay_out(to_dot(assign_causality(rlc().build())), "svg")


@needs_dot
def test_what_graphviz_refuses_is_a_diagnostic():
    with pytest.raises(BgError) as error:
        lay_out("digraph {", "svg")
    assert error.value.diagnostics[0].code == "BG057"


def test_without_graphviz_it_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BgError) as error:
        lay_out(to_dot(assign_causality(rlc().build())), "svg")
    assert error.value.diagnostics[0].code == "BG056"
    assert "graphviz" in error.value.diagnostics[0].help
