"""Syntax trees as JSON, and the trees of unchanged files in the cache."""

import errno
import json
from fractions import Fraction
from pathlib import Path

import pytest

from bgc.building.cache import Cache
from bgc.diagnostics.source import Source
from bgc.grammar.parse import parse
from bgc.grammar.tree_json import tree_from_json, tree_to_json
from bgc.resolution import parse_cached as module
from bgc.resolution.parse_cached import parse_cached

ROOT = Path(__file__).parents[2]
FILES = sorted([*ROOT.glob("library/**/*.bg"), *ROOT.glob("tests/models/**/*.bg")])
TEXT = "model A { param k : N/m = 1/3*2.5e3 N/m; x : C(k); r : R(1); n : J0; n -> x, r; }\n"


@pytest.mark.parametrize("path", FILES[:: len(FILES) // 40], ids=lambda path: path.stem)
def test_a_tree_read_back_is_the_tree_of_the_text(path):
    source = Source(path.name, path.read_text(encoding="utf-8"))
    file, diagnostics = parse(source)
    assert not diagnostics
    text = tree_to_json(file)
    again = tree_from_json(text, source)
    assert again == file
    assert repr(again) == repr(file)  # with the types of all numbers
    assert _spans(again) == _spans(file)
    assert tree_to_json(again) == text


def _spans(file):
    return [(d.span.start, d.span.end, d.name_span.text) for d in file.declarations]


def test_every_node_of_a_tree_refers_to_the_source_that_was_given():
    source = Source("a.bg", TEXT)
    again = tree_from_json(tree_to_json(parse(Source("b.bg", TEXT))[0]), source)
    value = again.declarations[0].items[0].value
    assert value.span.source is source
    assert value.span.text == "1/3*2.5e3 N/m"
    assert value.right.value == Fraction(2500)


def test_a_chain_longer_than_the_limit_of_recursion_is_written_and_read():
    source = Source("a.bg", f"const a = {' + '.join(['1'] * 5000)};\n")
    file, diagnostics = parse(source)
    assert not diagnostics
    again = tree_from_json(tree_to_json(file), source)
    assert len(again.declarations[0].value.links()) == 4999


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "cache"))
    parse_cached.cache_clear()
    yield tmp_path / "cache" / "trees"
    parse_cached.cache_clear()


def again(source):
    parse_cached.cache_clear()
    return parse_cached(source)


def refuse_to_parse(monkeypatch):
    monkeypatch.setattr(module, "parse", lambda _: pytest.fail("it was parsed"))


def test_a_text_is_parsed_once_whatever_its_name(folder, monkeypatch):
    first = parse_cached(Source("a.bg", TEXT))
    refuse_to_parse(monkeypatch)
    assert again(Source("a.bg", TEXT)) == first
    assert again(Source("b.bg", TEXT))[0].source.name == "b.bg"
    assert (folder.parent.stat().st_mode & 0o077) == 0


def test_another_text_or_parser_is_parsed_anew(folder, monkeypatch):
    parse_cached(Source("a.bg", TEXT))
    again(Source("a.bg", TEXT.replace("1/3", "2/3")))
    assert len(list(folder.glob("*.json"))) == 2
    monkeypatch.setattr(module, "_parser_identity", lambda: "newer")
    again(Source("a.bg", TEXT))
    assert len(list(folder.glob("*.json"))) == 3


def test_a_text_with_a_diagnostic_is_not_kept(folder):
    assert parse_cached(Source("a.bg", "model A { x : ; }\n"))[1]
    assert not folder.exists()


@pytest.mark.parametrize("damage", [b"", b"{}", b"\xff\xfe", b"[1, 2"])
def test_a_damaged_tree_is_parsed_anew_and_repaired(folder, monkeypatch, damage):
    first = parse_cached(Source("a.bg", TEXT))
    (kept,) = folder.glob("*.json")
    kept.write_bytes(damage)
    assert again(Source("a.bg", TEXT)) == first
    refuse_to_parse(monkeypatch)
    assert again(Source("a.bg", TEXT)) == first


@pytest.mark.parametrize(
    "change",
    [
        lambda tree: tree["nodes"].pop(),
        lambda tree: tree["nodes"][-1].append(10**9),
        lambda tree: tree["kinds"].append("Unheard"),
        lambda tree: tree["spans"].pop(),
        lambda tree: tree.pop("constants"),
    ],
)
def test_a_tree_of_another_layout_with_its_checksum_is_parsed_anew(folder, change):
    first = parse_cached(Source("a.bg", TEXT))
    (kept,) = folder.glob("*.json")
    tree = json.loads(kept.read_text())
    change(tree)
    aside = folder / "aside"
    aside.write_text(json.dumps(tree))
    Cache(folder.parent).publish("trees", kept.name, aside)
    assert again(Source("a.bg", TEXT)) == first


def test_a_full_disk_only_costs_the_next_run_some_time(folder, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Cache, "publish", full)
    file, diagnostics = parse_cached(Source("a.bg", TEXT))
    assert file.declarations
    assert not diagnostics
    assert not list(folder.parent.rglob("*.json"))


def test_a_cache_that_others_may_write_to_is_neither_read_nor_written(folder, monkeypatch):
    parse_cached(Source("a.bg", TEXT))
    folder.parent.chmod(0o777)
    calls = []
    monkeypatch.setattr(module, "parse", lambda source: calls.append(source) or parse(source))
    again(Source("a.bg", TEXT))
    again(Source("b.bg", TEXT.replace("1/3", "2/3")))
    assert len(calls) == 2
    assert len(list(folder.glob("*.json"))) == 1
