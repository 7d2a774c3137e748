"""Collecting diagnostics, so that one run reports every independent mistake."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from bgc.grammar.diagnostics import BgError, Diagnostic, Severity

_INDEX = re.compile(r"\[[-\d, ]+\]")


class Report:
    """The diagnostics of a pass so far, each once.

    What depends on something that failed raises `already_reported()`, which adds nothing, so
    that one cause gives one message.
    """

    def __init__(self) -> None:
        self._diagnostics: dict[tuple[object, ...], Diagnostic] = {}
        self._aside = 0

    def add(self, *diagnostics: Diagnostic, note: str = "") -> None:
        """Record diagnostics, with a note on those that have none yet."""
        for diagnostic in diagnostics:
            span = diagnostic.span
            place = (span.source.name, span.start, span.end) if span else None
            # An array of parts repeats a mistake for each of its parts.
            if note and not diagnostic.note:
                diagnostic = replace(diagnostic, note=note)
            message = _INDEX.sub("[..]", diagnostic.message)
            self._diagnostics.setdefault((diagnostic.code, place, message), diagnostic)

    @contextmanager
    def collecting(self, note: str = "") -> Iterator[None]:
        """Record what a block raises as BgError, and go on behind it."""
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
        """All that is no error, in the order found."""
        return tuple(d for d in self._diagnostics.values() if d.severity is not Severity.ERROR)

    def set_aside(self) -> None:
        """Let the errors so far not stop the passes that follow, only the last of them."""
        self._aside = len(self.errors)

    def raise_new_errors(self) -> None:
        """Raise BgError when there are errors that were not set aside."""
        if len(self.errors) > self._aside:
            self.raise_errors()

    def raise_errors(self) -> None:
        """Raise BgError when there is any error, warnings with it."""
        if self.errors:
            raise BgError([*self.errors, *self.warnings])


def already_reported() -> BgError:
    """What to raise where something is needed whose failure has been recorded."""
    return BgError(())
