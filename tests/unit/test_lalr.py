"""The reader of texts, against Lark's own parser; its tables in the cache."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import lark
import pytest

import bgc.grammar
from bgc.grammar.lalr import END, Reader, Token, Tree, UnexpectedTokenError
from bgc.grammar.tables import make_parser, tables, tables_of

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "library").rglob("*.bg")) + sorted((ROOT / "tests/models").rglob("*.bg"))


@cache
def larks() -> lark.Lark:
    return make_parser(resources.files(bgc.grammar).joinpath("bgc.lark").read_text("utf-8"))


def read(text: str) -> tuple[list[Token], Any]:
    reader = Reader(tables(), text, "start")
    tokens: list[Token] = []
    while (token := reader.next_token()) is not None:
        reader.feed(token)
        tokens.append(token)
    reader.feed(Token(END, "", len(text)))
    return tokens, reader.values[-1]


def plain(node: Any) -> object:
    """A tree of either kind."""
    if isinstance(node, (Tree, lark.Tree)):
        return [str(node.data), *map(plain, node.children)]
    if isinstance(node, (Token, lark.Token)):
        return (node.type, str(node), node.start_pos, node.end_pos)
    assert node is None
    return None


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_trees_are_those_of_lark(path: Path) -> None:
    text = path.read_text("utf-8")
    _, tree = read(text)
    assert plain(tree) == plain(larks().parse(text, start="start"))


def test_words_are_names_where_they_have_no_meaning() -> None:
    text = "model run { param step = 1; param of : 1/s = keep[step]; keep : R(is == every); }"
    tokens, _ = read(text)
    kinds = {str(token): token.type for token in tokens}
    words = ("run", "step", "of", "keep", "is", "every")
    assert {kinds[word] for word in words} == {"NAME"}
    assert (kinds["param"], kinds["1/s"], kinds["=="]) == ("PARAM", "UNIT", "COMPARE")


def after(text: str) -> Reader:
    reader = Reader(tables(), text, "start")
    while (token := reader.next_token()) is not None:
        reader.feed(token)
    return reader


@pytest.mark.parametrize(
    "text", ["", "model M ", "model M { a", "model M { let x = (1 + 2", "scene"]
)
def test_what_is_accepted_is_what_can_be_fed(text: str) -> None:
    def fed() -> Iterator[str]:
        for kind in (*tables().terminals, END):
            try:
                after(text).feed(Token(kind, "", len(text)))
            except UnexpectedTokenError:
                continue
            yield kind

    assert after(text).accepted() == set(fed())


def test_tables_are_kept_and_read_without_lark(tmp_path: Path) -> None:
    code = (
        "import sys\nfrom bgc.grammar.tables import tables\n"
        "assert len(tables().rules) > 100\nprint('lark' in sys.modules)"
    )
    environment = {"BGC_CACHE_DIR": str(tmp_path), "PATH": "/usr/bin:/bin"}

    def uses_lark() -> str:
        command = [sys.executable, "-c", code]
        done = subprocess.run(
            command, capture_output=True, text=True, check=True, env=environment, cwd=tmp_path
        )
        return done.stdout.strip()

    assert (uses_lark(), uses_lark()) == ("True", "False")
    (kept,) = tmp_path.glob("grammar-*.pickle")
    kept.write_bytes(kept.read_bytes()[:1000])
    assert (uses_lark(), uses_lark()) == ("True", "False")


def test_a_rule_that_stands_for_its_part_leaves_nothing_out() -> None:
    """The reader takes such a rule for its part without looking."""
    grammar = 'start: a\n?a: [B] "c"\nB: "b"'
    with pytest.raises(AssertionError, match="`a` leaves something out"):
        tables_of(lark.Lark(grammar, parser="lalr", maybe_placeholders=True))
