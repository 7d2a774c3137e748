"""Diagnostics of `when` and `reset`, and of the first line of `when` and `sample`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def incomplete_head(span: Span, word: str, missing: str, form: str) -> Diagnostic:
    """BG267: a `when` or `sample` whose first line is not complete

    What: a `when` has no condition, a `sample` has no period, or the `{` behind it is missing.
    Why: the statements in the braces apply when the condition becomes true, or once in each period.
    Example: `when height < 0 m reset speed = 0;`
    Way out: write `when height < 0 m { reset speed = 0; }` and `sample 10 ms { .. }`.
    """
    return error("BG267", f"the {missing} of `{word}` is missing", span, help=form)


def empty_when(span: Span) -> Diagnostic:
    """BG480: a `when` without a `reset`

    What: there is no statement between the braces of a `when`.
    Why: it would do nothing.
    Example: `when x > 0 { }`
    Way out: write what happens: `when x > 0 { reset v = -v; }`, or remove it.
    """
    return error(
        "BG480",
        "this `when` resets nothing",
        span,
        help="write `reset x = value;` in its braces, or remove it",
    )


def not_resettable(span: Span, name: str, what: str) -> Diagnostic:
    """BG481: a reset of a value that is not a state

    What: `reset` names something other than a declared `state`, or the `q` or `p` of a storage
    element.
    Why: only a state keeps the value that it is given. All other values follow from the states.
    Example: `when z > 0 { reset hub.f = 0; }`
    Way out: reset the state behind it: the momentum `reset body.p = ..;` of a body, the charge
    `reset spring.q = ..;` of a spring. The state of a sampled part is given by `next(..) = ..;`.
    """
    return error(
        "BG481",
        f"`{name}` cannot be reset: {what}",
        span,
        help="reset a declared `state`, or the `q` or `p` of a storage element",
    )


def dependent_reset(
    span: Span, name: str, others: Sequence[str], declared: Span | None
) -> Diagnostic:
    """BG482: a reset of storage without a state of its own

    What: a `reset` names the displacement or momentum of an element whose value depends on that
    of others: bodies that are rigidly connected, springs in series, or parts of a closed chain.
    Why: the values of these elements cannot be chosen one by one, and how an impulse spreads over
    them is not given by the value of one.
    Example: two masses on one `J1`, and `reset first.p = 0;`
    Way out: write the common inertia as one element, or put a stiff spring (C) with a damper (R)
    between the elements, so that each has a state of its own.
    """
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
    """BG483: a condition of `when` that has no rising edge

    What: the condition of a `when` never changes from false to true at an instant that can be
    located: it depends on constants and parameters alone, it is not a comparison, or it compares a
    value that moves with `==` or `!=`.
    Why: a jump happens when the condition becomes true. Two values that move are equal for no time,
    so a run steps over that instant.
    Example: `when x == 1 { reset v = 0; }`
    Way out: compare by `<`, `<=`, `>` or `>=`: `when x >= 1 { reset v = 0; }`.
    """
    return error("BG483", f"the condition of this `when` {why}", span, help=help)


def equal_for_an_instant(span: Span, timed: bool) -> Diagnostic:
    """BG484: a comparison by `==` or `!=` that changes for an instant only (a warning)

    What: a rate depends on whether two values are equal, and one of them moves with time or with a
    state.
    Why: such values are equal for an instant, in which nothing changes by a finite rate. Where time
    alone moves them, the instant counts as not equal in all rates and powers, with every method. A
    state may rest at a value, so that the comparison is made, but a run steps over the instant at
    which the state passes it, unless a fixed step ends there.
    Example: `der(x) = if time == 3 s then 1 else 0;`
    Way out: for a change at that time, write `time >= 3 s`; for a short one,
    `time >= 3 s and time < 3.1 s`; for a jump of a state, `when time >= 3 s { reset x = x + 1; }`.
    Of a state, compare with a tolerance: `abs(v) < 1 mm/s`.
    """
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
    """BG770: jumps that follow each other ever faster

    What: a `when` becomes true again and again in ever shorter intervals, or two jumps cause each
    other without end at one instant, so the run cannot advance. The intervals have sunk to a part
    of 1e-9 of the time. The rows up to there are right.

    Why: a jump ends a contact at once, however often it returns; a ball that loses part of its
    speed at each bounce makes infinitely many bounces in a finite time. At rest it needs a force of
    the floor, which a jump does not give. A relay that switches on and off at one threshold has no
    position there.

    Example: `when height < 0 m { reset ball.p = -0.8*ball.p; }` once the ball has come to rest.

    Way out: end the run before; let the last jump start a rest, `when height < 0 m and speed <
    1 mm/s { reset resting = 1; }`, where `resting` switches the weight off; or model the contact by
    a spring and a damper. Give a relay a hysteresis: `when T > 22 { reset on = 0; }` and `when T <
    20 { reset on = 1; }`.
    """
    return error(
        "BG770",
        f"at t = {time:.9g} s jumps follow each other ever faster, without end",
        place,
        help="end the run before, model a contact by a spring (C) and a damper (R), or give a "
        "relay two thresholds, one for each direction",
    )
