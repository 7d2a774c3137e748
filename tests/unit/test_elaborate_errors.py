"""Mistakes in several parts, files and scenes: each is told once, with its place."""

import re

import pytest
from refusals import refusal, refusals

from bgc.diagnostics.diagnostic import BgError, Severity
from bgc.elaboration.elaborate import elaborate
from bgc.resolution.resolve import load, load_text

# A model that is in order, for what follows to break.
RLC = """
model RLC {
  param R = 2; param L = 3; param C = 4;
  supply : Se(e = 1); loop : J1; coil : I(L); capacitor : C(C); resistor : R(R);
  supply -> loop; loop -> coil, capacitor, resistor;
}
"""
PARTS = """
domain Electric { effort u : V; flow i : A; signal mark; }
domain Shaft { effort T : N*m; flow w : rad/s; }
interface Lock[n] { port p[n]; output d[n]; }
model Stiff[n] is Lock[n] { port p[n]; param k = 2; c : C[n](stiffness = k); p -> c;
                            output d[n] = c.q; }
model Load { port p in; param r = 1; x : R(r); p -> x; }
model Supply { port p out : Electric; s : Se(e = 1 V); s -> p; }
"""


def scene(items: str, model: str = "RLC") -> str:
    return f"{RLC}scene s of {model} {{ {items} }}"


def chain(statements: str) -> str:
    """A model with a source `s`, a junction `j` where it is named, and what else is written."""
    junction = "j : J1;" if re.search(r"\bj\b", statements) else ""
    return f"{PARTS}model M {{ s : Se(e = 1); {junction} {statements} }}"


def codes_of(text: str) -> set[str]:
    try:
        elaborate(load_text(text, "wrong.bg"))
    except BgError as err:
        return {d.code for d in err.diagnostics if d.severity is Severity.ERROR}
    return set()


def test_one_mistake_in_a_model_is_told_once_for_all_its_parts():
    text = (
        "model Load { port p in; x : R(1); p -> x; output y = x.q; }"
        "model M { s : Se(e = 1); j : J1; a : Load; b : Load; s -> j -> a, b; }"
    )
    with pytest.raises(BgError) as caught:
        elaborate(load_text(text))
    assert [d.code for d in caught.value.diagnostics] == ["BG419"]


def test_unknown_scene_names_the_scenes():
    problem = refusal(lambda: elaborate(load_text(scene("run 1 s;")), "steep"))
    assert problem.code == "BG600"
    assert "`s`" in problem.help


def test_file_without_a_model():
    assert refusals(lambda: elaborate(load_text("const a = 1;")))[0].code == "BG601"


def test_independent_mistakes_are_reported_together():
    text = """
      model M {
        param mass : kg = 3 m;
        s : Se(e = 1);
        r : R(resistence = 2);
        node : J1;
        s -> nod;
        node -> r;
      }
    """
    assert codes_of(text) >= {"BG211"}
    text = text.replace("nod;", "node;")
    assert codes_of(text) == {"BG306", "BG230"}


def test_note_says_in_which_part():
    text = f"""{PARTS}
      model Outer {{ port p in; x : Load(rr = 1); p -> x; }}
      model M {{ s : Se(e = 1); x : Outer; s -> x; }}
    """
    assert refusals(lambda: elaborate(load_text(text)))[0].note == "in `x`"


def test_the_same_mistake_in_an_array_is_told_once():
    text = chain("for i in 1..9 { x[i] : R(1 + time); j -> x[i]; } s -> j;")
    with pytest.raises(BgError) as caught:
        elaborate(load_text(text))
    assert len(caught.value.diagnostics) == 1


def test_imports(tmp_path):
    (tmp_path / "a.bg").write_text('import "b.bg";\nmodel A {}')
    (tmp_path / "b.bg").write_text('import "a.bg";\nmodel B {}')
    problem = refusal(load, tmp_path / "a.bg")
    assert problem.code == "BG022"
    assert problem.message.count("a.bg") == 2

    (tmp_path / "c.bg").write_text('import "d.bg"; import nowhere.at_all;')
    with pytest.raises(BgError) as caught:
        load(tmp_path / "c.bg")
    assert {d.code for d in caught.value.diagnostics} == {"BG020", "BG021"}

    (tmp_path / "e.bg").write_text("model E {}")
    (tmp_path / "f.bg").write_text("model E {}")
    (tmp_path / "g.bg").write_text('import "e.bg"; import "f.bg";')
    assert refusals(load, tmp_path / "g.bg")[0].code == "BG023"
