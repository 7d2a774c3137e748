"""Diagnostics of `bgc import`: files of other tools."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def not_importable(what: str, span: Span | None = None, help: str = "") -> Diagnostic:
    """BG137: a file that `bgc import` cannot read"""
    return error("BG137", what, span, help=help)


def wrong_value(span: Span | None, what: str, help: str) -> Diagnostic:
    """BG138: a value in an imported file that is missing or wrong"""
    return error("BG138", what, span, help=help)


def left_out(span: Span | None, what: str, help: str) -> Diagnostic:
    """BG139: something in an imported file that is left out or changed"""
    return warning("BG139", what, span, help=help)


def wrong_structure(
    span: Span | None, what: str, help: str, labels: tuple[Label, ...] = ()
) -> Diagnostic:
    """BG270: links and joints that do not form a tree"""
    return error("BG270", what, span, labels=labels, help=help)


def odd_inertia(span: Span | None, what: str) -> Diagnostic:
    """BG549: an inertia that no body can have"""
    return warning("BG549", what, span, help="check the inertia: it is imported as it is")
