"""Diagnostics of `when` and `reset`, and of the first line of `when` and `sample`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def incomplete_head(span: Span, word: str, missing: str, form: str) -> Diagnostic:
    """BG267: a `when` or `sample` whose first line is not complete"""
    return error("BG267", f"the {missing} of `{word}` is missing", span, help=form)


def empty_when(span: Span) -> Diagnostic:
    """BG480: a `when` without a `reset`"""
    return error(
        "BG480",
        "this `when` resets nothing",
        span,
        help="write `reset x = value;` in its braces, or remove it",
    )


def not_resettable(span: Span, name: str, what: str) -> Diagnostic:
    """BG481: a reset of a value that is not a state"""
    return error(
        "BG481",
        f"`{name}` cannot be reset: {what}",
        span,
        help="reset a declared `state`, or the `q` or `p` of a storage element",
    )


def dependent_reset(
    span: Span, name: str, others: Sequence[str], declared: Span | None
) -> Diagnostic:
    """BG482: a reset of storage without a state of its own"""
    also = f" shares a state with {listed(others)}" if others else " has no state of its own"
    return error(
        "BG482",
        f"`{name}` cannot be reset alone, since it{also}",
        span,
        labels=[] if declared is None else [Label(declared, "this element")],
        help="write the common inertia as one element, or put a stiff spring and a damper between "
        "the elements",
    )


def condition_without_edge(span: Span, why: str, help: str) -> Diagnostic:
    """BG483: a condition of `when` that has no rising edge"""
    return error("BG483", f"the condition of this `when` {why}", span, help=help)


def equal_for_an_instant(span: Span, timed: bool) -> Diagnostic:
    """BG484: a comparison by `==` or `!=` that changes for an instant only (a warning)"""
    effect = "the instant adds nothing" if timed else "a run steps over the instant it is passed"
    other = "`time >= 3 s` from then on, or `when time >= 3 s { reset .. }`"
    near = "with `<` or `>=`, or with a tolerance: `abs(v) < 1 mm/s`"
    return warning(
        "BG484",
        f"these values are equal for an instant only, and {effect}",
        span,
        help=f"compare by `>=`: {other}" if timed else f"compare {near}",
    )


def endless_jumps(time: float, place: Span | None = None) -> Diagnostic:
    """BG770: jumps that follow each other ever faster"""
    return error(
        "BG770",
        f"at t = {time:.9g} s jumps follow each other ever faster, without end",
        place,
        help="end the run before, model a contact by a spring (C) and a damper (R), or give a "
        "relay two thresholds, one for each direction",
    )
