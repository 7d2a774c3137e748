"""A gallery: a folder with a live page of each scene of some files, and an index of them."""

from __future__ import annotations

import gzip
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final

from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.grammar import syntax
from bgc.options import Options
from bgc.record_class import dataclass
from bgc.reference import parts
from bgc.reference.entry import first_sentence
from bgc.resolution.library import library_folder
from bgc.resolution.resolve import load
from bgc.runtime.documents.templates import render_template
from bgc.runtime.results.files import written_whole
from bgc.runtime.view.page import bundle
from bgc.runtime.web.module import require_zig
from bgc.runtime.web.page_export import live_page

INDEX: Final = "index.html"

_FOLDERS: Final = ("scenes", "examples")  # of the library


@dataclass(frozen=True, slots=True)
class _Scene:
    """A scene in the index: its page, empty where it has none, and what is said below it."""

    name: str
    doc: str
    page: str
    note: str


@dataclass(frozen=True, slots=True)
class _File:
    """A file in the index, with its scenes."""

    name: str
    summary: str
    scenes: tuple[_Scene, ...]


def library_files() -> list[Path]:
    """The files of the library that are scenes, not parts for others."""
    return [
        path for folder in _FOLDERS for path in sorted((library_folder() / folder).glob("*.bg"))
    ]


def write_gallery(
    files: Sequence[Path], folder: Path, refused: Callable[[BgError], None]
) -> Iterator[Path]:
    """Write a live page of each scene of the files, then the index; yield each when it is written.

    `refused` is called for a scene that cannot be a page; the index states the reason, and the
    others are written.

    Raises BgError: BG545 without ziglang, BG055 where a file cannot be written, and the mistakes of
    a file that cannot be read.
    """
    require_zig()
    bundle()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise BgError([cannot_write(str(folder), problem.strerror or "")]) from problem
    shown = []
    for file in files:
        root = load(file).root
        scenes: list[_Scene] = []
        for declared in root.file.declarations:
            if isinstance(declared, syntax.Scene):
                scene = _scene(file, declared, folder, refused)
                if scene.page:
                    yield folder / scene.page
                scenes.append(scene)
        summary = first_sentence(parts.file_doc(root.file.source.text))
        shown.append(_File(file.stem, summary, tuple(scenes)))
    with written_whole(folder / INDEX) as aside:
        aside.write_text(render_template("gallery.html.j2", files=shown), "utf-8")
    yield folder / INDEX


def _scene(
    file: Path, declared: syntax.Scene, folder: Path, refused: Callable[[BgError], None]
) -> _Scene:
    """Write the page of a scene."""
    doc = " ".join(declared.doc.split())
    page = f"{file.stem}.{declared.name}.html"
    try:
        made = live_page(file, Options(declared.name))
    except BgError as problem:
        refused(problem)
        return _Scene(declared.name, doc, "", str(problem.diagnostics[0].message))
    made.save(folder / page)
    size = len(gzip.compress(made.document.encode(), 6)) / 1e6
    return _Scene(declared.name, doc, page, f"{size:.2f} MB compressed")
