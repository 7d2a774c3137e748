"""The state of a language server: texts, their analyses, the results of the compiler.

Nothing here knows the protocol, so all of it can be called directly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from threading import Event

from bgc.diagnostics.catalogue.editing import analysis_failed
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Label, Severity
from bgc.diagnostics.source import Source, Span
from bgc.driver import Stage, Stages, check_package
from bgc.editing.documents import Documents
from bgc.editing.facts import Facts, facts_of, merged, shifted_facts
from bgc.editing.file_analysis import Analysis, analyse
from bgc.editing.hints import Hint, hints
from bgc.editing.moves import moving
from bgc.grammar import syntax
from bgc.record_class import dataclass, replace
from bgc.resolution.library import library_folder

_FILES = 500  # of the workspace that are searched for uses of a name
_SKIPPED = {".git", ".venv", "node_modules", "__pycache__"}


class Cancelled(Exception):
    """A check that a later edit has made useless."""


@dataclass(frozen=True, slots=True)
class Checked:
    """The result of a check by the compiler: of one text of a file, with its imports."""

    path: Path
    text: str
    diagnostics: tuple[Diagnostic, ...]
    facts: Facts
    texts: dict[str, str]  # the texts of all its files, by the names of their sources


class Session:
    """Buffers and files, what is known of them, and what the compiler found in the background."""

    def __init__(self) -> None:
        self.documents = Documents()
        self.folders: list[Path] = []
        self._analyses: dict[Path, Analysis] = {}
        self._checked: dict[Path, Checked] = {}
        self._facts: dict[Path, Checked] = {}  # the last check of each file that gave facts

    # --- texts --------------------------------------------------------------------------

    def change(self, path: Path, text: str) -> None:
        """Enter the text of a buffer."""
        self.documents.open(path, text)
        self._analyses.clear()

    def close(self, path: Path) -> None:
        """Drop a buffer, and what the compiler found in it."""
        self.documents.close(path)
        for kept in (self._analyses, self._checked, self._facts):
            kept.pop(path.resolve(), None)
        self._analyses.clear()

    def forget_files(self) -> None:
        """Read files again that have changed on the disk."""
        self._analyses.clear()

    def analysis(self, path: Path) -> Analysis:
        """Return the analysis of a file; BgError if it cannot be read."""
        key = path.resolve()
        if key not in self._analyses:
            self._analyses[key] = analyse(key, self.documents)
        return self._analyses[key]

    # --- diagnostics --------------------------------------------------------------------

    def diagnostics(self, path: Path) -> tuple[Diagnostic, ...]:
        """Return what is wrong with a file, with places in its text.

        Syntax and names are those of the text as it is. What the compiler found in an earlier text
        is kept, at its new place, as long as syntax and names have no error.
        """
        try:
            analysis = self.analysis(path)
        except BgError as problem:
            return tuple(problem.diagnostics)
        found = list(analysis.diagnostics)
        checked = self._checked.get(analysis.document.path)
        if checked is not None and not any(d.severity is Severity.ERROR for d in found):
            found += [
                d
                for each in checked.diagnostics
                if (d := _moved(each, checked.text, analysis.document.source)) is not None
            ]
        located = (_located(each, analysis) for each in found)
        return tuple(dict.fromkeys(located))

    # --- the compiler -------------------------------------------------------------------

    def check(self, path: Path, cancelled: Event) -> Checked:
        """Compile all scenes and complete models of a file up to their equations.

        It may run in a thread of its own: `prepare` has parsed all files before.

        Raises
        ------
        Cancelled
            `cancelled` was set; it is read before each stage.
        """
        return self.prepare(path)(cancelled)

    def prepare(self, path: Path) -> Callable[[Event], Checked]:
        """Read a file with its imports, and return the check of it."""
        analysis = self.analysis(path)
        return lambda cancelled: _check(analysis, cancelled)

    def take(self, checked: Checked) -> bool:
        """Keep the result of a check; False if the text has changed since."""
        document = self.documents.find(checked.path)
        if document is None or document.source.text != checked.text:
            return False
        self._checked[checked.path] = checked
        if checked.facts.bonds or checked.facts.values or checked.facts.parts:
            self._facts[checked.path] = checked
        return True

    def facts(self, path: Path) -> Facts:
        """Return what the compiler found about a file, also by way of files that import it.

        While the file is edited these are the facts of its last text that compiled, at their
        present places.
        """
        document = self.documents.find(path)
        if document is None:
            return Facts()
        name, text = document.source.name, document.source.text
        current = [c.facts for c in self._facts.values() if c.texts.get(name) == text]
        if not current and (own := self._facts.get(document.path)) is not None:
            current = [shifted_facts(own.facts, name, own.text, text)]
        return merged(current)

    def hints(self, path: Path) -> tuple[Hint, ...]:
        """Return the hints of a file."""
        document = self.documents.find(path)
        return () if document is None else hints(document.file, self.facts(path))

    # --- files --------------------------------------------------------------------------

    def roots(self) -> tuple[Path, ...]:
        """The files in which a name may be used: all buffers, and the files of the workspace."""
        found = dict.fromkeys(self.documents.open_paths)
        for folder in self.folders:
            for path in _files_below(folder):
                if len(found) >= _FILES:
                    return tuple(found)
                found[path.resolve()] = None
        return tuple(found)

    def may_change(self, path: Path) -> bool:
        """Return whether a file is the user's: in the workspace, or not of the library."""
        resolved = path.resolve()
        in_workspace = any(resolved.is_relative_to(folder) for folder in self.folders)
        return in_workspace or not resolved.is_relative_to(library_folder().resolve())


