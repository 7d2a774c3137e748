"""Kinds of plots of a study, and the studies that they fit: known before the first run."""

from __future__ import annotations

from typing import Final

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.diagnostic import BgError

STUDY_KINDS: Final = ("curves", "map", "contour", "scatter", "histogram")


def check_kind(kind: str, parameters: int) -> None:
    """Raise BG066 for a kind of plot that does not fit a number of varied parameters."""
    if kind not in STUDY_KINDS:
        raise BgError([bad_option("kind", kind, f"one of {', '.join(STUDY_KINDS)}", "scatter")])
    if kind in ("map", "contour") and parameters != 2:
        wanted = f"a plot of {counted(parameters, 'varied parameter')}"
        raise BgError([bad_option("kind", kind, wanted, "curves")])
    if kind != "histogram" and not parameters:
        raise BgError([bad_option("kind", kind, "`histogram` where nothing is varied", "")])
