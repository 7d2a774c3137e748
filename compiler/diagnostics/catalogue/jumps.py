"""Diagnostics: events: `when` and `reset`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, listed, warning
from bgc.diagnostics.source import Span


@error("BG267: the {missing} of `{word}` is missing", "{form}")
def incomplete_head(span: Span, word: str, missing: str, form: str) -> None: ...
@error("BG480: this `when` resets nothing", "write `reset x = value;` in its braces, or remove it")
def empty_when(span: Span) -> None: ...
@error(
    "BG481: `{name}` cannot be reset: {what}",
    "reset a declared `state`, or the `q` or `p` of a storage element",
)
def not_resettable(span: Span, name: str, what: str) -> None: ...
@error(
    "BG482: `{name}` cannot be reset alone, since it{also}",
    "write the common inertia as one element, or put a stiff spring and a damper between "
    "the elements",
    labels={"declared": "this element"},
)
def dependent_reset(span: Span, name: str, others: Sequence[str], declared: Span | None) -> Values:
    return {
        "also": f" shares a state with {listed(others)}" if others else " has no state of its own"
    }


@error("BG483: the condition of this `when` {why}")
def condition_without_edge(span: Span, why: str, help: str) -> None: ...
@warning("BG484: these values are equal for an instant only, and {effect}")
def equal_for_an_instant(span: Span, timed: bool) -> Values:
    effect = "the instant adds nothing" if timed else "a run steps over the instant it is passed"
    other = "`time >= 3 s` from then on, or `when time >= 3 s { reset .. }`"
    near = "with `<` or `>=`, or with a tolerance: `abs(v) < 1 mm/s`"
    return {"effect": effect, "help": f"compare by `>=`: {other}" if timed else f"compare {near}"}


@error(
    "BG770: at t = {time:.9g} s jumps follow each other ever faster, without end",
    "end the run before, model a contact by a spring (C) and a damper (R), or give a "
    "relay two thresholds, one for each direction",
)
def endless_jumps(time: float, span: Span | None = None) -> None: ...
