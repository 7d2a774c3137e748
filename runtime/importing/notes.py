"""Warnings of an import: one for each cause, however often it occurs."""

from __future__ import annotations

from bgc.diagnostics.catalogue.imported import left_out
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


class Notes:
    """Collects warnings; those of one cause become one, with the first place and the count."""

    def __init__(self) -> None:
        self._grouped: dict[str, tuple[Span | None, str, int]] = {}
        self._single: list[Diagnostic] = []

    def group(self, span: Span | None, cause: str, help: str) -> None:
        """Note something that may occur many times."""
        first, way_out, count = self._grouped.get(cause, (span, help, 0))
        self._grouped[cause] = first, way_out, count + 1

    def add(self, diagnostic: Diagnostic) -> None:
        """Note a warning of its own."""
        self._single.append(diagnostic)

    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Return all warnings."""
        grouped = (
            left_out(span, cause if count == 1 else f"{cause} ({count} times)", help)
            for cause, (span, help, count) in self._grouped.items()
        )
        return (*self._single, *grouped)
