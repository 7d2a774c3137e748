"""Diagnostics of sampled parts: `sample`, `next`, and values that they hold."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def not_in_sample(span: Span, what: str) -> Diagnostic:
    """BG485: a statement that a sampled part cannot hold

    What: a `sample` block has a statement other than `state`, `output`, `signal`, `let`, `const`,
    `next(..) = ..;`, the definition of one of its outputs, `for` and `if`.
    Why: a sampled part computes at instants. Parts, bonds and `der` act at all times.
    Example: `sample 10 ms { damper : R(2); }`
    Way out: write it outside the block, where it may read the block's outputs.
    """
    return error(
        "BG485",
        f"{what} cannot stand in a sampled part",
        span,
        help="write it outside the block, where it may read the block's outputs",
    )


def next_of_what(span: Span, name: str) -> Diagnostic:
    """BG486: a `next` of a value that is not a state of its sampled part

    What: `next(x) = ..;` stands outside a `sample` block, or x is not a `state` of that block.
    Why: only a sampled part has states that change at its instants; each block gives those of
    its own.
    Example: `state x = 0; sample 10 ms { next(x) = x + 1; }`
    Way out: declare the state in the block: `sample 10 ms { state x = 0; next(x) = x + 1; }`.
    """
    return error(
        "BG486",
        f"`{name}` is not a state of a sampled part around this `next`",
        span,
        help=f"declare it in the block: `state {name} = ..;`; a state that is integrated has "
        "`der(..) = ..;`",
    )


def state_without_next(span: Span, name: str) -> Diagnostic:
    """BG487: a sampled state that nothing changes

    What: a `state` of a `sample` block has no `next(..) = ..;`, or not for each of its components.
    Why: it would keep its start for ever; `next` may have been forgotten.
    Example: `sample 10 ms { state i = 0; output u = i; }`
    Way out: write `next(i) = ..;`, or declare it as a `const` or a `let`.
    """
    return error(
        "BG487",
        f"the sampled state `{name}` has no `next`",
        span,
        help=f"write `next({name}) = ..;` in the block",
    )


def bad_period(span: Span, value: float) -> Diagnostic:
    """BG488: a sampling period that is not positive

    What: the period of a `sample` block is zero or negative.
    Why: its instants are the multiples of the period.
    Example: `sample 0 s { .. }`
    Way out: give a positive time, such as `sample 10 ms { .. }`.
    """
    return error(
        "BG488",
        f"a sampling period of {value:g} s is not positive",
        span,
        help="give a positive time, such as `10 ms`",
    )


def steady_of_sampled(names: Sequence[str]) -> Diagnostic:
    """BG772: an equilibrium of a model with sampled parts

    What: `--steady` was asked of a scene whose states depend on values of sampled parts.
    Why: a linear form takes sampled values as constants, and an equilibrium with those of the start
    is not the one to which the controller would lead.
    Example: `bgc equations controlled.bg --linear --steady`
    Way out: simulate until the model is at rest: `--at "20 s"`.
    """
    return error(
        "BG772",
        f"no equilibrium is searched for with sampled values ({listed(names)})",
        help='simulate until the model is at rest, for example by `--at "20 s"`',
    )


def held_too_early(span: Span, held: str, what: str, declared: Span) -> Diagnostic:
    """BG489: a sampled value where it is not known yet

    What: an initial value or a projection depends on an output or state of a sampled part.
    Why: initial values are computed before the first instant, and a projection depends on states
    and time alone.
    Example: `sample 10 ms { output u = 1; }  state x = u;`
    Way out: use the expression or the parameter that the sampled value starts from.
    """
    return error(
        "BG489",
        f"{what} depends on the sampled value `{held}`",
        span,
        labels=[Label(declared, "held between instants")],
        help="use the expression or the parameter that it starts from",
    )


def bad_sample(time: float, names: Sequence[str], place: Span | None = None) -> Diagnostic:
    """BG771: a sampled value that is not finite

    What: at an instant of a sampled part, an output or the next value of a state is infinite or
    undefined. The rows up to there are right.

    Why: a value that is held would carry it into everything that reads it.

    Example: `sample 1 s { state n = 2; next(n) = n - 1; output u = 1/n; }` at the third instant.

    Way out: guard the expression, for example by `if abs(n) > 0 then 1/n else 0`.
    """
    name = f" `{names[0]}`" if names else ""
    return error(
        "BG771",
        f"at t = {time:.9g} s the sampled value{name} is not finite",
        place,
        help="guard the expression that gives it, for example by an `if`",
    )
