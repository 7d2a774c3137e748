"""Diagnostics of imports of files and library modules."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def imported_file_missing(span: Span, path: str) -> Diagnostic:
    """BG020: an imported file that does not exist"""
    return error(
        "BG020",
        f"there is no file `{path}`",
        span,
        help="correct the path, which is relative to the folder of this file; a library module is "
        "imported without quotes: `import crane.joints;`",
    )


def library_module_missing(span: Span, name: str, modules: Sequence[str]) -> Diagnostic:
    """BG021: an imported library module that does not exist"""
    near = did_you_mean(name, modules)
    return error(
        "BG021",
        f"the library has no module `{name}`",
        span,
        help=near or 'import a file of your own by its path: `import "joints.bg";`',
        edits=respelt(Span(span.source, span.start, span.end - 1), name, modules)
        if span.text.endswith(";")
        else respelt(span, name, modules),
    )


def import_cycle(span: Span, files: Sequence[str]) -> Diagnostic:
    """BG022: files that import each other"""
    return error(
        "BG022",
        f"files import each other: {' -> '.join(files)}",
        span,
        help="move the shared declarations into a third file that both import",
    )


def name_imported_twice(span: Span, name: str, places: Sequence[Span]) -> Diagnostic:
    """BG023: one name imported from two places"""
    return error(
        "BG023",
        f"`{name}` is imported from two places",
        span,
        labels=[Label(place, "declared here") for place in places],
        help="rename one of them, or import only one of the files",
    )


def not_a_model_file(span: Span, path: str) -> Diagnostic:
    """BG024: an imported file that is not a `.bg` file"""
    return error(
        "BG024",
        f"`{path}` is not a `.bg` file",
        span,
        help="rename it so that its own name ends in `.bg`, and correct the path",
    )
