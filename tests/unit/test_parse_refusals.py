"""The parser: what it refuses, with which words, and that nothing breaks it."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from parsed import EVERYTHING, read, wrong

from bgc.diagnostics.collection import MAX_ERRORS
from bgc.diagnostics.render import render
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.language_words import BLOCK_OF, FORMS_IN, RESERVED, WORDS
from bgc.grammar.parse import parse, parse_with_tokens

ROOT = Path(__file__).parents[2]


def wrong_in_model(body: str) -> list[tuple[str, str]]:
    return wrong(f"model M {{ {body} }}")


@pytest.mark.parametrize(
    ("text", "underlined", "spelling"),
    [
        ("5V", "5V", "`5 V`"),
        ("2x", "2x", "`2*x`"),
        ("1.", "1.", "`1`"),
        ("1.x", "1.", "`1.0`"),
        ("1.2.3", "1.2.", ""),
        ("3 kN.m", "3 kN.m", "`3 kN*m`"),
        ("10 /s", "10 /s", "`10 s^-1`"),
        ("2 kg *m", "2 kg *m", "`2 kg*m`"),
        ("3  m", "3  m", "`3 m`"),
        ("3 kg m", "3 kg m", "`3 kg*m`"),
    ],
)
def test_misspelt_number_prints_the_right_spelling(
    text: str, underlined: str, spelling: str
) -> None:
    _, found = parse(Source("test.bg", f"model M {{ let y = {text}; }}"))
    assert [d.code for d in found] == ["BG106"]
    assert found[0].span is not None
    assert found[0].span.text == underlined
    assert spelling in found[0].help


@pytest.mark.parametrize("word", sorted(RESERVED))
def test_reserved_word_is_no_name(word: str) -> None:
    assert wrong_in_model(f"param {word};") == [("BG112", word)]
    assert wrong_in_model(f"a -> {word};") == [("BG112", word)]
    if word != "time":  # which may be a column of data
        assert wrong_in_model(f"let y = a.{word};") == [("BG112", word)]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('assert a > 1, "far;', [("BG111", '"far; }')]),
        ("s : A = B { e = f; }", [("BG124", "{ e = f; }")]),
    ],
)
def test_wrong_item(body: str, expected: list[tuple[str, str]]) -> None:
    assert wrong_in_model(body) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("model A { param k = 1;", [("BG105", "")]),
        ("model", [("BG101", "")]),
        ("\0", [("BG107", "\0")]),
    ],
)
def test_ends_of_files_and_null(text: str, expected: list[tuple[str, str]]) -> None:
    assert wrong(text) == expected


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


def mutated(text: str, rng: random.Random) -> str:
    """A part of a text with a few of its characters removed, doubled, moved or replaced."""
    start = rng.randrange(len(text))
    text = text[start : start + 2000] if rng.random() < 0.3 else text
    odd = [
        *"{}()[];:,.=<'\"^@\0\\\r\t",
        "->",
        "..",
        "/*",
        "*/",
        "///",
        "\ufeff",
        "5V",
        "1.",
        "10 /s",
    ]
    odd += [*sorted(RESERVED), "é", "1e999", "\ud800"]
    for _ in range(rng.choice([1, 1, 2, 5])):
        at = rng.randrange(len(text) + 1)
        end = min(len(text), at + rng.choice([0, 1, 2, 30]))
        change = rng.choice(["insert", "remove", "double", "reverse"])
        if change == "insert":
            text = text[:at] + rng.choice(odd) + text[end:]
        elif change == "remove":
            text = text[:at] + text[end:]
        elif change == "double":
            text = text[:end] + text[at:]
        else:
            text = text[:at] + text[at:end][::-1] + text[end:]
    return text


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(200))
def test_mutated_text_never_breaks_the_parser(seed: int) -> None:
    rng = random.Random(seed)
    text = mutated(EVERYTHING, rng)
    source = Source("test.bg", text)
    _, found = parse(source)
    assert len(found) <= MAX_ERRORS + 1
    assert render(found, colour=True) or not found
    for diagnostic in found:
        assert isinstance(diagnostic.span, Span)
        assert 0 <= diagnostic.span.start <= diagnostic.span.end <= len(text)
        own_words = re.sub(r"`[^`]*`|U\+\w+", "", diagnostic.message)
        assert not re.search(r"[A-Z]{2}|__|\$", own_words), diagnostic.message


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100))
def test_mixed_up_tokens_never_break_the_parser(seed: int) -> None:
    rng = random.Random(seed)
    _, tokens, _ = parse_with_tokens(Source("test.bg", EVERYTHING))
    words = [str(token) for token in tokens]
    start = rng.randrange(len(words))
    mixed = words[start : start + rng.choice([30, 300])]
    for _ in range(rng.choice([1, 2, 4])):
        mixed[rng.randrange(len(mixed))] = rng.choice(words)
        mixed.insert(rng.randrange(len(mixed)), rng.choice(words))
    text = "model A { " + " ".join(mixed)
    assert wrong(text)


def test_every_kind_of_block_has_a_form_for_messages():
    """A statement that no block knows is explained by the form of its block."""
    assert set(WORDS) | set(BLOCK_OF.values()) <= set(FORMS_IN)
