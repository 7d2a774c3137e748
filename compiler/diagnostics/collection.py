"""Collect diagnostics, so that one run reports every independent mistake."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from bgc.diagnostics.catalogue.syntax import too_many_errors
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity

MAX_ERRORS = 50  # reported for one text, and for one pass
_PATH = re.compile(r"(?<![\w.\]])(?:[A-Za-z_]\w*(?:\[\.\.\])?\.)+(?=[A-Za-z_])")
_INDEX = re.compile(r"\[[-\d, ]+\]")


class Report:
    """The diagnostics of a pass so far, each once.

    Code that depends on a failed value raises `already_reported()`, which adds nothing, so
    that one cause gives one message. After `MAX_ERRORS` the report is full: a last error states
    that there are more, and the pass ends, since it would only compute what is dropped. `most`
    is another bound than `MAX_ERRORS`.
    """

    def __init__(self, most: int = MAX_ERRORS) -> None:
        self._most = most
        self._diagnostics: dict[tuple[object, ...], Diagnostic] = {}
        self._aside = 0
        self._errors = 0

    def add(self, *diagnostics: Diagnostic, note: str = "") -> None:
        """Record diagnostics, with a note on those that have none yet.

        Raises BgError with all of them once the report is full.
        """
        for diagnostic in diagnostics:
            span = diagnostic.span
            place = (span.source.name, span.start, span.end) if span else None
            # Each part of an array, and each part of one model, repeats the same mistake.
            if note and not diagnostic.note:
                diagnostic = replace(diagnostic, note=note)
            message = _INDEX.sub("[..]", diagnostic.message)
            key = (diagnostic.code, place, _PATH.sub("", message) if span else message)
            if key not in self._diagnostics:
                self._enter(key, diagnostic)
        if self.is_full:
            self.raise_errors()

    def _enter(self, key: tuple[object, ...], diagnostic: Diagnostic) -> None:
        if diagnostic.severity is Severity.ERROR:
            if self.is_full:
                return
            self._errors += 1
            if self._errors > self._most and diagnostic.span is not None:
                diagnostic = too_many_errors(diagnostic.span, self._most)
        self._diagnostics[key] = diagnostic

    @property
    def is_full(self) -> bool:
        """Return whether more errors would be dropped."""
        return self._errors > self._most

    @contextmanager
    def collecting(self, note: str = "") -> Iterator[None]:
        """Record the diagnostics of a BgError raised in a block, and continue after the block."""
        try:
            yield
        except BgError as err:
            self.add(*err.diagnostics, note=note)

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """The errors, in the order found."""
        return tuple(d for d in self._diagnostics.values() if d.severity is Severity.ERROR)

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """The warnings and notes, in the order found."""
        return tuple(d for d in self._diagnostics.values() if d.severity is not Severity.ERROR)

    def set_aside(self) -> None:
        """Let the passes that follow run despite the errors so far; the last pass raises them."""
        self._aside = len(self.errors)

    def raise_new_errors(self) -> None:
        """Raise BgError if there are errors that were not set aside."""
        if len(self.errors) > self._aside or self.is_full:
            self.raise_errors()

    def raise_errors(self) -> None:
        """Raise BgError with errors and warnings if there is any error."""
        if self.errors:
            raise BgError([*self.errors, *self.warnings])


def already_reported() -> BgError:
    """Return the error to raise if a needed value failed and its failure is recorded."""
    return BgError(())
