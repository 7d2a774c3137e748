"""Every mistake in names, bonds, laws and scenes gives its code, and no other."""

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


WRONG: dict[str, list[str]] = {
    # names and types
    "BG200": [
        "model M { param a = 1; param a = 2; }",
        "model M {} model M {}",
        "model M[n] { param n = 1; } scene s of M[2] {}",
        "model M { for i in 1..2 { let a = 1; let a = 2; } }",
        "model M { for i in 1..2 { a[1] : J1; } }",
        f"{RLC}scene s of RLC {{}} scene s of RLC {{}}",
        "domain D { effort e; flow e; } model M { port p : D; }",
    ],
    "BG201": [chain("x : Beem; s -> j -> x;"), "model M is Nothing {}", "scene s of Nothing {}"],
    "BG202": ["model M { port p : Fram; }"],
    "BG203": ["interface A {} scene s of A {}", "scene s of R {}", "domain D {} scene s of D {}"],
    "BG204": ["model A is B {} model B is A {} scene s of A {}"],
    "BG205": ["model A { a : A; }"],
    "BG206": [
        chain("x : Stiff; s -> x;"),
        chain("x : Stiff[1, 2]; s -> x;"),
        chain("x : C[1, 2](1); s -> x;"),
    ],
    "BG207": ["model R { }", "domain J0 { effort a; flow b; }"],
    "BG210": [chain("x : Load; s -> x; let a = x.q;"), chain("x : Load; s -> x.q;")],
    "BG211": [RLC + "model Unused { let a = b; for i in 1..2 { x[i] : R(i); } } scene s of RLC { }",
              chain("s -> k;"), chain("s -> j; k = 3;")],
    "BG212": [
        chain("for i in 1..3 { x[i] : R(1); } s -> j; j -> x[1], x[2], x[3]; let a = x[4].e;"),
        "model M { state v[2] = 0; der(v[1]) = 1; der(v[2]) = 1; der(v[3]) = 1; }",
        scene("set R[2] = 3;"),
    ],
    "BG213": [chain("for i in 1..3 { x[i] : R(1); } s -> j -> x;")],
    "BG214": ["model M { let a = b; let b = c; let c = a; }"],
    "BG218": [
        "model M { param a; }",
        "model M { input u; let b = u; }",
        "model M { output y; }",
        "model M { output y[2]; y[1] = 3; }",
    ],
    "BG220": [
        "model M { output y; y = 1; y = 2; }",
        chain("x : R(1, resistance = 2); s -> x;"),
        chain("x : Load(r = 1, r = 2); s -> x;"),
        "model M { state a = 1; der(a) = 1; der(a) = 2; }",
        scene("set R = 3; set R = 4;"),
    ],
    "BG230": [chain("x : Load(rr = 1); s -> x;"), chain("x : R(foo = 1); s -> x;")],
    "BG231": ["model A { let a = 1; let b = a; } model M { x : A(a = 3); }"],
    "BG232": [chain("x : Load(3); s -> x;")],
    "BG233": [chain("x : Lock[1]; s -> x;")],
    "BG234": [chain("x : Lock[1] = Load; s -> x;"), chain("x : Lock[1] = Lock[1]; s -> x;")],
    "BG235": [chain("x : R = R(1); s -> x;")],
    "BG236": [PARTS + "model Bad[n] is Lock[n] { port p[n]; }" + RLC],
    "BG237": [chain("x : Outer(slot = 3); s -> x;").replace(
        "model M", "model Outer { port p in; slot : Lock[1] = Stiff[1]; p -> slot; } model M")],
    "BG238": ["model M { for i in 1..2 { state x = 0; } }"],
    "BG239": ["model M { param a = 3 in 0 .. 1; }"],
    # bonds and ports
    "BG400": [chain("param v = 1; s -> v;"), chain("s -> j[1, 2];")],
    "BG401": [chain("x : Load; s -> x.x;")],
    "BG402": ["model T { port a in; port b in; x : R(1); y : R(1); a -> x; b -> y; }"
              "model M { s : Se(e = 1); t : T; s -> t; }"],
    "BG403": [chain("x : Load; x -> j;"), chain("x : Supply; s -> x;")],
    "BG404": ["model T { port a in; x : J1; x -> a; } model M { s : Se(e = 1); t : T; s -> t; }",
              chain("x : Load; x.p -> j;")],
    "BG405": [chain("x : R(1); x -> j; s -> j;")],
    "BG406": [chain("x : R(1); s -> x; j -> x;"),
              chain("x : Load; s -> x.p; j -> x.p;")],
    "BG407": ["model M { x : R(1); }", chain("x : Load; s -> j;"),
              "model T { port a in; } model M { s : Se(e = 1); t : T; s -> t; }",
              "model M { port a in; x : R(1); a -> x; }"],
    "BG408": ["model T { port p; x : Se(e = 1); x -> p; } "
              "model M { s : Se(e = 1); t : T; s -> t; }"],
    "BG409": ["model T { port a in; port b out; a -> b; } model M { t : T; t -> t; }"],
    "BG410": [chain("x : R[2](1); k : J1[3]; z : R(1); s -> z; k -> x;"),
              chain("x : Stiff[2]; f : Se[3](e = 0); f -> x; z : R(1); s -> z;")],
    "BG411": [chain("x : R[3](1); m : Mux; s -> m; j -> m; m -> x;")],
    "BG412": ["model M { s : Se[2](e = 0); h : J1; x : R(1); y : R(1); s -> h; h[1..1] -> x;"
              " h[3] -> y; }"],
    "BG413": [PARTS + "model A { port p in : Shaft; x : R(1); p -> x; }"
              "model M { s : Supply; a : A; s -> a; }"],
    "BG414": [chain("t : Se(e = 5 V); u : Se(e = 2 N); n : J1; z : R(1); y : R(1);"
                    "t, u -> n -> z; s -> y;")],
    "BG456": ['model M { const k = 2; state x = 1; der(x) = 1; assert k > 3, "small"; }',
              'model M { state x = 1; der(x) = 1; assert cos(0.3) > 1, "never"; }'],
    "BG241": ["model M { r = R(3); }"],
    "BG447": [f"model M {{ state x = 1; der(x) = 1; param k = 4; s : Se[2](e = 1); r : R[{n}](1);"
              f"g : MGY {{ {law} }} s -> g -> r; }}"
              for n, law in ((2, "f1 = [[1, 2], [2, 4]]*e2;"), (2, "f1 = [[1, 2], [2, k]]*e2;"),
                             (2, "f2 = [[1, x], [0, 1]]*e1;"), (1, "f2 = [[1, 2]]*e1;"))],
    "BG240": ["model M { param m = 1 t in 100 t .. 0 t; r : R(m); s : Se(e = 1); s -> r; }"],
    "BG632": [scene("solver rodas5p(tolerance = 1e-6);")],
    "BG423": [chain("m : I(2 kg); t : Se(e = 5 V); t -> m; z : R(1); s -> z;")],
    "BG415": ["domain D { effort a; effort b; flow c; } model M { port p : D; x : R(1); p -> x; }"],
    "BG416": ["domain D { effort a : N; flow c : m; } model M { port p : D; }"],
    "BG417": [chain("x : Lock[1] = Stiff[2]; s -> x;")],
    "BG418": ["model M { for i in 1..50000 { for j in 1..50 { let a = 1; } } }"],
    "BG419": [chain("x : R(1); s -> j -> x; let a = x.q;"),
              chain("x : R(1); s -> j -> x; let a = j.e;"),
              chain("x : Load; s -> x; let a = x.p.T;")],
    # signals along bonds
    "BG420": [PARTS + "model A { port p in : Electric; x : R(1 ohm); p -> x; output m = p.mark; }"
              "model M { s : Supply; a : A; s -> a; }"],
    "BG421": [PARTS + "model W { port p out : Electric; s : Se(e = 1 V); s -> p; p.mark = 3; }"
              "model A { port p in : Electric; x : R(1 ohm); p -> x; output m = p.mark; }"
              "model M { v : W; w : W; j : J1; a : A; v -> j; w -> j; j -> a; }"],
    "BG422": ["model M { param k = 2; k = 3; }"],
    # laws
    "BG430": [chain("x : Load { e = f; } s -> x;")],
    "BG431": [chain(f"x : {kind}; s -> x;") for kind in ("C", "I", "R", "IC")]
    + ["model M { x : Se; y : R(1); x -> y; }", chain("x : TF; y : R(1); s -> x -> y;")],
    "BG432": [chain("x : R(2) { e = 3*f; } s -> x;"), chain("x : MTF(2) { f2 = f1; } y : R(1);"
              " s -> x -> y;"), "model M { x : Se(e = 1) { e = 2; } y : R(1); x -> y; }"],
    "BG433": [chain("x : C { f = 2*p; } s -> x;"), chain("x : R { H = f^2; } s -> x;"),
              chain("x : TF { q = f1; } y : R(1); s -> x -> y;")],
    "BG434": [chain("x : C { e = 2*f; } s -> x;"), chain("x : R { e = 2*q; } s -> x;"),
              chain("x : TF { f2 = e1; } y : R(1); s -> x -> y;"),
              chain("x : C { H = e^2; } s -> x;")],
    "BG435": [chain("param f = 3; x : R { e = 2*f; } s -> x;")],
    "BG436": [chain("x : MTF { f2 = f1^2; } y : R(1); s -> x -> y;"),
              chain("x : C { q = e^3; } s -> x;")],
    "BG437": [chain("x : R[2] { e[1] = f[1]; } y : Se[2](e = 0); y -> x; z : R(1); s -> z;"),
              chain("x : R[1] { e[1] = f[1]; e[1] = f[1]; } s -> x;")],
    "BG438": [chain("x : R { e = 2*f; f = e/2; } s -> x;"),
              chain("x : TF { f2 = f1; e1 = e2; } y : R(1); s -> x -> y;")],
    "BG439": [chain("x : R[2](eye(3)); y : Se[2](e = 0); y -> x; z : R(1); s -> z;"),
              chain("x : C[2] { H = q; } y : Se[2](e = 0); y -> x; z : R(1); s -> z;")],
    "BG440": [chain("x : R(1 + time); s -> x;"), chain("x : TF(1 + time); y : R(1); s -> x -> y;"),
              chain("x : R { e = time*f; } s -> x;")],
    "BG441": [chain("x : C(1 + time); s -> x;"),
              chain("x : I { H = p^2*(2 + sin(time)); } s -> x;")],
    "BG442": ["model M { s : Se[2](e = 0); h : J1; c : I[2](1); x : MGY { e = [[0, 1], [1, 0]]*f; }"
              " s -> h -> x; h -> c; }"],
    "BG443": [chain("x : TF(2); s -> x;"), chain("x : GY(2); s -> x;"),
              "model M { x : TF(2); y : R(1); x -> y; }"],
    "BG444": [chain("x : MTF { f2 = 2*f1; f1 = 3*f2; } y : R(1); s -> x -> y;")],
    "BG446": [chain("x : C(1, p0 = 3); s -> x;"), chain("x : R(1, q0 = 3); s -> x;")],
    "BG455": [chain("k : J1 { e = f; } x : R(1); s -> k -> x;")],
    # equations
    "BG450": ["model M { let x = 1; der(x) = 1; }", "model M { param x = 1; project x = 1; }"],
    "BG451": ["model M { state x = 1; }"],
    "BG452": ["model M { unknown z = 0; }",
              "model M { unknown z = 0; equation z = 1; equation z = 2; }"],
    "BG453": ["model M { }"],
    "BG454": [chain("x : R[3](1); m : Mux[1, 1, 1]; s -> m; j -> m; m -> x;")],
    # scenes
    "BG602": ["model M[n] { }"],
    "BG603": [scene("set coil = 3;"), scene("use coil = R;"), scene("drive R = 3;"),
              scene("set supply.e = 3;")],
    "BG610": [scene("device h = trace(file = \"a\"); observe h.force as x;"),
              scene("device h = trace(file = \"a\"); drive h.position = [0, 0, 0];")],
    "BG611": [scene("device h = trace(); device h = trace();"), scene("device coil = trace();")],
    "BG612": [scene("device h = trace(3);"), scene("solver rk4(3);")],
    "BG620": [scene("observe 2*coil.f;")],
    "BG621": [scene("observe coil.f, loop.f as a, coil.p as a;")],
    "BG622": [scene("observe energy.kinetic;")],
    "BG623": [scene("observe coil.f; plot coil.p;")],
    "BG630": [scene("run 0 s;"), scene("step -1 ms;"), scene("require coil.f within 0;")],
    "BG631": [scene("run 1 s; run 2 s;")],
    # of other modules, raised here
    "BG341": [RLC + "model Unused { let a = twice(3); }" + "scene s of RLC { }"],
    "BG306": ["model M { param mass : kg = 3 m; }", scene("run 3 m;"),
              chain("x : C(1 F, q0 = 2 m); s -> x;"),
              "model M { state x : m = 0; der(x) = 1 kg; }"],
    "BG330": ["model M { param n = 3; for i in 1..n { a[i] : J1; } }",
              "model M { param a = 1; if a > 0 { let b = 1; } }"],
    "BG332": ["model M { param a = time; }", "model M { param a = 1; const b = a; }"],
    "BG315": ["model M { param a[3] = [1, 2]; }",
              "model M { state x[2] = 0; der(x) = [1, 2, 3]; }"],
}  # fmt: skip


CASES = [
    pytest.param(code, text, id=f"{code}-{number}")
    for code, texts in WRONG.items()
    for number, text in enumerate(texts)
]


def codes_of(text: str) -> set[str]:
    try:
        elaborate(load_text(text, "wrong.bg"))
    except BgError as err:
        return {d.code for d in err.diagnostics if d.severity is Severity.ERROR}
    return set()


@pytest.mark.parametrize(("code", "text"), CASES)
def test_mistake_gives_its_code_and_no_other(code: str, text: str):
    assert codes_of(text) == {code}


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
