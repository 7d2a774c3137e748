"""Warnings of methods that return bare numbers, through Python's `warnings`."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.render import render

_PACKAGE = __name__.partition(".")[0]


class BgWarning(UserWarning):
    """A warning about a model or a run, with its `diagnostic`."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(render([diagnostic], colour=False).rstrip())
        self.diagnostic = diagnostic


def announce(diagnostics: Iterable[Diagnostic]) -> None:
    """Warn by `warnings.warn`, at the line of the caller that is not of this package."""
    depth, frame = 2, sys._getframe(1)
    while frame.f_back is not None and _is_own(frame.f_globals):
        frame = frame.f_back
        depth += 1
    for diagnostic in diagnostics:
        warnings.warn(BgWarning(diagnostic), stacklevel=depth)


def _is_own(names: dict[str, object]) -> bool:
    return str(names.get("__name__", "")).partition(".")[0] == _PACKAGE
