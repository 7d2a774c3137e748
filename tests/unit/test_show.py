"""The output of `bgc show` after each pass."""

from pathlib import Path

import pytest
from model_files import model_text

from bgc.driver import compile_scene
from bgc.options import Options
from bgc.printing.stages import PASSES, Pass, needed_for
from bgc.printing.stages import show_pass as shown

MODELS = Path(__file__).parents[1] / "models"

WIDE = model_text("show_wide")


def show_pass(name: Pass, path: Path, options: Options) -> str:
    return shown(name, compile_scene(path, options, until=needed_for(name)))


@pytest.fixture
def wide(tmp_path) -> Path:
    path = tmp_path / "wide.bg"
    path.write_text(WIDE)
    return path


@pytest.mark.parametrize("name", PASSES)
def test_every_pass_prints_the_same_twice(name):
    path = MODELS / "dc_motor.bg"
    text = show_pass(name, path, Options())
    assert text.endswith("\n") and text == show_pass(name, path, Options())


def test_the_flat_graph_names_neighbouring_components_together(wide):
    lines = show_pass("elaborate", wide, Options()).splitlines()
    assert "  body : I on hub -> body [1..3]" in lines
    assert "  drag : R on hub -> drag [1..2]" in lines
    assert any(line.startswith("  push[2] -> hub[2]") for line in lines)


def test_what_a_scene_sets_to_zero_is_folded_into_the_graph(wide):
    text = WIDE.replace("hub  : J1;", "param loss = 4; hub  : J1;").replace("R[2](4)", "R[2](loss)")
    wide.write_text(text.replace("observe", "set loss = 0; observe"))
    assert "\n  loss = " in show_pass("elaborate", wide, Options())
    folded = show_pass("fold", wide, Options())
    assert folded.startswith("folded\n  `loss` = 0\n\nelements\n")
    assert "\n  loss = " not in folded


def test_strokes_of_a_wide_bond_name_their_component(wide):
    text = show_pass("causality", wide, Options())
    assert "  hub[3] ->| body" not in text  # alike as the other two: one row
    lines = [line.split(maxsplit=5) for line in text.splitlines()]
    assert ["hub", "->|", "body", "[1..3]", "preferred", "`body` integrates the effort"] in lines


def test_accounts_are_shown_where_the_scene_observes_one():
    assert "energy\n" in show_pass("equations", MODELS / "series_rlc.bg", Options())
    assert "energy\n" not in show_pass("equations", MODELS / "dc_motor.bg", Options())


def test_a_mass_matrix_is_shown_on_the_left(tmp_path):
    path = tmp_path / "dae.bg"
    path.write_text(
        "model Dae { state x = 1; unknown z = 1; equation 2*der(x) + z = 0; equation z^3 = x; }"
    )
    text = show_pass("equations", path, Options())
    assert "  (2) * x' = -z\n" in text or "  (-2) * x' = z\n" in text
    assert "  0 = " in text


def loops(tmp_path, text: str) -> str:
    path = tmp_path / "m.bg"
    path.write_text(f"model M {{ {text} }}")
    return show_pass("causality", path, Options()).partition("algebraic loops")[2]


def test_algebraic_loops_are_named(tmp_path):
    ladder = """
        s : Se(e = 4); r1 : R(2); r2 : R(3); r3 : R(5); c : C(1); a : J1; b : J0; d : J1;
        s -> a -> r1; a -> b; b -> r2; b -> d; d -> r3, c;
    """
    assert "r2.f, r3.f  r1, r2, r3  linear, its matrix from parameters alone" in loops(
        tmp_path, ladder
    )


@pytest.mark.parametrize(
    ("law", "feedback", "expected"),
    [
        ("R(2)", "3", False),
        ("R(1)", "3", False),
        ("R { e = f*abs(f) + f; }", "3", False),
        ("R(2)", "-0.5*line.f", True),
        ("R(1)", "-0.5*line.f", True),
    ],
)
def test_a_law_that_is_turned_round_is_no_loop(tmp_path, law, feedback, expected):
    text = f"""
        push : MSe(e = {feedback}); line : J1; load : {law}; store : C(1, q0 = 1);
        push -> line -> load, store;
    """
    assert bool(loops(tmp_path, text)) == expected


def test_a_motor_has_no_algebraic_loop():
    assert "algebraic" not in show_pass("causality", MODELS / "dc_motor.bg", Options())


def test_merged_storage_names_its_generalised_momentum_and_the_others(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(
        """model M {
          push : Se(e = 1); line : J1; a : I(2); gear : TF(2); b : I(3); c : C(1); far : J1;
          push -> line -> a; line -> gear -> far -> b; far -> c;
        }"""
    )
    text = show_pass("causality", path, Options())
    (a,) = (line for line in text.splitlines() if line.startswith("  a "))
    (c,) = (line for line in text.splitlines() if line.startswith("  c "))
    assert "the generalised momentum line.p, with b" in a
    assert c.split() == ["c", "C", "integral", "c.q"]
    assert "derivative" in text and "what `b` stores follows from other elements" in text


def test_a_deep_syntax_tree_is_shown_to_its_leaves(tmp_path):
    """Indented beyond the width of the page, a number or a name still stands on its line."""
    path = tmp_path / "deep.bg"
    inner = "-(".join(["sin(1"] * 20) + ")" * 39
    path.write_text(
        f"model M {{ state x = 0; der(x) = {inner}; }} scene s of M {{ observe x; run 1 s; }}"
    )
    assert show_pass("parse", path, Options()).count("sin") == 20


@pytest.mark.parametrize(
    ("parts", "row"),
    [
        ("supply : Sf(f = sin(time)); store : I(1);", "momentum follows from the flow"),
        ("supply : Se(e = sin(time)); store : C(1);", "displacement follows from the effort"),
    ],
)
def test_storage_on_a_source_of_its_own_kind_has_no_state(tmp_path, parts, row):
    path = tmp_path / "driven.bg"
    path.write_text(
        f"model M {{ {parts} supply -> store; }} scene s of M {{ observe store.e; run 1 s; }}"
    )
    assert f"none: its {row} that it is given" in show_pass("causality", path, Options())
