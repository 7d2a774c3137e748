"""Words and statements of other tools are answered with the way to write them here."""

from __future__ import annotations

from pathlib import Path

import pytest

from bgc.driver import check_source
from bgc.grammar.peers import _STORES, element_advice
from bgc.language.elements import ELEMENTS


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
        ("a <- b;", "`a -> b;`"),
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


def test_the_advice_names_elements_that_exist() -> None:
    for words in _STORES.values():
        for word in words.split():
            assert element_advice(word).split("`")[1] in ELEMENTS
    assert not any(element_advice(name) for name in ELEMENTS)
