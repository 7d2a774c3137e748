"""Zeros that nobody chose give way to what is given; what is given has to agree."""

from __future__ import annotations

import pytest
from graphs import causal_of

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.elaborate import elaborate
from bgc.equations.derive import derive_equations
from bgc.ir.defaults import default_values
from bgc.ir.program import Program
from bgc.printing.causality_table import storage_table
from bgc.resolution.resolve import load_text
from bgc.slicing.fold import fold_parameters

PARTS = """
domain Line { effort F : N; flow v : m/s; }
model Mass { port tip in : Line main; param v0 : m/s = 0; body : I(2, f0 = v0); tip -> body; }
model Sled { port tip in : Line main; input v0 : m/s = 0; inside : Mass(v0 = v0); tip -> inside; }
"""


def program_of(model: str, scene: str = "") -> Program:
    text = f"{PARTS} model M {{ {model} }} scene s of M {{ {scene} observe node.f as v; }}"
    graph = fold_parameters(elaborate(load_text(text, "model.bg"))).graph
    return derive_equations(causal_of(graph))


def start_of(program: Program) -> float:
    """The observed flow at the start."""
    values = default_values(program.dag, program.parameters)
    states = enumerate(program.states)
    start = {program.dag.symbol(Kind.STATE, k): state.initial for k, state in states}
    roots = program.dag.substitute([program.observations[0].node], start)
    return evaluate_nodes(program.dag, roots, {**values, Symbol(Kind.TIME, 0): 0.0})[0]


TWO = "node : J1; a : {a}; b : {b}; push : Se(0); push -> node -> a, b;"


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ("Mass(v0 = 3)", "Mass()"),
        ("Mass()", "Mass(v0 = 3)"),
        ("Sled()", "I(1, f0 = 3)"),
        ("Sled(v0 = 3)", "Sled()"),
    ],
)
def test_the_part_that_was_given_a_value_decides(a: str, b: str) -> None:
    program = program_of(TWO.format(a=a, b=b))
    assert start_of(program) == pytest.approx(3)
    assert len(program.ignored_defaults) == 1


def test_a_value_that_the_scene_sets_is_given() -> None:
    assert start_of(program_of(TWO.format(a="Mass()", b="Mass()"), "set b.v0 = 3;")) == 3
    assert start_of(program_of(TWO.format(a="Mass()", b="Mass()"))) == 0


@pytest.mark.parametrize(
    ("a", "b", "scene"),
    [
        ("Mass(v0 = 3)", "Mass(v0 = 0)", ""),
        ("Mass(v0 = 3)", "Sled(v0 = 0)", ""),
        ("Mass(v0 = 3)", "I(1, f0 = 0)", ""),
        ("Mass(v0 = 3)", "Mass()", "set b.v0 = 0;"),
        ("Mass(v0 = 3)", "Mass(v0 = still)", ""),
    ],
)
def test_a_zero_that_was_given_has_to_agree(a: str, b: str, scene: str) -> None:
    with pytest.raises(BgError) as caught:
        program_of("param still : m/s = 0;" + TWO.format(a=a, b=b), scene)
    assert [d.code for d in caught.value.diagnostics] == ["BG516"]


def test_what_a_source_moves_starts_as_the_source_does() -> None:
    program = program_of("node : J1; drag : Sf(4 + time); a : Mass(); drag -> node -> a;")
    assert start_of(program) == pytest.approx(4)
    assert program.ignored_defaults == ("a.body",)


def test_an_element_gives_way_as_a_whole() -> None:
    """Half of a standstill would have the link swing: it follows by the least energy instead."""
    link = """
    model Link { port tip[2] in; param twist0[2] = zeros(2);
      body : I[2]([[1, 0], [0, 1]], f0 = twist0); tip -> body; }
    """
    text = f"""{PARTS}{link}
    model M {{ cart : I(1, f0 = 1); cradle : J1; hinge : I(1); push : Se(0);
      push -> cradle -> cart; lever : TF {{ f2 = [[1, 0], [1, 1]]*f1; }} join : Mux[1, 1];
      turning : J1; turning -> hinge; cradle, turning -> join -> lever -> link; link : Link(); }}
    scene s of M {{ observe turning.f as v; }}"""
    graph = fold_parameters(elaborate(load_text(text, "model.bg"))).graph
    program = derive_equations(causal_of(graph))
    # Of (1 + v)^2/2 + v^2/2, the least; standing still in the second place alone would be -1.
    assert start_of(program) == pytest.approx(-0.5)
    assert program.ignored_defaults == ("link.body",)


def test_the_table_tells_what_gave_way() -> None:
    text = TWO.format(a="Mass(v0 = 3)", b="Mass()")
    source = f"{PARTS} model M {{ {text} }} scene s of M {{ observe node.f as v; }}"
    causal = causal_of(fold_parameters(elaborate(load_text(source, "model.bg"))).graph)
    rows = {row[0]: row[-1] for row in storage_table(causal, derive_equations(causal)).rows}
    assert "starts as what it is joined to" in rows["b.body"]
    assert "starts as what" not in rows["a.body"]
