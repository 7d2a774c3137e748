"""Lark's parser: its tables are current, and recovery from an error keeps each statement once."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

import lark
import pytest
from model_files import model_text

from bgc.diagnostics.source import Source, Span
from bgc.grammar import lark_parser, syntax
from bgc.grammar.parse import parse, parse_with_tokens

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "library").rglob("*.bg")) + sorted((ROOT / "tests/models").rglob("*.bg"))


@cache
def built() -> lark.Lark:
    return lark_parser.build_parser()


@pytest.fixture
def kept() -> dict[str, Any]:
    return json.loads((ROOT / "grammar/bgc.lark.json").read_text("utf-8"))


def plain(node: Any) -> object:
    """A parse tree as lists, with the places of its tokens."""
    if isinstance(node, lark.Tree):
        return [str(node.data), *map(plain, node.children)]
    return node if node is None else (node.type, str(node), node.start_pos, node.end_pos)


# --- tables -----------------------------------------------------------------------------------


def test_tables_are_those_of_the_grammar(kept: dict[str, Any]) -> None:
    """Else write them again: `python -m bgc.grammar.lark_parser`."""
    grammar = lark_parser._fingerprint().split(", ")[1]
    assert kept["written_for"].split(", ")[1] == grammar


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_tables_read_as_the_grammar_does(path: Path) -> None:
    text = path.read_text("utf-8")
    loaded = lark_parser.lark_parser().parse(text, start="file")
    assert plain(loaded) == plain(built().parse(text, start="file"))


@pytest.mark.slow
def test_tables_are_the_same_bytes_in_each_process(tmp_path: Path, kept: dict[str, Any]) -> None:
    paths = [tmp_path / f"{seed}.json" for seed in (1, 2)]
    for seed, path in enumerate(paths, 1):
        command = "import sys; from pathlib import Path; from bgc.grammar import lark_parser as p;"
        command += "p.write_tables(Path(sys.argv[1]))"
        environment = {**os.environ, "PYTHONHASHSEED": str(seed)}
        subprocess.run([sys.executable, "-c", command, path], check=True, env=environment)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    written = json.loads(paths[0].read_text("utf-8"))
    assert written.keys() == kept.keys()
    if written["written_for"] == kept["written_for"]:
        assert written["data"]["parser"]["parser"] == kept["data"]["parser"]["parser"]


@pytest.mark.slow
def test_tables_of_another_lark_are_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lark_parser, "__version__", "1.2.99")
    monkeypatch.setattr(lark_parser.Lark, "load", None)  # calling it fails
    parser = lark_parser.lark_parser.__wrapped__()
    assert plain(parser.parse("model M { }", start="file")) == plain(
        built().parse("model M { }", start="file")
    )


def test_parsing_keeps_nothing_in_the_cache(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path))
    lark_parser.lark_parser.cache_clear()
    parse(Source("test.bg", "model M { }"))
    assert list(tmp_path.iterdir()) == []


# --- tokens -----------------------------------------------------------------------------------


def test_words_are_names_where_they_have_no_meaning() -> None:
    text = "model run { param step = 1; param of : 1/s = keep[step]; keep : R(is == every); }"
    _, tokens, found = parse_with_tokens(Source("test.bg", text))
    assert not found
    kinds = {str(token): token.type for token in tokens}
    words = ("run", "step", "of", "keep", "is", "every")
    assert {kinds[word] for word in words} == {"NAME"}
    assert (kinds["param"], kinds["1/s"], kinds["=="]) == ("PARAM", "UNIT", "COMPARE")


SOFT = (
    *("is", "start", "rest", "hold", "vary", "shape", "at", "from", "to", "colour", "proof"),
    *("when", "reset", "sample", "next", "offset"),
)


@pytest.mark.parametrize("word", SOFT)
def test_a_soft_word_is_a_name_everywhere(word: str) -> None:
    text = f"""model M {{
      {word} : R(1); {word}[2] : R(3*{word}); other : C({word} = 2); n : J1;
      n -> {word}, other; {word} -> n; a, {word} -> b -> {word}; {word} -> a, b;
      let x = {word} + 2*{word}.e - {word}[1]; param {word} : m = 4 m; state y = {word};
      {word} = 3; {word}.x = {word}.y + {word}; {word}[1] = 3;
      shape sphere({word}) at {word} colour "red"; shape rope from {word} to {word};
    }}
    scene {word} of M {{
      observe {word} as {word}_flow, {word}.e in deg; plot {word}; set {word} = 3; set {word}.x = 1;
      drive {word} = 2; keep {word}; start rest hold {word}, {word}.q vary {word}; run 1 s;
    }}
    scene other is {word} {{ run 1 s; proof "1f"; }}"""
    file, tokens, found = parse_with_tokens(Source("test.bg", text))
    assert not found
    kinds = [token.type for token in tokens if str(token) == word]
    own = {"shape": 2, **dict.fromkeys(("is", "start", "rest", "hold", "vary", "proof"), 1)}
    own |= dict.fromkeys(("at", "from", "to", "colour"), 1)
    assert kinds.count(word.upper()) == own.get(word, 0)
    assert {*kinds} <= {"NAME", word.upper()}
    model = file.declarations[0]
    assert isinstance(model, syntax.Model)
    assert [type(item).__name__ for item in model.items] == (
        "Part Part Part Part Chain Chain Chain Chain Value Value Value"
        " Assign Assign Assign Shape Shape"
    ).split()


def test_a_start_at_rest_is_read() -> None:
    file, found = parse(
        Source("t", "scene a of M { start rest hold a.b, c[2] vary d; start rest; }")
    )
    assert not found
    (scene,) = file.declarations
    assert isinstance(scene, syntax.Scene)
    first, second = scene.items
    assert isinstance(first, syntax.Start) and isinstance(second, syntax.Start)
    assert [p.span.text for p in (*first.hold, *first.vary)] == ["a.b", "c[2]", "d"]
    assert (second.hold, second.vary) == ((), ())


# --- recovery ---------------------------------------------------------------------------------


def recovered(text: str) -> tuple[tuple[syntax.Declaration, ...], list[str]]:
    """Parse a text with errors; return the tree and their codes."""
    file, found = parse(Source("test.bg", text))
    return file.declarations, [d.code for d in found]


def without_places(node: Any) -> object:
    """A syntax tree as lists, without its spans, and documentation before an error."""
    if isinstance(node, Span):
        return None
    if is_dataclass(node):
        values = (getattr(node, f.name) for f in fields(node) if f.name != "doc")
        return [type(node), *map(without_places, values)]
    return [*map(without_places, node)] if isinstance(node, tuple) else node


def test_all_before_and_behind_an_error_is_kept_once() -> None:
    """In every block of the language: models, branches, laws, domains, scenes, and between them."""
    text = model_text("everything")
    file, tokens, _ = parse_with_tokens(Source("test.bg", text))
    whole = without_places(file.declarations)
    ends = [token.end_pos for token in tokens if token == ";"]
    parts = [text[i:k] for i, k in itertools.pairwise([0, *ends, len(text)])]
    for place in range(1, len(parts)):
        found, codes = recovered("".join(parts[:place]) + " x = ; " + "".join(parts[place:]))
        assert without_places(found) == whole and len(codes) == 1
    some = len(parts) // 2  # all at once are more errors than are read past
    found, codes = recovered(" x = ; ".join(parts[:some]) + "".join(parts[some:]))
    assert without_places(found) == whole and len(codes) == some - 1 > 30
    starts = [declaration.span.start for declaration in file.declarations]
    parts = [text[i:k] for i, k in itertools.pairwise([0, *starts[1:], len(text)])]
    found, codes = recovered(" model { } ".join(parts))
    assert without_places(found) == whole and len(codes) == len(parts) - 1


@pytest.mark.parametrize("wrong", ["let = 1;", "let x 1;", "b : ;", "-> c;", "for i { d : R; }"])
def test_each_item_before_and_behind_an_error_is_kept_once(wrong: str) -> None:
    (model,), codes = recovered(f"model M {{ let a = 1; let b = 2; {wrong} let c = 3; {wrong} }}")
    assert isinstance(model, syntax.Model)
    assert [item.name for item in model.items] == ["a", "b", "c"]  # type: ignore[union-attr]
    assert len(codes) == 2


def test_blocks_open_at_the_end_are_closed() -> None:
    (model,), codes = recovered("model M { let a = 1; for i in 1..2 { let b = (1;")
    assert isinstance(model, syntax.Model)
    assert [type(item).__name__ for item in model.items] == ["Value", "For"]
    assert codes == ["BG103", "BG105"]


@pytest.mark.slow
def test_a_model_of_many_statements_is_read() -> None:
    count = 20_000
    (model,), codes = recovered("model M {" + "let a = 1;\n" * count + "}")
    assert isinstance(model, syntax.Model)
    assert (len(model.items), codes) == (count, [])
