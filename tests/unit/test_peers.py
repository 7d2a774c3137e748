"""Words and statements of other tools are answered with the way to write them here."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from manual import whole_manual

from bgc.driver import check_source
from bgc.grammar.peers import _PARTS, _STORES, element_advice
from bgc.language.elements import ELEMENTS
from bgc.resolution.resolve import _library_index


def helps(tmp_path: Path, text: str) -> str:
    file = tmp_path / "m.bg"
    file.write_text(text)
    return "\n".join(diagnostic.help for diagnostic in check_source(file))


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("R r(2);", "`r : R(..);`"),
        ("R r;", "`r : R;`"),
        ("connect(r.p, c.p);", "`r.p -> c.p;`"),
        ("a -- b;", "`a -> b;`"),
        ("a <- b;", "`b -> a;`"),
        ("1-junction j;", "`j : J1;`"),
        ("left, right : C(1);", "`left : C; right : C;`"),
        ("j : 0;", "`j : J0;`"),
        ("state x = 1; x' = -x;", "`der(x)`"),
        ("state x = 1; dx/dt = -x;", "`der(x) = ..;`"),
        ("Real x(start = 1);", "`state x = 0;`"),
        ("var x = 3;", "`state x = 0;`"),
        ("initial x = 3;", "`state x = ..;`"),
        ("state x = 1; der(x) = -x; end M;", "a block ends with `}`"),
        ("j : OneJunction;", "`J1`"),
        ("j : one_junction;", "`J1`"),
        ("m : Mass(3 kg);", "`I`"),
        ("s : Se(e = sin(t));", "the time is `time`"),
    ],
)
def test_a_statement_of_a_peer_gets_advice(tmp_path, text: str, advice: str) -> None:
    assert advice in helps(tmp_path, f"model M {{ {text} }}")


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        # Modelica
        ("parameter Real k = 3;", "`param k = value;`"),
        ("param Real k = 3;", "`param k = value;`"),
        ("Boolean b = true;", "`param b = value;`"),
        ("equation connect(r.p, c.p);", "`r.p -> c.p;`"),
        ("Modelica.Electrical.Analog.Basic.Resistor r(R = 1);", "`r : Resistor(..);`"),
        ("extends Base;", "`model Name is Base { .. }`"),
        ("replaceable Spring s;", "`s : Interface = Spring;`"),
        ("initial equation x = 3;", "`state x = ..;`"),
        ("protected param k = 3;", "leave the word out"),
        ("param x[3] = {1, 2, 3};", "`[1, 2, 3]`"),
        ("algorithm x := 3;", "`let y = ..;`"),
        ("let y = pre(1);", "`sample`"),
        ("let y = noEvent(1);", "its argument alone"),
        ("let y = Modelica.Math.sin(1);", "`sin(..)`"),
        ("let y = inf;", "`1e30`"),
        # 20-sim, Simscape, MATLAB, Julia, Python
        ("{ a comment }", "`//`"),
        ("% a comment", "`//`"),
        ("real x;", "`state x = 0;`"),
        ("let y = int(1);", "`state s = 0; der(s) = x;`"),
        ("let y = if 1 > 0 then 1;", "`if a then b else c`"),
        ("let y = if 1 > 0 then 1 elseif 2 > 1 then 3 else 2;", "`else if condition`"),
        ("state x = 1; der(x) = if x > 0 then 1 else 2 end;", "a block ends with `}`"),
        ("let y = 1 > 0 ? 1 : 2;", "`if a then b else c`"),
        ("let y = 1 if 2 > 1 else 2;", "`if a then b else c`"),
        ("if 1 == 1 { } elif 2 == 2 { }", "`else if condition`"),
        ("let y = 1 ~= 2;", "`!=`"),
        ("let y = 1 <> 2;", "`!=`"),
        ("param k := 3;", "with `=`"),
        ("param v = [1 2 3];", "by commas: `[1, 2]`"),
        ("param x[3] = [1, 2, 3]; let y[2] = x[1:2];", "`x[1..3]`"),
        ("param A = eye(3); let y[3] = A[1, :];", "`A[2, 1..3]`"),
        ("param A = [1, 2; 3, 4];", "`[[1, 2], [3, 4]]`"),
        ("state x = 1; der(der(x)) = -x;", "`der(x) = v; der(v) = ..;`"),
        ("state x = 1; ddt(x) = -x;", "`der(x) = ..;`"),
        ("state x = 1; x += 1;", "`der(x) = ..;`"),
        ("assert 1 > 0, 'why';", '`"why"`'),
        ("r R(3);", "`r : R(..);`"),
        ("a : R(3), b : R(4);", "`a : R(..); b : ..;`"),
        ("a : R(3); a.p -> a.n;", "`a`"),
        # numbers, units and letters
        ("param l = 3 \u00b5m;", "`3 um`"),
        ("param l = 3 k\u03a9;", "`3 kohm`"),
        ("param l = 30\u00b0;", "`30 deg`"),
        ("param l = 3 m\u00b2;", "`3 m^2`"),
        ("param l = 3 s\u207b\u00b9;", "`3 s^-1`"),
        ("param l = 3 N\u00b7m;", "`3 N*m`"),
        ("param l = 20 \u00b0C;", "273.15"),
        ("param \u03b80 = 1;", "`theta0`"),
        ("param gr\u00f6sse = 1;", "`grosse`"),
        ("param \u03bc = 1;", "`mu`"),
        ("param l = 10 s-1;", "`10 s^-1`"),
        ("param l = 3 m s^-2;", "`3 m*s^-2`"),
        ("param l = 10 e-3;", "`10e-3`"),
        ("param l = 1.e3;", "`1e3`"),
        ("param l = 4k7;", "`4.7e3`"),
        ("param l = 1,000,000;", "`1000000`"),
        ("param l = 1_000;", "`1000`"),
        ("param l = 1'000;", "`1000`"),
        ("param l = 20 Mpa;", "`MPa`"),
        ("param l = 3 [m];", "`3 m`"),
        ("param l = 3 {m};", "`param l = 3 m;`"),
        ("param l [m] = 3;", "`l : m = ..`"),
        ("param l = 1.5*mm;", "`3 mm`"),
    ],
)
def test_a_mistake_of_the_first_hour_gets_its_way_out(tmp_path, text: str, advice: str) -> None:
    assert advice in helps(tmp_path, f"model M {{ {text} }}")


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("dt = 1 ms;", "`step 1 ms;`"),
        ("StopTime = 3 s;", "`run 3 s;`"),
        ("stop 3 s;", "`run 3 s;`"),
        ("run for 3 s;", "`run 3 s;`"),
        ("tolerance = 1e-6;", "`solver auto(rtol = 1e-6);`"),
        ("k = 3 kg;", "`set k = value;`"),
        ("deadline 1 ms hold;", "`deadline 1 ms, hold;`"),
        ("deadline = 1 ms;", "`deadline 1 ms;`"),
        ("start at rest;", "`start rest;`"),
        ("initial k = 3;", "a scene sets its parameter"),
    ],
)
def test_a_statement_of_a_peer_in_a_scene_gets_advice(tmp_path, text: str, advice: str) -> None:
    model = "model M { param k = 1; s : Se(k); m : I(1); s -> m; }"
    assert advice in helps(tmp_path, f"{model} scene a of M {{ {text} }}")


def test_a_mistake_in_braces_is_reported_once(tmp_path) -> None:
    file = tmp_path / "m.bg"
    file.write_text("model M { param x[3] = {1, 2, 3}; param k = 3; }")
    assert len(list(check_source(file))) == 1


def test_a_model_without_braces_gets_advice(tmp_path) -> None:
    assert "`model M { .. }`" in helps(tmp_path, "model M\n  r : R(2);\nend M;")


def test_the_number_of_a_stiffness_given_as_compliance_is_named(tmp_path) -> None:
    model = "model M {{ s : Se(5 N); j : J1; {} s -> j; j -> c{}; }}"
    alone = helps(tmp_path, model.format("c : C(100 N/m);", ""))
    assert "`stiffness = ..`" in alone
    # Without a source in newton the spring gives the bond its units, and the mass contradicts it.
    first = model.replace("5 N", "5").format("c : C(100 N/m); m : I(2 kg);", ", m")
    assert "`stiffness = ..`" in helps(tmp_path, first)
    resistor = "model M { s : Se(5 V); r : R(3 S); s -> r; }"
    assert "`conductance = ..`" in helps(tmp_path, resistor)
    swapped = "model M { s : Se(5 N); c : C(stiffness = 3 m/N); s -> c; }"
    assert "`compliance = ..`" in helps(tmp_path, swapped)
    neither = helps(tmp_path, model.format("c : C(100 kg);", ""))
    assert "give it by name" not in neither


def test_a_part_of_another_library_names_the_one_here(tmp_path) -> None:
    assert "`Strut`: `import mechanics.translation;`" in helps(
        tmp_path, "model M { s : SpringDamper(c = 3); }"
    )
    spring = helps(tmp_path, "model M { s : Spring(3); }")
    assert "`C`" in spring and "`Strut`" in spring


def test_parts_of_other_libraries_stand_for_parts_that_exist() -> None:
    """Those of messages, and those of the manual's table."""
    chapter = whole_manual().partition("## Parts of other libraries\n")[2].partition("\n#")[0]
    cells = [line.rsplit(" | ", 1)[1] for line in chapter.splitlines() if line.startswith("| ")]
    named = {name for cell in cells for name in re.findall(r"`([A-Z]\w*)(?:\[n\])?`", cell)}
    library = {*_library_index(), *ELEMENTS}
    assert len(named) > 50 and named <= library, named - library
    assert set(_PARTS.values()) <= library, set(_PARTS.values()) - library


def test_the_advice_names_elements_that_exist() -> None:
    for words in _STORES.values():
        for word in words.split():
            assert element_advice(word).split("`")[1] in ELEMENTS
    assert not any(element_advice(name) for name in ELEMENTS)
