"""The library on the site: a list of its modules, and a page for each with its parts drawn.

The list is `library/README.md` too: `pytest tests/unit/test_library_page.py --bless` writes it.
"""

from __future__ import annotations

import html
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from pages import Page

from bgc.grammar import syntax
from bgc.printing.part_graph import part_graph
from bgc.printing.text_tables import Table
from bgc.reference import library_entries
from bgc.reference.entry import Block, Code, Entry, Heading, Text, first_sentence
from bgc.resolution.library import library_modules, module_path

_LIBRARY = Path(__file__).parents[1] / "library"
APPLICATIONS = ("examples", "scenes")  # folders whose models are not parts for others
_INTRO = """\
# The library

<!-- Made of the `.bg` files of this folder: edit their comments, not this. -->

Parts for bond graphs of mechanisms, cranes, robot arms and vessels, written in the language itself.
`import crane.beam;` makes the parts of a module visible. `bgc doc Beam` shows a part in a terminal,
with its ports, parameters and bond graph; the site has a page for each module, with pictures.
"""
_CLAUSE = re.compile(r"(?<=\w{3})(?:[:;] |\. (?=`))")
_COMMENT = re.compile(rb"<!--.*?-->\n?|<title>.*?</title>\n?", re.DOTALL)
_AS_WRITTEN = {"name", "unit", "default", "range", "start", "interface", "domain", "drawn as"}


def holds_parts(module: str) -> bool:
    """Return whether the models of a module are parts for others."""
    return module.partition(".")[0] not in APPLICATIONS


def file_of(module: str) -> str:
    """Return the path of a module's file in the library: `crane/beam.bg`."""
    return f"{module.replace('.', '/')}.bg"


def library_list() -> str:
    """Return the list of all modules and parts, one line each, as Markdown."""
    return "\n".join((_INTRO, *_listed())).rstrip() + "\n"


def _listed() -> Iterator[str]:
    folder = ""
    for module in library_modules():
        if folder != module.partition(".")[0]:
            folder = module.partition(".")[0]
            yield from (f"## {folder}", "")
        summary, file = library_entries.GROUP.summaries()[module], file_of(module)
        yield from (f"### {module}", "", f"[{file}]({file}): {_prose(summary)}", "")
        picture = file.replace(".bg", ".jpg")
        if (_LIBRARY / picture).is_file():  # of the checkout: the wheel carries no such pictures
            yield from (f"![A scene of {module}]({picture})", "")
        parts = [
            d for d in library_entries.declarations() if d.module == module and holds_parts(module)
        ]
        models = [d for d in parts if d.kind in {"model", "interface", "domain"}]
        yield from (f"- `{d.name}`: {_prose(_opening(d.doc))}" for d in models)
        yield from [""] * bool(models)


def _opening(doc: str) -> str:
    """The first sentence up to a colon or semicolon, if that says enough."""
    sentence = first_sentence(doc)
    opening = _CLAUSE.split(sentence)[0]
    return opening if len(opening.split()) > 2 else sentence


# --- pages ----------------------------------------------------------------------------------


def library_pages(docs: Path) -> list[Page]:
    """Return the list and a page for each module of parts; draw the parts beside the pages."""
    _draw(docs / "library", part_graphs())
    index = library_list().splitlines()
    modules = [module for module in library_modules() if holds_parts(module)]
    pages = [_module_page(module) for module in modules]
    for module in modules:
        copy = docs / "library" / file_of(module)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(module_path(module), copy)
    return [Page("library/index.md", "Overview", "library/README.md", index), *pages]


@cache
def part_graphs() -> Mapping[str, str]:
    """Return the graph of each part that has bonds, in the language of `dot`, by its full name."""
    found = {}
    for module in filter(holds_parts, library_modules()):
        root = library_entries.read(module)
        for declared in root.file.declarations:
            if isinstance(declared, syntax.Model):
                found[f"{module}.{declared.name}"] = part_graph(root.models[declared.name])
    return {name: graph for name, graph in found.items() if graph}


