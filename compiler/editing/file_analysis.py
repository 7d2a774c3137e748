"""A file with its imports as an editor sees it: names, declarations, uses."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.editing.cursor_tokens import Words
from bgc.editing.documents import Document, Documents
from bgc.editing.occurrences import (
    Occurrence,
    Region,
    file_region,
    model_region,
    occurrences,
    scene_region,
)
from bgc.editing.symbols import Kind, Symbol, Table
from bgc.grammar import syntax
from bgc.record_class import dataclass
from bgc.resolution.library import module_path
from bgc.resolution.modules import Module, Package
from bgc.resolution.resolve import examine


@dataclass(frozen=True)
class Analysis:
    """The file of `document`, its package as far as it can be read, and what is wrong with it."""

    document: Document
    package: Package
    diagnostics: tuple[Diagnostic, ...]
    documents: Documents

    @property
    def module(self) -> Module:
        """The file itself."""
        return self.package.root

    @cached_property
    def table(self) -> Table:
        """The members of all models that the file sees."""
        words: dict[str, Words] = {}
        for file in self.package.files:
            found = self.documents.find(file.path) if file.path is not None else None
            if found is not None:
                words[file.source.name] = Words(found.source, found.tokens)
        return Table(words)

    @cached_property
    def words(self) -> Words:
        """The tokens of the file."""
        return Words(self.document.source, self.document.tokens)

    @cached_property
    def occurrences(self) -> tuple[Occurrence, ...]:
        """The names of the file, in the order of the text."""
        return occurrences(self.module, self.table)

    def at(self, offset: int) -> Occurrence | None:
        """Return the name under a cursor."""
        found = [o for o in self.occurrences if o.span.start <= offset <= o.span.end]
        return min(found, key=lambda o: o.span.end - o.span.start, default=None)

    def definition(self, offset: int) -> Span | None:
        """Return the place where the name under a cursor is declared; of an import the file's."""
        found = self.at(offset)
        if found is None or found.symbol is None:
            return None
        if found.symbol.kind is not Kind.MODULE:
            return found.symbol.span
        for item in self.document.file.imports:
            if item.span.start <= offset <= item.span.end:
                path = (
                    self.document.path.parent / item.path
                    if isinstance(item, syntax.ImportFile)
                    else module_path(".".join(item.path))
                )
                target = self.documents.find(path) if self.documents.has(path) else None
                return Span(target.source, 0, 0) if target is not None else None
        return None

    def declaration_at(self, offset: int) -> syntax.Declaration | None:
        """Return the declaration of the file in which an offset lies, or the last one before it."""
        before = [d for d in self.module.file.declarations if d.span.start <= offset]
        return max(before, key=lambda d: d.span.start, default=None)

    def region(self, declaration: syntax.Declaration | None) -> Region:
        """Return the names that are visible in a declaration."""
        match declaration:
            case syntax.Model():
                return model_region(declaration, self.module, self.table)
            case syntax.Scene():
                return scene_region(declaration, self.module, self.table)
            case _:
                return file_region(self.module)

    def uses(self, symbol: Symbol) -> Iterator[Occurrence]:
        """The places in all files of the package at which a symbol stands."""
        for module in self.package.modules:
            found = self.occurrences if module is self.module else occurrences(module, self.table)
            for occurrence in found:
                if occurrence.symbol is not None and occurrence.symbol.key == symbol.key:
                    yield occurrence


def analyse(path: Path, documents: Documents) -> Analysis:
    """Analyse a file with all its imports; BgError if it cannot be read."""
    document = documents.document(path)
    package, diagnostics = examine(document.path, documents)
    return Analysis(document, package, diagnostics, documents)
