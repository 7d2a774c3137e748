"""Diagnostics as values: what is wrong, where, and the way out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from bgc.diagnostics.source import Span


class Severity(Enum):
    """How bad it is: an error ends the compilation, a warning does not."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


@dataclass(frozen=True, slots=True)
class Label:
    """A second place that belongs to a diagnostic, with a few words about it."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One cause, one message.

    `code` is stable (`BG201`); `message` is lower case without a full stop, in the
    user's terms; `span` is the smallest place at fault, None when there is none (a missing
    file, a missing compiler); `help` is the way out.
    """

    code: str
    severity: Severity
    message: str
    span: Span | None = None
    note: str = ""
    labels: tuple[Label, ...] = ()
    help: str = ""


def as_error(diagnostic: Diagnostic) -> Diagnostic:
    """Make an error of a warning, as `--strict` asks, and say so; an error stays what it is."""
    if diagnostic.severity is not Severity.WARNING:
        return diagnostic
    reason = "a warning, which `strict` makes an error"
    note = f"{diagnostic.note}\n{reason}" if diagnostic.note else reason
    return replace(diagnostic, severity=Severity.ERROR, note=note)


class BgError(Exception):
    """The user's model, command or machine is at fault; carries the diagnostics to print."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(map(_line, self.diagnostics)))


def _line(diagnostic: Diagnostic) -> str:
    """A diagnostic in one line, as a Python traceback ends: place, code, message, way out."""
    place = ""
    if diagnostic.span is not None:
        source = diagnostic.span.source
        line, column = source.position(diagnostic.span.start)
        place = f"{source.name}:{line}:{column}: "
    way_out = f" ({diagnostic.help})" if diagnostic.help else ""
    return f"{place}{diagnostic.code}: {diagnostic.message}{way_out}"