def _files_below(folder: Path) -> Iterator[Path]:
    try:
        inside = sorted(folder.iterdir())
    except OSError:
        return
    for path in inside:
        if path.is_dir() and not path.is_symlink() and path.name not in _SKIPPED:
            yield from _files_below(path)
        elif path.suffix == ".bg":
            yield path


def _check(analysis: Analysis, cancelled: Event) -> Checked:
    facts: list[Facts] = []

    def watch(stage: Stage) -> None:
        if cancelled.is_set():
            raise Cancelled

    def seen(stages: Stages) -> None:
        facts.append(facts_of(stages))

    package, document = analysis.package, analysis.document
    found: Iterable[Diagnostic] = ()
    if not any(d.severity is Severity.ERROR for d in analysis.diagnostics):
        try:
            found = check_package(document.path, package, watch=watch, seen=seen)
        except Cancelled:
            raise
        except BgError as problem:
            found = problem.diagnostics
        except Exception as problem:  # a fault of bgc must not end the server
            where = Span(document.source, 0, 0)
            found = (analysis_failed(where, f"{type(problem).__name__}: {problem}"),)
    known = set(analysis.diagnostics)
    texts = {source.name: source.text for source in package.sources}
    own = tuple(d for d in found if d not in known)
    return Checked(document.path, document.source.text, own, merged(facts), texts)


def _moved(diagnostic: Diagnostic, old: str, source: Source) -> Diagnostic | None:
    """A diagnostic of an earlier text at its place in the present one; None if that is edited."""
    span = diagnostic.span
    if span is None or span.source.name != source.name or old == source.text:
        return diagnostic
    move = moving(old, source.text)
    start, end = move(span.start), move(span.end)
    if start is None or end is None or start > end:
        return None
    return replace(diagnostic, span=Span(source, start, end), labels=(), edits=())


def _located(diagnostic: Diagnostic, analysis: Analysis) -> Diagnostic:
    """Give a diagnostic of an imported file its place at the import; of none, at the beginning."""
    source = analysis.document.source
    span = diagnostic.span
    if span is not None and span.source.name == source.name:
        return diagnostic
    place = Span(source, 0, 0)
    imports = analysis.document.file.imports
    if span is None:
        return replace(diagnostic, span=place)
    for item in imports[:1]:
        place = item.span
    for item in imports:
        if isinstance(item, syntax.ImportFile) and span.source.name.endswith(item.path):
            place = item.span
            break
    label = Label(span, diagnostic.message)
    message = f"in {Path(span.source.name).name}: {diagnostic.message}"
    return replace(
        diagnostic, span=place, message=message, labels=(label, *diagnostic.labels), edits=()
    )
