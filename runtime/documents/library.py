"""The reference of the library as Markdown, with a picture of each part's bond graph."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.grammar import syntax
from bgc.printing.draw import lay_out
from bgc.printing.part_graph import part_graph
from bgc.printing.tables import Table
from bgc.reference import parts
from bgc.reference.entry import first_sentence
from bgc.reference.library import fitting
from bgc.resolution.library import library_folder, library_modules, module_path
from bgc.resolution.modules import Module
from bgc.resolution.resolve import load
from bgc.runtime.documents.templates import render_template
from bgc.runtime.results.files import written_whole

PAGE = "README.md"
PICTURES = "pictures"

_APPLICATIONS = ("examples", "scenes")  # folders whose models are not parts for others
_HASH = re.compile(rb"<!-- dot ([0-9a-f]{16}) -->")


@dataclass(frozen=True, slots=True)
class _Named:
    """A function, constant or scene: its first line, and its comment."""

    form: str
    doc: str


@dataclass(frozen=True, slots=True)
class _Part:
    """A model, interface or domain on the page."""

    name: str
    heading: str
    doc: str
    fitting: str
    picture: str
    tables: tuple[Table, ...]
    equations: str

    @property
    def anchor(self) -> str:
        """The link to its section."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class _Module:
    """A module on the page."""

    name: str
    summary: str
    doc: str
    file: str
    picture: str
    functions: tuple[_Named, ...]
    scenes: tuple[_Named, ...]
    parts: tuple[_Part, ...]

    @property
    def anchor(self) -> str:
        """The link to its section."""
        return self.name.replace(".", "")


def library_page() -> str:
    """Return the text of the page."""
    return render_template("library.md.j2", modules=[_module(name) for name in library_modules()])


def library_graphs() -> dict[str, str]:
    """Return the graph of each part that has bonds, in the language of `dot`, by its full name."""
    found = {}
    for name in library_modules():
        if _holds_parts(name):
            root = load(module_path(name)).root
            for model in _models(root):
                text = part_graph(root.models[model.name])
                if text:
                    found[f"{name}.{model.name}"] = text
    return found


def write_library(folder: Path | None = None) -> Iterator[Path]:
    """Write the page and the pictures, the unchanged ones left alone; yield what was written.

    `folder` is the library's own by default. Raises BgError: BG056 where Graphviz is missing,
    BG055 where a file cannot be written.
    """
    folder = folder or library_folder()
    wanted = library_graphs()
    pictures = folder / PICTURES
    try:
        pictures.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise BgError([cannot_write(str(pictures), problem.strerror or "")]) from problem
    for name, text in wanted.items():
        path = pictures / f"{name}.svg"
        if not path.is_file() or picture_hash(path.read_bytes()) != graph_hash(text):
            yield _write(path, _picture(text))
    for path in sorted(pictures.glob("*.svg")):
        if path.stem not in wanted:
            path.unlink()
    page = library_page()
    path = folder / PAGE
    if not path.is_file() or path.read_text("utf-8") != page:
        yield _write(path, page.encode())


def graph_hash(text: str) -> str:
    """Return the hash that a picture carries of the graph it was laid out from."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def picture_hash(content: bytes) -> str | None:
    """Return the hash that a picture carries, None where there is none."""
    found = _HASH.search(content)
    return found[1].decode() if found else None


def _picture(text: str) -> bytes:
    """Lay out a graph, without Graphviz's comments, and with the graph's hash."""
    content = re.sub(rb"<!--.*?-->\n?|<title>.*?</title>\n?", b"", lay_out(text, "svg"), flags=re.S)
    start = content.index(b"<svg")
    return f"<!-- dot {graph_hash(text)} -->\n".encode() + content[start:]


def _write(path: Path, content: bytes) -> Path:
    with written_whole(path) as aside:
        aside.write_bytes(content)
    return path


# --- what the page holds --------------------------------------------------------------------


def _holds_parts(module: str) -> bool:
    return module.partition(".")[0] not in _APPLICATIONS


def _models(root: Module) -> list[syntax.Model]:
    return [d for d in root.file.declarations if isinstance(d, syntax.Model)]


def _module(name: str) -> _Module:
    root = load(module_path(name)).root
    doc = parts.file_doc(root.file.source.text)
    declared = root.file.declarations
    values = (
        _Named(_form(d), " ".join(d.doc.split()))
        for d in declared
        if isinstance(d, syntax.Function | syntax.Value) and d.doc
    )
    scenes = (
        _Named(_scene_heading(d), " ".join(d.doc.split()))
        for d in declared
        if isinstance(d, syntax.Scene)
    )
    shown = (d for d in declared if isinstance(d, syntax.Model | syntax.Domain))
    return _Module(
        name,
        first_sentence(doc),
        _prose(doc),
        f"{name.replace('.', '/')}.bg",
        _drawn(name),
        tuple(values) if _holds_parts(name) else (),
        tuple(scenes),
        tuple(_part(d, root, name) for d in shown) if _holds_parts(name) else (),
    )


def _drawn(module: str) -> str:
    """The picture beside the file of a scene, empty where there is none."""
    picture = module_path(module).with_suffix(".jpg")
    return f"{module.replace('.', '/')}.jpg" if picture.is_file() else ""


def _scene_heading(scene: syntax.Scene) -> str:
    """The name of a scene with its model, or with the scene that it extends."""
    if scene.model is not None:
        return f"{scene.name} of {parts.flat_text(scene.model.span.text)}"
    assert scene.base is not None
    return f"{scene.name} is {scene.base.name}"


def _form(declaration: syntax.Function | syntax.Value) -> str:
    """The name of a function with its arguments, or of a constant."""
    if isinstance(declaration, syntax.Function):
        return f"{declaration.name}({', '.join(f.name for f in declaration.formals)})"
    return declaration.name


def _part(declaration: syntax.Model | syntax.Domain, root: Module, module: str) -> _Part:
    if isinstance(declaration, syntax.Domain):
        heading = parts.flat_text(declaration.span.text).partition("{")[0]
        heading = heading[heading.index("domain") :].strip()
        tables = (parts.variables(declaration),)
        return _Part(declaration.name, heading, _prose(declaration.doc), "", "", tables, "")
    declared = root.models[declaration.name]
    return _Part(
        declaration.name,
        parts.heading(declaration),
        _prose(declaration.doc),
        ", ".join(fitting(f"{module}.{declaration.name}")),
        f"{PICTURES}/{module}.{declaration.name}.svg" if part_graph(declared) else "",
        tuple(table for table in parts.tables(declared) if table.rows),
        "\n".join(parts.equations(declaration)),
    )


def _prose(text: str) -> str:
    """Paragraphs, each on one line; signs of Markdown outside code are escaped."""
    pieces = (" ".join(piece.split()) for piece in text.split("\n\n"))
    return "\n\n".join(piece.replace("*", r"\*") for piece in pieces if piece)
