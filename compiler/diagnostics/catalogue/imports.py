"""Diagnostics of imports: which file names which other."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def imported_file_missing(span: Span, path: str) -> Diagnostic:
    """BG020: an imported file that is not there

    What: the path after `import` names no file; it is taken from the folder of the file that
    imports it.
    Why: a model is only complete with the parts it imports.
    Example: `import "jionts.bg";`
    Way out: correct the path, or import a module of the library by its name, without quotes.
    """
    return error(
        "BG020",
        f"there is no file `{path}`",
        span,
        help="the path is taken from the folder of this file; a library module has no quotes: "
        "`import crane.joints;`",
    )


def library_module_missing(span: Span, name: str, modules: Sequence[str]) -> Diagnostic:
    """BG021: an imported library module that is not there

    What: the dotted name after `import` is no module of the installed library.
    Why: `import crane.joints;` reads `crane/joints.bg` of the library that came with `bgc`.
    Example: `import crane.jionts;`
    Way out: correct the name; a file of your own is imported by its path, in quotes.
    """
    near = did_you_mean(name, modules)
    return error(
        "BG021",
        f"the library has no module `{name}`",
        span,
        help=near or 'a file of your own is imported by its path: `import "joints.bg";`',
    )


def import_cycle(span: Span, files: Sequence[str]) -> Diagnostic:
    """BG022: files that import each other

    What: following the imports leads back to the file one started from.
    Why: what a name means would depend on which of the files is read first.
    Example: `a.bg` imports `b.bg`, which imports `a.bg`.
    Way out: move what both need into a third file that imports neither.
    """
    return error(
        "BG022",
        f"files import each other: {' -> '.join(files)}",
        span,
        help="move what they share into a file of its own, which both import",
    )


def name_imported_twice(span: Span, name: str, places: Sequence[Span]) -> Diagnostic:
    """BG023: one name, imported from two places

    What: two imported files declare the same name differently.
    Why: which of them is meant could not be told.
    Example: two files, both with a `model Beam`, imported by a third.
    Way out: rename one of them, or import only one of the files.
    """
    return error(
        "BG023",
        f"`{name}` is imported from two places",
        span,
        labels=[Label(place, "declared here") for place in places],
        help="rename one of them, or import only one of the files",
    )
