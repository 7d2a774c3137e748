"""Diagnostics of sampled parts: `sample`, `next`, and values that they hold."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def not_in_sample(span: Span, what: str) -> Diagnostic:
    """BG485: a statement that a sampled part cannot hold"""
    return error(
        "BG485",
        f"{what} cannot stand in a sampled part",
        span,
        help="write it outside the block, where it may read the block's outputs",
    )


def next_of_what(span: Span, name: str) -> Diagnostic:
    """BG486: a `next` of a value that is not a state of its sampled part"""
    return error(
        "BG486",
        f"`{name}` is not a state of a sampled part around this `next`",
        span,
        help=f"declare it in the block: `state {name} = ..;`; a state that is integrated has "
        "`der(..) = ..;`",
    )


def state_without_next(span: Span, name: str) -> Diagnostic:
    """BG487: a sampled state that nothing changes"""
    return error(
        "BG487",
        f"the sampled state `{name}` has no `next`",
        span,
        help=f"write `next({name}) = ..;` in the block",
    )


def bad_period(span: Span, value: float) -> Diagnostic:
    """BG488: a sampling period that is not positive"""
    return error(
        "BG488",
        f"a sampling period of {value:g} s is not positive",
        span,
        help="give a positive time, such as `10 ms`",
    )


def steady_of_sampled(names: Sequence[str]) -> Diagnostic:
    """BG772: an equilibrium of a model with sampled parts"""
    return error(
        "BG772",
        f"no equilibrium is searched for with sampled values ({listed(names)})",
        help='simulate until the model is at rest, for example by `--at "20 s"`',
    )


def held_too_early(span: Span, held: str, what: str, declared: Span) -> Diagnostic:
    """BG489: a sampled value where it is not known yet"""
    return error(
        "BG489",
        f"{what} depends on the sampled value `{held}`",
        span,
        labels=[Label(declared, "held between instants")],
        help="use the expression or the parameter that it starts from",
    )


def bad_sample(time: float, names: Sequence[str], place: Span | None = None) -> Diagnostic:
    """BG771: a sampled value that is not finite"""
    name = f" `{names[0]}`" if names else ""
    return error(
        "BG771",
        f"at t = {time:.9g} s the sampled value{name} is not finite",
        place,
        help="guard the expression that gives it, for example by an `if`",
    )
