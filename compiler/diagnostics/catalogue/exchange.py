"""Diagnostics: exchange of a running model."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error


@error(
    "BG757: this model cannot take the place of the one in the loop: {reason}",
    "scenes of one loop have devices of the same names, and the same `step`",
)
def cannot_exchange(reason: str) -> None: ...
