"""Rename a declaration everywhere, unless that would change what any name means."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TypeAlias

from bgc.diagnostics.catalogue.editing import cannot_rename, not_a_name, rename_conflict
from bgc.diagnostics.diagnostic import BgError, Edit, Severity
from bgc.diagnostics.source import Span
from bgc.editing.documents import Documents
from bgc.editing.file_analysis import Analysis, analyse
from bgc.editing.occurrences import Occurrence, occurrences
from bgc.editing.symbols import Kind, Symbol
from bgc.grammar.language_words import RESERVED, SCENE_WORDS

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")

Meaning: TypeAlias = tuple[str, object]


def references(
    symbol: Symbol, analysis: Analysis, roots: Iterable[Path], documents: Documents
) -> tuple[Span, ...]:
    """Return all places of a symbol: in its package, and in the files of `roots` that see it."""
    return _places(symbol, _analyses(analysis, roots, documents))


def _places(symbol: Symbol, analyses: Iterable[Analysis]) -> tuple[Span, ...]:
    spans = (use.span for each in analyses for use in each.uses(symbol))
    found = {(span.source.name, span.start): span for span in spans}
    return tuple(found[place] for place in sorted(found))


def renameable(analysis: Analysis, offset: int, may_change: Callable[[Path], bool]) -> Occurrence:
    """Return the name under the cursor; BgError if it is not one of the user's declarations."""
    found = analysis.at(offset)
    if found is None:
        raise BgError([cannot_rename("this", "there is no name")])
    text, symbol = found.span.text, found.symbol
    if symbol is None:
        raise BgError([cannot_rename(text, "it is not declared")])
    if symbol.kind is Kind.MODULE:
        raise BgError([cannot_rename(text, "it is the name of a file")])
    if symbol.span is None:
        raise BgError([cannot_rename(text, "it is built in")])
    places = [symbol.span, *([symbol.root] if symbol.root is not None else [])]
    if not all(may_change(Path(place.source.name)) for place in places):
        raise BgError([cannot_rename(text, "the library declares it")])
    return found


def rename(
    analysis: Analysis,
    offset: int,
    name: str,
    roots: Iterable[Path],
    documents: Documents,
    may_change: Callable[[Path], bool],
) -> tuple[Edit, ...]:
    """Return the edits that rename the declaration under a cursor.

    Parameters
    ----------
    roots
        The files to search for uses, besides the analysed file and what it imports.
    may_change
        Whether a file is the user's: not one of the installed library.

    Raises
    ------
    BgError
        The new name is not a name (BG133), the old one cannot be changed (BG134), or the files
        would mean something else (BG135).
    """
    occurrence = renameable(analysis, offset, may_change)
    symbol = occurrence.symbol
    assert symbol is not None
    in_scene = symbol.kind in {Kind.DEVICE, Kind.COLUMN}
    if not _NAME.fullmatch(name) or name in RESERVED or (in_scene and name in SCENE_WORDS):
        raise BgError([not_a_name(name, bool(_NAME.fullmatch(name)))])
    if name == symbol.name:
        return ()
    analyses = _analyses(analysis, roots, documents)
    edits = tuple(Edit(place, name) for place in _places(symbol, analyses))
    if any(not may_change(Path(edit.span.source.name)) for edit in edits):
        raise BgError([cannot_rename(symbol.name, "a file of the library uses it")])
    _check(analyses, edits, symbol.name, name, documents)
    return edits


def _analyses(analysis: Analysis, roots: Iterable[Path], documents: Documents) -> list[Analysis]:
    """The file itself, and the roots that can be read."""
    found = {analysis.document.path: analysis}
    for root in roots:
        path = root.resolve()
        if path not in found and documents.find(path) is not None:
            found[path] = analyse(path, documents)
    return list(found.values())


def _check(
    analyses: Iterable[Analysis], edits: Iterable[Edit], old: str, new: str, documents: Documents
) -> None:
    """Apply the edits to copies of the texts, and compare the meaning of every name."""
    after = documents.copy()
    by_file: dict[str, list[Edit]] = {}
    for edit in edits:
        by_file.setdefault(edit.span.source.name, []).append(edit)
    for file, some in by_file.items():
        after.open(Path(file), applied(some[0].span.source.text, some))
    for before in analyses:
        if not any(m.file.source.name in by_file for m in before.package.modules):
            continue
        changed = analyse(before.document.path, after)
        _compare(before, changed, old, new)


def applied(text: str, edits: Iterable[Edit]) -> str:
    """Return a text with edits that do not overlap."""
    for edit in sorted(edits, key=lambda e: e.span.start, reverse=True):
        text = text[: edit.span.start] + edit.text + text[edit.span.end :]
    return text


def _compare(before: Analysis, after: Analysis, old: str, new: str) -> None:
    ours, theirs = _by_file(before), _by_file(after)
    index_before, index_after = _declarations(ours), _declarations(theirs)
    for file, found in ours.items():
        now = theirs.get(file, ())
        for k, occurrence in enumerate(found):
            was = _meaning(occurrence, index_before)
            if k >= len(now) or _meaning(now[k], index_after) != was:
                why = "a name would mean something else"
                raise BgError([rename_conflict(old, new, occurrence.span, why, ())])
        if len(now) > len(found):
            why = "a word would become a name"
            raise BgError([rename_conflict(old, new, now[len(found)].span, why, ())])
    known = [d.code for d in before.diagnostics if d.severity is Severity.ERROR]
    for diagnostic in after.diagnostics:
        if diagnostic.severity is not Severity.ERROR:
            continue
        if diagnostic.code in known:
            known.remove(diagnostic.code)
        elif diagnostic.span is not None:
            others = [label.span for label in diagnostic.labels]
            why = diagnostic.message
            raise BgError([rename_conflict(old, new, diagnostic.span, why, others)])


def _by_file(analysis: Analysis) -> dict[str, tuple[Occurrence, ...]]:
    return {
        module.file.source.name: occurrences(module, analysis.table)
        for module in analysis.package.modules
    }


def _declarations(
    found: Mapping[str, tuple[Occurrence, ...]],
) -> dict[tuple[str, int], tuple[str, int]]:
    """The number of each occurrence within its file, by its place: the same before and after."""
    return {
        (file, occurrence.span.start): (file, number)
        for file, some in found.items()
        for number, occurrence in enumerate(some)
    }


def _meaning(occurrence: Occurrence, index: Mapping[tuple[str, int], Meaning]) -> object:
    symbol = occurrence.symbol
    if symbol is None:
        return None
    place = symbol.root or symbol.span
    if place is None:
        return symbol.kind
    return index.get((place.source.name, place.start), symbol.kind)
