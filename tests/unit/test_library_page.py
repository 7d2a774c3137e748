"""The library's documentation: its texts, its list, and the pages that the site makes of it."""

import re
import sys
from hashlib import blake2b
from pathlib import Path

import pytest

from bgc.grammar import syntax
from bgc.reference import parts
from bgc.reference.library_entries import declarations
from bgc.resolution.library import library_folder, library_modules, module_path
from bgc.resolution.resolve import load

ROOT = Path(__file__).parents[2]
if not (ROOT / ".site").is_dir():
    pytest.skip("not a checkout", allow_module_level=True)
sys.path.insert(0, str(ROOT / ".site"))

from modules import holds_parts, library_list, library_pages, part_graphs  # noqa: E402

LIST = ROOT / "library" / "README.md"
GRAPHS = ROOT / "tests" / "golden" / "part_graphs.txt"
MOST_WORDS = 6000  # of a page


def documented_models() -> list[str]:
    return [
        d.full_name
        for d in declarations()
        if d.kind in {"model", "interface"} and holds_parts(d.module)
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


def test_the_list_of_the_library_is_current(bless):
    text = library_list()
    if bless:
        LIST.write_text(text, "utf-8")
    assert LIST.read_text("utf-8") == text, "pytest tests/unit/test_library_page.py --bless"
    assert len(text.split()) <= MOST_WORDS


def test_the_list_names_every_module_and_part_once():
    text = LIST.read_text("utf-8")
    links = re.findall(r"^\[(.+?)\]\((.+?)\): \S", text, re.MULTILINE)
    assert [link for _, link in links] == [f"{m.replace('.', '/')}.bg" for m in library_modules()]
    assert all(name == link and (LIST.parent / link).is_file() for name, link in links)
    listed = re.findall(r"^- `(\w+)`: \S", text, re.MULTILINE)
    assert set(listed) >= {name.rpartition(".")[2] for name in documented_models()}


def test_the_graphs_of_the_parts_are_current(bless):
    """A digest of each stands for its picture, which the site alone draws."""
    digests = {name: blake2b(text.encode(), digest_size=8) for name, text in part_graphs().items()}
    text = "".join(f"{name} {digest.hexdigest()}\n" for name, digest in digests.items())
    if bless:
        GRAPHS.write_text(text, "utf-8")
    assert GRAPHS.read_text("utf-8") == text, "look at the pictures of the site, then --bless"


def test_every_scene_has_a_picture_and_a_text():
    text = LIST.read_text("utf-8")
    for file in (ROOT / "library" / "scenes").glob("*.bg"):
        assert file.with_suffix(".jpg").read_bytes()[:3] == b"\xff\xd8\xff", (
            "python .site/scenes.py"
        )
        assert f"](scenes/{file.stem}.jpg)" in text
        assert file.read_text("utf-8").startswith("/// ")


def test_the_site_has_a_page_for_each_module_and_a_picture_of_each_part(tmp_path):
    pages = {page.title: page for page in library_pages(tmp_path)}
    assert set(pages) == {"Overview", *filter(holds_parts, library_modules())}
    for page in pages.values():
        text = "\n".join(page.lines)
        assert len(text.split()) <= MOST_WORDS
        place = (tmp_path / page.path).parent
        for source in re.findall(r'(?:src|href)="([^"]+)"', text):
            assert (place / source).is_file()
    beam = "\n".join(pages["crane.beam"].lines)
    assert "## Beam {#Beam}\n\n```bg\nmodel Beam\n```\n" in beam
    assert "| `length` | `m` | must be given | `0 m .. 1 km` | Distance from base to tip. |" in beam
    assert "base -> hub -> reach -> tip;" in beam
    picture = (tmp_path / "library/crane/beam.Beam.svg").read_bytes()
    assert picture.startswith(b"<svg") and b"<title>" not in picture and b">hub<" in picture
    drawn = "".join("\n".join(page.lines) for page in pages.values()).count("<img alt=")
    assert drawn == len(part_graphs()) > 190
    copy = (tmp_path / "library/crane/beam.bg").read_bytes()
    assert copy == (library_folder() / "crane/beam.bg").read_bytes()
