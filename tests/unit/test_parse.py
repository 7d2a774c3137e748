"""The parser: trees of what it reads."""

from __future__ import annotations

from fractions import Fraction

import pytest
from parsed import EVERYTHING, items, read, show

from bgc.grammar import syntax
from bgc.grammar.lark_parser import build_parser
from bgc.grammar.syntax import Call, Index, Number, TypeUse


def expression(text: str) -> syntax.Expr:
    """An expression, as the value of a `let`."""
    (item,) = items(f"let x = {text};")
    assert isinstance(item, syntax.Value)
    assert item.value is not None
    return item.value


def test_grammar_has_no_conflicts() -> None:
    build_parser(strict=True)


def test_whole_language_is_read() -> None:
    file = read(EVERYTHING)
    assert len(file.imports) == 2
    assert [type(d).__name__ for d in file.declarations] == (
        "Value Function Function Domain Domain Model Model Model Scene".split()
    )


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("-2^2", "(-(2^2))"),
        ("2^-1", "(2^(-1))"),
        ("2^3^2", "(2^(3^2))"),
        ("a - b - c", "((a-b)-c)"),
        ("a/b*c", "((a/b)*c)"),
        ("-a*b", "((-a)*b)"),
        ("a + b*c^d", "(a+(b*(c^d)))"),
        ("not a < b and c or d", "(((not(a<b))andc)ord)"),
        ("A[1, 2..3].x", "A[1,2..3].x"),
        ("cross(a, b).z", "cross(a,b).z"),
        ("der(x)", "der(x)"),
        ("time", "time"),
        ("3 m * l", "(3_m*l)"),
        ("2 kg*m/s", "2_kg*m/s"),
        ("2 kg*m/s - 3 N", "(2_kg*m/s-3_N)"),
        ("10 s^-1", "10_s^-1"),
        ("1 Pa^0.5", "1_Pa^0.5"),
        (".5", "1/2"),
        ("1e5", "100000"),
        ("1.5e-3 m", "3/2000_m"),
        ("10/s", "(10/s)"),
        ("10 / s", "(10/s)"),
        ("x[1..3]", "x[1..3]"),
        ("x[a..b + 1]", "x[a..(b+1)]"),
    ],
)
def test_expression(text: str, shown: str) -> None:
    assert show(expression(text)) == shown


def test_numbers_are_exact() -> None:
    value = expression("0.1")
    assert isinstance(value, Number)
    assert value.value == Fraction(1, 10)


def test_words_after_a_number_are_no_units() -> None:
    (item,) = items("param k = 1 in 0 .. 5;")
    assert isinstance(item, syntax.Value)
    assert isinstance(item.value, Number)
    assert item.value.unit is None
    assert item.range is not None
    expression("if a > 1 then 2 else 3 m")


def test_element_letters_are_plain_names() -> None:
    part = items("param C = 10 uF; capacitor : C(C);")[1]
    assert isinstance(part, syntax.Part)
    assert part.type.name == "C"
    items("R : R(R); I : I(e); e -> f -> R; let H = e1*f2 + p + q;")


def test_scene_words_are_names_in_a_model() -> None:
    words = "observe run solver device drive require deadline step keep of is out main as every"
    for word in words.split():
        items(f"{word} : R(2); a -> {word}; let y = {word}.e + 1;")


def test_slot_and_type_use() -> None:
    (slot,) = items("lock : Lock[5] = Compliant[5](k = 1);")
    assert isinstance(slot, syntax.Part)
    assert slot.default is not None
    assert slot.default.name == "Compliant"
    (joint,) = items("j : Joint(lock = Rigid[5](k = 1), a = Rigid(k = 1), b = Rigid[5], c = f(1));")
    assert isinstance(joint, syntax.Part)
    values = [argument.value for argument in joint.type.arguments]
    assert [type(value) for value in values] == [TypeUse, TypeUse, Index, Call]


def test_law_block_may_end_with_a_semicolon() -> None:
    for end in ("", ";"):
        part, port = items(f"r : R {{ e = f; }}{end} port p;")
        assert isinstance(part, syntax.Part)
        assert part.law is not None
        assert isinstance(port, syntax.Port)


def test_chain_keeps_its_lists() -> None:
    (chain,) = items("a, b -> c -> d, e, f;")
    assert isinstance(chain, syntax.Chain)
    assert [len(stop) for stop in chain.stops] == [2, 1, 3]


def test_else_if_nests() -> None:
    (outer,) = items("if a { x -> y; } else if b { } else { y -> x; }")
    assert isinstance(outer, syntax.If)
    (inner,) = outer.no
    assert isinstance(inner, syntax.If)
    assert len(inner.no) == 1


def test_docs_belong_to_what_they_stand_above() -> None:
    text = (
        "/// One.\n///  Two.\n\nmodel A {\n  /// x\n  param k = 1; param l = 2;  /// y\n  port p; }"
    )
    (model,) = read(text).declarations
    assert isinstance(model, syntax.Model)
    assert model.doc == "One.\n Two."
    assert [item.doc for item in model.items] == ["x", "", ""]  # type: ignore[union-attr]


def test_spans_cover_what_was_read() -> None:
    (part,) = items("boom : I[6](mass*(a + b));")
    assert isinstance(part, syntax.Part)
    assert part.span.text == "boom : I[6](mass*(a + b))"
    assert part.name_span.text == "boom"
    assert part.type.arguments[0].value.span.text == "mass*(a + b)"