def picture_of(name: str) -> str:
    """Return the path of a part's picture in the site: `library/crane/beam.Beam.svg`."""
    module, _, part = name.rpartition(".")
    return f"library/{module.replace('.', '/')}.{part}.svg"


def _draw(folder: Path, graphs: Mapping[str, str]) -> None:
    """Lay out all graphs in one run of Graphviz, without its comments and tooltips."""
    with tempfile.TemporaryDirectory() as work:
        files = [Path(work) / name for name in graphs]
        for file, graph in zip(files, graphs.values(), strict=True):
            file.write_text(graph, "utf-8")
        subprocess.run(["dot", "-Tsvg", "-O", *files], check=True)
        for name, file in zip(graphs, files, strict=True):
            drawn = _COMMENT.sub(b"", file.with_name(f"{name}.svg").read_bytes())
            place = folder.parent / picture_of(name)
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(drawn[drawn.index(b"<svg") :])


def _module_page(module: str) -> Page:
    file = file_of(module)
    lines = [f"# {module}", ""]
    for block in library_entries.entry(module).body:
        if isinstance(block, Text):  # the tables list what follows
            lines += _block(block)
    own = file.rpartition("/")[2]
    lines += [f'`import {module};` File: <a href="{own}" download>{file}</a>', ""]
    for declared in library_entries.declarations():
        if declared.module == module:
            lines += [f"## {declared.name} {{#{declared.name}}}", ""]
            lines += _entry_lines(library_entries.entry(declared.full_name), file)
    return Page(f"library/{file[:-3]}.md", module, f"library/{file}", lines)


def _entry_lines(entry: Entry, file: str) -> Iterator[str]:
    """Write an entry with its picture behind its first paragraphs; its home is the page."""
    drawn = entry.name in part_graphs()
    for block in entry.body[:-1]:
        if drawn and isinstance(block, Table | Heading):
            drawn = False
            yield from _picture(entry.name)
        yield from _block(block)
    if drawn:
        yield from _picture(entry.name)
    others = [_linked(name, file) for name in entry.see_also if name not in library_modules()]
    if others:
        yield from (f"See also: {', '.join(others)}", "")


def _picture(name: str) -> tuple[str, ...]:
    source = picture_of(name).rpartition("/")[2]
    return (f'<img alt="Bond graph of {name}" src="{source}">', "")


def _linked(name: str, file: str) -> str:
    """Link a name of another part to its place; a name of several parts stays as it is."""
    found = [d for d in library_entries.declarations() if d.name == name and holds_parts(d.module)]
    if len(found) != 1:
        return f"`{name}`"
    up = "../" * file.count("/")
    return f"[`{name}`]({up}{file_of(found[0].module)}#{name})"


# --- Markdown -------------------------------------------------------------------------------


def _block(block: Block) -> Iterator[str]:
    match block:
        case Text(text=text):
            yield from (_prose(text), "")
        case Code(text=text):
            yield from ("```bg", *text.splitlines(), "```", "")
        case Heading(text=text):
            yield from (f"**{text[:1].upper()}{text[1:]}**", "")
        case Table():
            yield from _table(block)


def _table(table: Table) -> Iterator[str]:
    title = f"{table.title[:1].upper()}{table.title[1:]}"
    yield from (f"**{title}**", "") if title else ()
    yield f"| {' | '.join(table.header)} |"
    yield f"|{'---|' * len(table.header)}"
    for row in table.rows:
        cells = (_cell(cell, heading) for cell, heading in zip(row, table.header, strict=True))
        yield f"| {' | '.join(cells)} |"
    yield ""


def _cell(text: str, heading: str) -> str:
    plain = not text or text in ("any", "must be given", "must be filled")
    shown = _prose(text) if plain or heading not in _AS_WRITTEN else f"`{text}`"
    return shown.replace("|", "\\|")


def _prose(text: str) -> str:
    """Escape signs of Markdown and HTML outside code."""
    pieces = text.split("`")
    for k in range(0, len(pieces), 2):
        pieces[k] = html.escape(pieces[k], quote=False).replace("*", "\\*")
    return "`".join(pieces)
