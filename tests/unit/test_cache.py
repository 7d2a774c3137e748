import os
import time
from pathlib import Path

import pytest

from bgc.building import recall
from bgc.building.build import Unit, _shared_key, _unit_key
from bgc.building.build_result import Built, RunFacts
from bgc.building.cache import Cache, digest_of, open_cache, read_note, write_note
from bgc.building.toolchain import Toolchain
from bgc.building.user_folder import cache_directory
from bgc.diagnostics.diagnostic import Diagnostic, Label, Severity
from bgc.diagnostics.source import Source, Span
from bgc.language.scene import Plot
from bgc.language.solver import Solver
from bgc.options import Options
from bgc.resolution.resolve import library_folder

FACTS = RunFacts(
    "s",
    "M",
    ("a", "b[1]"),
    solver=Solver("rk4", step=0.1),
    step=0.1,
    plots=(Plot(("a", "b[1]")), Plot(("a",), "b[1]")),
)


@pytest.fixture
def cache(monkeypatch, tmp_path) -> Cache:
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "cache"))
    return open_cache()


def published(cache: Cache, content: bytes = b"machine code") -> Path:
    made = cache.root / "made"
    made.write_bytes(content)
    return cache.publish("models", "k.so", made)


# --- where it is ---------------------------------------------------------------------------


def test_directory_follows_the_users_settings(monkeypatch, tmp_path):
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "mine"))
    assert cache_directory() == tmp_path / "mine"
    monkeypatch.delenv("BGC_CACHE_DIR")
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_directory() == tmp_path / "xdg" / "bgc"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_directory() == tmp_path / ".cache" / "bgc"


def test_unwritable_directory_gives_a_temporary_cache_and_a_warning(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "file" / "cache"))
    cache = open_cache()
    assert [w.code for w in cache.warnings] == ["BG054"]
    assert cache.warnings[0].severity is Severity.WARNING
    assert published(cache).is_file()


# --- blobs ----------------------------------------------------------------------------------


def test_a_blob_is_found_again(cache):
    path = published(cache)
    assert cache.blob("models", "k.so") == path
    assert path.read_bytes() == b"machine code"


def test_a_damaged_or_half_published_blob_counts_as_absent(cache):
    path = published(cache)
    path.write_bytes(b"machine c0de")
    assert cache.blob("models", "k.so") is None
    published(cache)
    path.with_name("k.so.sum").unlink()
    assert cache.blob("models", "k.so") is None


def test_prune_removes_only_what_is_long_unused(cache):
    path = published(cache)
    cache.prune()
    assert path.is_file()
    long_ago = time.time() - 100 * 24 * 3600
    os.utime(path, (long_ago, long_ago))
    (cache.root / "making-x").mkdir()
    os.utime(cache.root / "making-x", (long_ago, long_ago))
    cache.prune()
    assert [p.name for p in cache.root.rglob("*")] == ["models"]


def test_digests_tell_where_texts_end():
    assert digest_of(("ab", "c")) != digest_of(("a", "bc"))


def test_what_a_unit_is_compiled_with_tells_its_object_apart():
    keys = {
        _unit_key(_shared_key(Toolchain(("cc",), "gcc", version)), unit)
        for version in ("12", "13")
        for files in ((), (("more.h", b"1"),), (("more.h", b"2"),))
        for unit in (Unit("m", "int x;", flags, files=files) for flags in (("-O1",), ("-O2",)))
    }
    assert len(keys) == 12


def test_a_damaged_note_counts_as_absent(cache):
    write_note(cache.root, "k", {"a": 1})
    assert read_note(cache.root, "k") == {"a": 1}
    (cache.root / "notes" / "k.json").write_text('{"a": ')
    assert read_note(cache.root, "k") is None


# --- warm starts ------------------------------------------------------------------------------


@pytest.fixture
def model(tmp_path) -> Path:
    path = tmp_path / "rlc.bg"
    path.write_bytes(b"model A {}\r\nmodel B {}\n")
    return path


def remember(cache: Cache, model: Path) -> Built:
    source = Source(str(model), model.read_bytes().decode())
    span = Span(source, 6, 7)
    label = Label(Span(source, 18, 19), "here")
    warning = Diagnostic("BG299", Severity.WARNING, "m", span, "n", (label,), "h")
    built = Built(published(cache), FACTS, (warning,))
    recall.remember(cache, model, Options(), (source,), built)
    return built


def test_an_equal_request_is_recalled_with_its_facts_and_warnings(cache, model):
    built = remember(cache, model)
    found = recall.recall(model, Options())
    assert found is not None and found.warm
    assert (found.library, found.facts) == (built.library, FACTS)
    (warning,) = found.warnings
    assert (warning.span.text, warning.labels[0].span.text) == ("A", "B")
    assert warning == built.warnings[0]


def test_another_request_is_not(cache, model, monkeypatch):
    remember(cache, model)
    assert recall.recall(model, Options(scene="other")) is None
    assert recall.recall(model, Options(overrides=(("a", "1"),))) is None
    monkeypatch.setenv("CC", "clang")
    assert recall.recall(model, Options()) is None


def test_a_changed_file_is_not(cache, model):
    remember(cache, model)
    model.write_text("model C {}\n")
    assert recall.recall(model, Options()) is None


def test_another_compiler_is_not(cache, model, monkeypatch):
    remember(cache, model)
    monkeypatch.setattr(recall, "_compiler_identity", lambda: "newer")
    assert recall.recall(model, Options()) is None


def test_a_file_that_changed_while_compiling_is_not_remembered(cache, model):
    source = Source(str(model), "model Old {}\n")
    built = Built(published(cache), FACTS)
    recall.remember(cache, model, Options(), (source,), built)
    assert recall.recall(model, Options()) is None


def test_files_of_the_library_are_found_where_it_is_installed(cache, model):
    path = next(library_folder().rglob("*.bg"))
    name = f"library/{path.relative_to(library_folder()).as_posix()}"
    sources = [Source(name, path.read_text()), Source(str(model), model.read_bytes().decode())]
    recall.remember(cache, model, Options(), sources, Built(published(cache), FACTS))
    assert recall.recall(model, Options()) is not None


@pytest.mark.parametrize("damage", ["{", "[]", '{"files": [], "model": "k.so"}', "null", "3"])
def test_damaged_notes_are_not_recalled(cache, model, damage):
    remember(cache, model)
    (note,) = (cache.root / "notes").glob("*.json")
    note.write_text(damage)
    assert recall.recall(model, Options()) is None


def test_a_damaged_library_is_not_recalled(cache, model):
    built = remember(cache, model)
    built.library.write_bytes(b"damaged")
    assert recall.recall(model, Options()) is None
