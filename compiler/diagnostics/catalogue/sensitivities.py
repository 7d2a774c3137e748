"""Diagnostics: sensitivities of a run."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, error, quoted
from bgc.diagnostics.source import Span


@error(
    "BG784: no sensitivities are available here: {reason}",
    "{help}",
)
def not_followed(reason: str, help: str) -> None: ...
@error(
    "BG785: at t = {time:.9g} s an event has no derivative{by}: what causes it only touches its "
    "edge",
    "end the run before, or change the start or a parameter a little",
)
def grazing(time: float, states: tuple[str, ...] = (), span: Span | None = None) -> Values:
    return {"by": _by(states)}


@error(
    "BG786: at t = {time:.9g} s an event has no derivative{by}: another one, which the parameters "
    "move otherwise, happens at the same time",
    "end the run before, or change the start or a parameter so that one comes first",
)
def simultaneous(time: float, states: tuple[str, ...] = (), span: Span | None = None) -> Values:
    return {"by": _by(states)}


@error(
    "BG774: the start has no derivative by `{name}`: {reason}",
    'start from given values (`start="given"` in Python), or leave this parameter out',
)
def start_not_followed(name: str, reason: str) -> None: ...
def _by(states: tuple[str, ...]) -> str:
    """Name the states that a switch reads, if they are few."""
    return f" by a switch on {quoted(states)}" if 0 < len(states) <= 3 else ""
