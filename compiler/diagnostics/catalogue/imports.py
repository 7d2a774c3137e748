"""Diagnostics: imports of files and library modules."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, nearest
from bgc.diagnostics.source import Span


@error(
    "BG020: there is no file `{path}`",
    "correct the path, which is relative to the folder of this file; a library module is "
    "imported without quotes: `import crane.joints;`",
)
def imported_file_missing(span: Span, path: str) -> None: ...
@error(
    "BG021: the library has no module `{name}`",
    'import a file of your own by its path: `import "joints.bg";`',
)
def library_module_missing(span: Span, name: str, modules: Sequence[str]) -> Values:
    named = Span(span.source, span.start, span.end - 1) if span.text.endswith(";") else span
    return nearest(name, modules, named)


@error(
    "BG022: files import each other: {files:path}",
    "move the shared declarations into a third file that both import",
)
def import_cycle(span: Span, files: Sequence[str]) -> None: ...
@error(
    "BG023: `{name}` is imported from two places",
    "rename one of them, or import only one of the files",
    labels={"places": "declared here"},
)
def name_imported_twice(span: Span, name: str, places: Sequence[Span]) -> None: ...
@error(
    "BG024: `{path}` is not a `.bg` file",
    "rename it so that its own name ends in `.bg`, and correct the path",
)
def not_a_model_file(span: Span, path: str) -> None: ...
