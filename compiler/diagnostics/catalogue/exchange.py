"""BG757: exchange of the model of a running loop."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def cannot_exchange(reason: str) -> Diagnostic:
    """BG757: a model cannot take the place of another one in a running loop"""
    return error(
        "BG757",
        f"this model cannot take the place of the one in the loop: {reason}",
        help="scenes of one loop have devices of the same names, and the same `step`",
    )
