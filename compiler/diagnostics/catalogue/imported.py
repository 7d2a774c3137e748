"""Diagnostics: import from other tools."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Label
from bgc.diagnostics.source import Span


@error("BG137: {what}")
def not_importable(what: str, span: Span | None = None, help: str = "") -> None: ...
@error("BG138: {what}")
def wrong_value(span: Span | None, what: str, help: str) -> None: ...
@warning("BG139: {what}")
def left_out(span: Span | None, what: str, help: str) -> None: ...
@error("BG270: {what}")
def wrong_structure(
    span: Span | None, what: str, help: str, labels: tuple[Label, ...] = ()
) -> None: ...
@warning("BG549: {what}", "check the inertia: it is imported as it is")
def odd_inertia(span: Span | None, what: str) -> None: ...
@warning("BG552: {what}", "{cause}")
def contradicting(what: str, cause: str) -> None: ...
