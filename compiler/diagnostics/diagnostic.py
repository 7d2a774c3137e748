"""Diagnostics as values: message, place and way out."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import TypeVar

from bgc.diagnostics.source import Span
from bgc.record_class import dataclass, replace

Result = TypeVar("Result")


class Severity(Enum):
    """Severity: an error ends the compilation, a warning does not."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


class Fault(Enum):
    """The cause of an error: the model, the choice of independent flows, or the start."""

    MODEL = "model"
    CHOICE = "choice"  # in the flows chosen as independent: with others there may be none
    START = "start"  # in the start alone: the equations can be derived


@dataclass(frozen=True, slots=True)
class Label:
    """A further place that belongs to a diagnostic, with a short text."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Edit:
    """A way out that an editor can apply: the text that replaces a span, empty to remove it."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One cause, one message.

    `code` is stable (`BG201`). `message` is lower case, without a full stop, in the user's
    terms. `span` is the smallest place at fault, None without a place in a source (a missing
    file, a missing compiler). `help` is the way out, an imperative; `edits` are alternative
    texts for it, the most likely first. `fault` is the cause, by which the compiler decides
    whether to try another choice.
    """

    code: str
    severity: Severity
    message: str
    span: Span | None = None
    note: str = ""
    labels: tuple[Label, ...] = ()
    help: str = ""
    edits: tuple[Edit, ...] = ()
    fault: Fault = Fault.MODEL


def as_error(diagnostic: Diagnostic) -> Diagnostic:
    """Turn a warning into an error (`--strict`) and add a note; return an error unchanged."""
    if diagnostic.severity is not Severity.WARNING:
        return diagnostic
    reason = "this warning is an error because of `strict`"
    note = f"{diagnostic.note}\n{reason}" if diagnostic.note else reason
    return replace(diagnostic, severity=Severity.ERROR, note=note)


class BgError(Exception):
    """A fault of the user's model, command or machine, with the diagnostics to print."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(map(_line, self.diagnostics)))

    def _render_traceback_(self) -> list[str]:
        """Return the lines that IPython prints: the diagnostics with their excerpts, no frames."""
        notes: list[str] = getattr(self, "__notes__", [])
        return "\n".join(notes or [f"{type(self).__name__}: {self}"]).strip("\n").split("\n")


@dataclass(frozen=True, slots=True)
class Refused:
    """The refusal of one choice, as a value, so that the caller can try another."""

    error: BgError

    @property
    def faults(self) -> set[Fault]:
        """The causes of its errors."""
        return {diagnostic.fault for diagnostic in self.error.diagnostics}


def accepted(result: Result | Refused) -> Result:
    """Return the result of a choice, or raise the error (BgError) for which it was refused."""
    if isinstance(result, Refused):
        raise result.error
    return result


def _line(diagnostic: Diagnostic) -> str:
    """Format a diagnostic in one line: place, code, message, way out."""
    place = ""
    if diagnostic.span is not None:
        source = diagnostic.span.source
        line, column = source.position(diagnostic.span.start)
        place = f"{source.name}:{line}:{column}: "
    way_out = f" ({diagnostic.help})" if diagnostic.help else ""
    return f"{place}{diagnostic.code}: {diagnostic.message}{way_out}"
