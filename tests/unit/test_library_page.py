"""The reference page of the library: its texts, graphs, pictures and links."""

import re
from functools import cache

import pytest
from click.testing import CliRunner

from bgc.grammar import syntax
from bgc.reference import parts
from bgc.reference.library import declarations
from bgc.resolution.library import library_modules, module_path
from bgc.resolution.resolve import load
from bgc.runtime.cli.app import application
from bgc.runtime.documents import library


def documented_models() -> list[str]:
    return [
        d.full_name
        for d in declarations()
        if d.kind in {"model", "interface"}
        and d.module.partition(".")[0] not in {"examples", "scenes"}
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", documented_models())
def test_every_port_and_value_that_a_part_shows_has_its_text(name):
    module, _, last = name.rpartition(".")
    declared = load(module_path(module)).root.models[last]
    shown = [
        item
        for item, owner in parts.members(declared)
        if isinstance(item, syntax.Port)
        or (isinstance(item, syntax.Part) and parts.is_slot(item, owner))
        or (isinstance(item, syntax.Value) and item.kind in {"param", "input", "output", "state"})
    ]
    assert [item.name for item in shown if not parts.text_of(item, declared)] == []


@pytest.mark.slow
def test_the_declarations_that_a_search_finds_are_those_of_the_files():
    for module in library_modules():
        file = load(module_path(module)).root.file
        found = [d for d in declarations() if d.module == module]
        assert [d.name for d in found] == [d.name for d in file.declarations]
        head = parts.file_doc(file.source.text).split()
        for one, other in zip(found, file.declarations, strict=True):
            assert one.doc.split() == other.doc.split() or other.doc.split() == head


# Kept, since a test replaces them by the functions below.
_PAGE, _GRAPHS = library.library_page, library.library_graphs


@cache
def library_page() -> str:
    """The page of the library; the tests share it."""
    return _PAGE()


@cache
def library_graphs() -> dict[str, str]:
    """The graphs of its parts; the tests share them."""
    return _GRAPHS()


def test_the_page_of_the_library_is_current():
    page = module_path("crane.beam").parents[1] / library.PAGE
    assert page.read_text("utf-8") == library_page(), "run `bgc doc --library`"


def test_the_pictures_of_the_library_are_current():
    folder = module_path("crane.beam").parents[1] / library.PICTURES
    graphs = library_graphs()
    kept = {path.stem: library.picture_hash(path.read_bytes()) for path in folder.glob("*.svg")}
    wanted = {name: library.graph_hash(text) for name, text in graphs.items()}
    assert kept == wanted, "run `bgc doc --library`"


@pytest.mark.slow
def test_the_library_is_written_where_it_changed(tmp_path, monkeypatch):
    monkeypatch.setattr(library, "library_page", library_page)
    monkeypatch.setattr(library, "library_graphs", library_graphs)
    monkeypatch.setattr(library, "lay_out", lambda text, kind: b"<!-- by dot --><svg></svg>")
    written = list(library.write_library(tmp_path))
    assert len(written) == len(library_graphs()) + 1
    picture = tmp_path / "pictures" / "crane.beam.Beam.svg"
    assert re.fullmatch(rb"<!-- dot [0-9a-f]{16} -->\n<svg></svg>", picture.read_bytes())
    assert list(library.write_library(tmp_path)) == []
    picture.write_bytes(b"<svg></svg>")
    (tmp_path / "pictures" / "gone.svg").write_bytes(b"")
    assert list(library.write_library(tmp_path)) == [picture]
    assert not (tmp_path / "pictures" / "gone.svg").exists()


def test_without_graphviz_the_library_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    result = CliRunner().invoke(application, ["doc", "--library", "--out", str(tmp_path)])
    assert result.exit_code == 1 and "error[BG056]" in result.stderr


def test_every_link_of_the_page_leads_to_a_heading_or_a_file():
    page = module_path("crane.beam").parents[1] / library.PAGE
    text = re.sub(r"(?s)```.*?```|`[^`\n]*`", "", page.read_text("utf-8"))
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    anchors = [re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings]
    assert len(anchors) == len(set(anchors))
    for link in re.findall(r"\]\(([^)]+)\)", text):
        if link.startswith("#"):
            assert link[1:] in anchors
        else:
            assert (page.parent / link).is_file()


def test_every_scene_has_a_picture_and_a_text():
    page = (module_path("crane.beam").parents[1] / "README.md").read_text("utf-8")
    for file in (module_path("crane.beam").parents[1] / "scenes").glob("*.bg"):
        assert file.with_suffix(".jpg").read_bytes()[:3] == b"\xff\xd8\xff", (
            "python .site/scenes.py"
        )
        assert f"](scenes/{file.stem}.jpg)" in page
        assert file.read_text("utf-8").startswith("/// ")
