"""The parser: what it refuses, with which words, and that nothing breaks it."""

from __future__ import annotations

from pathlib import Path

import pytest
from parsed import read, wrong

from bgc.diagnostics.collection import MAX_ERRORS
from bgc.diagnostics.source import Source
from bgc.grammar import syntax
from bgc.grammar.language_words import BLOCK_OF, FORMS_IN, RESERVED, WORDS
from bgc.grammar.parse import parse

ROOT = Path(__file__).parents[2]


def wrong_in_model(body: str) -> list[tuple[str, str]]:
    return wrong(f"model M {{ {body} }}")


@pytest.mark.parametrize("word", sorted(RESERVED))
def test_reserved_word_is_no_name(word: str) -> None:
    assert wrong_in_model(f"param {word};") == [("BG112", word)]
    assert wrong_in_model(f"a -> {word};") == [("BG112", word)]
    if word != "time":  # which may be a column of data
        assert wrong_in_model(f"let y = a.{word};") == [("BG112", word)]


def test_one_run_reports_many_errors() -> None:
    body = "let a = 5V;\n b : I(2\n c : R(3);\n let d = x x;\n for i in 1..3 { let e = ; }\n g ->"
    codes = [code for code, _ in wrong_in_model(body)]
    assert codes == ["BG106", "BG103", "BG114", "BG101", "BG101"]


def test_reading_goes_on_after_an_error() -> None:
    file, found = parse(
        Source(
            "test.bg", "model A { let a = 5V; b : I(2); }\n@\nmodel B { } scene s of B { run ; }"
        )
    )
    assert [d.code for d in found] == ["BG106", "BG107", "BG101"]
    names = [d.name for d in file.declarations]
    assert names == ["A", "B", "s"]
    model = file.declarations[0]
    assert isinstance(model, syntax.Model)
    assert len(model.items) == 1


def test_number_of_errors_is_bounded() -> None:
    found = wrong_in_model("x y z;\n" * 1000)
    assert len(found) == MAX_ERRORS + 1
    assert found[-1][0] == "BG121"
    assert wrong("model A { }\n" + "import a;\n" * 1000)[-1][0] == "BG121"


@pytest.mark.parametrize(
    "text",
    [
        "a" * 10_000_000,
        "model A { let x = " + "1+" * 5_000_000 + "1; }",
        "model A { let x = " + "(\n" * 5000,
        "model A { let x = " + "[" * 5000,
        "model A { let x = " + "-" * 5000 + "1; }",
        "model A { let x = " + "not " * 5000 + "1; }",
        "model A { let x = " + "2^" * 5000 + "1; }",
        "model A { let x = " + "sin(" * 5000,
        "model A { let x = a" + ".b" * 5000 + "; }",
        "model A { let x = " + "if a then b else " * 5000 + "1; }",
        "model A { " + "if a { } else " * 5000 + "{ } }",
        "model A { " + "for i in 1..2 { " * 5000 + "}" * 5000,
        "model A { let x = " + "1" * 5000 + "; }",
        "{" * 50_000,
        "}" * 50_000,
        "{;}" * 20_000,
        '"' * 50_001,
        "/*" + "*" * 50_000,
        "\x00" * 1000,
        "\ufeff",
        "model \udc80 { }",
    ],
    ids=lambda text: repr(text[:30]),
)
def test_absurd_text_gets_a_diagnostic(text: str) -> None:
    assert wrong(text)


@pytest.mark.parametrize(
    "text", ["", "\n", "// only a comment", "model A { let x = " + "1\n+ " * 5000 + "1; }"]
)
def test_unusual_text_is_read(text: str) -> None:
    read(text)


def test_every_kind_of_block_has_a_form_for_messages():
    """A statement that no block knows is explained by the form of its block."""
    assert set(WORDS) | set(BLOCK_OF.values()) <= set(FORMS_IN)
