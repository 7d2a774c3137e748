"""Diagnostics: sampled parts."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error
from bgc.diagnostics.source import Span


@error(
    "BG485: {what} cannot stand in a sampled part",
    "write it outside the block, where it may read the block's outputs",
)
def not_in_sample(span: Span, what: str) -> None: ...
@error(
    "BG486: `{name}` is not a state of a sampled part around this `next`",
    "declare it in the block: `state {name} = ..;`; a state that is integrated has `der(..) = ..;`",
)
def next_of_what(span: Span, name: str) -> None: ...
@error("BG487: the sampled state `{name}` has no `next`", "write `next({name}) = ..;` in the block")
def state_without_next(span: Span, name: str) -> None: ...
@error(
    "BG488: a sampling period of {value:g} s is not positive",
    "give a positive time, such as `10 ms`",
)
def bad_period(span: Span, value: float) -> None: ...
@error(
    "BG772: no equilibrium is searched for with sampled values ({names:listed})",
    'simulate until the model is at rest, for example by `--at "20 s"`',
)
def steady_of_sampled(names: Sequence[str]) -> None: ...
@error(
    "BG489: {what} depends on the sampled value `{held}`",
    "use the expression or the parameter that it starts from",
    labels={"declared": "held between instants"},
)
def held_too_early(span: Span, held: str, what: str, declared: Span) -> None: ...
@error(
    "BG771: at t = {time:.9g} s the sampled value{name} is not finite",
    "guard the expression that gives it, for example by an `if`",
)
def bad_sample(time: float, names: Sequence[str], span: Span | None = None) -> Values:
    return {"name": f" `{names[0]}`" if names else ""}
