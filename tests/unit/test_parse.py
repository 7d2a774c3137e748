"""The parser: trees of what it reads."""

from __future__ import annotations

import pytest
from parsed import EVERYTHING, items, read, show

from bgc.grammar import syntax
from bgc.grammar.lark_parser import build_parser


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
        ("[1, -a]", "[1,(-a)]"),
        ("[1, -2] m/s", "[1_m/s,(-2_m/s)]"),
        ("[[1, 2], [3, 4]] 1/s", "[[1_1/s,2_1/s],[3_1/s,4_1/s]]"),
        ("[1, 2] m * l", "([1_m,2_m]*l)"),
    ],
)
def test_expression(text: str, shown: str) -> None:
    assert show(expression(text)) == shown


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
