"""Diagnostics of imports of files and library modules."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def imported_file_missing(span: Span, path: str) -> Diagnostic:
    """BG020: an imported file that does not exist

    What: no file has the path after `import`. The path is relative to the folder of the importing
    file.
    Why: a model is complete only with the parts that it imports.
    Example: `import "jionts.bg";`
    Way out: correct the path, or import a module of the library by its name, without quotes.
    """
    return error(
        "BG020",
        f"there is no file `{path}`",
        span,
        help="correct the path, which is relative to the folder of this file; a library module is "
        "imported without quotes: `import crane.joints;`",
    )


def library_module_missing(span: Span, name: str, modules: Sequence[str]) -> Diagnostic:
    """BG021: an imported library module that does not exist

    What: the installed library has no module with the name after `import`.
    Why: `import crane.joints;` reads `crane/joints.bg` of the library installed with `bgc`.
    Example: `import crane.jionts;`
    Way out: correct the name; import a file of your own by its path, in quotes.
    """
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
    """BG022: files that import each other

    What: the imports of a file lead back to the file itself.
    Why: the meaning of a name would depend on the order in which the files are read.
    Example: `a.bg` imports `b.bg`, which imports `a.bg`.
    Way out: move the shared declarations into a third file that imports neither.
    """
    return error(
        "BG022",
        f"files import each other: {' -> '.join(files)}",
        span,
        help="move the shared declarations into a third file that both import",
    )


def name_imported_twice(span: Span, name: str, places: Sequence[Span]) -> Diagnostic:
    """BG023: one name imported from two places

    What: two imported files declare the same name differently.
    Why: the name is ambiguous.
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


def not_a_model_file(span: Span, path: str) -> Diagnostic:
    """BG024: an imported file that is not a `.bg` file

    What: the path after `import` names a file whose name, or that of the file that it links to,
    does not end in `.bg`.
    Why: a model from elsewhere could import any file of this machine, and error messages would
    quote its lines.
    Example: `import "/etc/passwd";`
    Way out: give the imported file a name that ends in `.bg`.
    """
    return error(
        "BG024",
        f"`{path}` is not a `.bg` file",
        span,
        help="rename it so that its own name ends in `.bg`, and correct the path",
    )
