import re
import shutil
from dataclasses import replace

import pytest
from click.testing import CliRunner
from graphs import causal_of, drawn, rlc
from model_files import model_text
from refusals import refusals

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.ir.graph import FlatGraph
from bgc.options import Options
from bgc.printing.draw import View, lay_out, to_dot
from bgc.runtime.cli.app import application

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
    g = drawn("supply[1] : Se(1); supply[2] : Se(2)")
    g.storage("I", "load", [[1, 0], [0, 2]])
    g.draw("supply[1] -> load; supply[2] -> load")
    return g.build()


def test_strokes_stand_where_the_effort_is_given():
    drawn = edges(to_dot(causal_of(rlc().build())))
    assert "arrowhead=teelvee" in drawn["0", "1"]  # the supply gives the loop its effort
    assert "arrowhead=teelvee" in drawn["1", "2"]  # the loop gives the coil its effort
    assert "arrowtail=tee" in drawn["1", "3"]  # the capacitor gives the loop its effort
    assert "capacitor" in drawn["1", "3"]  # the reason


def test_the_drawing_is_the_same_each_time():
    assert to_dot(causal_of(rlc().build())) == to_dot(causal_of(rlc().build()))


def test_a_wide_bond_is_one_double_line_between_parts_drawn_once():
    text = to_dot(causal_of(wide(pair())))
    ((_, facts),) = edges(text).items()
    assert 'label="2"' in facts and "black:invis:black" in facts
    assert text.count("<b>Se</b>") == 1
    assert ">supply<" in text


def test_scalar_bonds_of_an_array_stay_apart():
    assert len(edges(to_dot(causal_of(pair())))) == 2


def test_parts_of_parts_stand_in_their_boxes():
    g = drawn("crane.motor.supply : Se(1); crane.boom : I(1); crane.motor.supply -> crane.boom")
    text = to_dot(causal_of(g.build()))
    assert 'subgraph "cluster_crane"' in text
    assert 'subgraph "cluster_crane.motor"' in text
    assert ">boom<" in text


MODULATED = model_text("draw_modulated")


def drawing(tmp_path, view: View) -> str:
    path = tmp_path / "m.bg"
    path.write_text(MODULATED)
    return to_dot(compile_scene(path, Options(), until="causality").causal, view)


def named(text: str) -> dict[str, tuple[str, str]]:
    """The number and the kind of each node, by its name."""
    nodes = re.findall(r"n(\d+) \[label=<(?:<b>(\w+)</b><br/>)?.*?>(\w+)</font>", text)
    parts = re.findall(r'n(\d+) \[label="(\w+)"', text)
    return {name: (n, kind) for n, kind, name in nodes} | {name: (n, "") for n, name in parts}


def test_modulated_elements_are_marked_and_their_signals_drawn(tmp_path):
    """D12: MTF, MR and MSe were drawn as TF, R and Se, without signals."""
    text = drawing(tmp_path, View())
    nodes = named(text)
    kinds = {name: kind for name, (_, kind) in nodes.items()}
    assert (kinds["lift"], kinds["valve"], kinds["pull"]) == ("MTF", "MR", "MSe")
    assert (kinds["plain"], kinds["wave"], kinds["s"]) == ("R", "Se", "Se")
    arrows = {(tail, head) for (tail, head), facts in edges(text).items() if "dashed" in facts}
    expected = [("angle", "lift"), ("spool", "valve"), ("load", "pull")]
    assert arrows == {(nodes[tail][0], nodes[head][0]) for tail, head in expected}


@pytest.mark.parametrize("view", [View(depth=0), View(collapsed=("a",))])
def test_a_part_that_is_not_opened_is_one_node(tmp_path, view):
    text = drawing(tmp_path, view)
    nodes = named(text)
    assert "lift" not in nodes and "cluster" not in text
    arm, pull, j = nodes["a"][0], nodes["pull"][0], nodes["j"][0]
    assert "dashed" not in edges(text)[j, arm]
    assert "dashed" in edges(text)[arm, pull]  # the load's momentum
    assert (arm, arm) not in edges(text)


def test_parts_can_be_collapsed_and_others_are_refused(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(MODULATED)
    target = tmp_path / "m.dot"
    run = CliRunner().invoke(
        application, ["graph", str(path), "--collapse", "a", "-o", str(target)]
    )
    assert run.exit_code == 0 and "lift" not in target.read_text()
    run = CliRunner().invoke(
        application, ["graph", str(path), "--collapse", "b", "-o", str(target)]
    )
    assert run.exit_code == 1 and "BG045" in run.stderr


@needs_dot
def test_graphviz_takes_it():
    assert b"</svg>" in lay_out(to_dot(causal_of(rlc().build())), "svg")


@needs_dot
def test_what_graphviz_refuses_is_a_diagnostic():
    assert refusals(lay_out, "digraph {", "svg")[0].code == "BG057"


def test_without_graphviz_it_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BgError) as error:
        lay_out(to_dot(causal_of(rlc().build())), "svg")
    assert error.value.diagnostics[0].code == "BG056"
    assert "graphviz" in error.value.diagnostics[0].help
