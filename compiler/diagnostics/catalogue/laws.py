"""Diagnostics: laws of elements, initial values and equations."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, either, error
from bgc.diagnostics.source import Span


@error(
    "BG430: `{name}` is a model and takes no law",
    "give it arguments, or extend it with `model .. is`",
)
def law_of_model(span: Span, name: str) -> None: ...
@error("BG431: `{name}`, {kind:an}, has no law", "{way}")
def law_missing(span: Span, name: str, kind: str, way: str) -> None: ...
@error("BG432: `{name}` has both the argument `{argument}` and {other}", "remove one of them")
def law_and_argument(span: Span, name: str, argument: str, other: str = "a law") -> None: ...
@error("BG433: a law of {kind} cannot start with `{left}`", "write {have:either}")
def law_not_of_this(span: Span, kind: str, left: str, have: Sequence[str]) -> None: ...
@error(
    "BG447: the ratio of `{name}` cannot be computed from its flows: {why}",
    "give efforts instead: `e2 = r*f1` or `e1 = r*f2`",
)
def flows_not_invertible(span: Span, name: str, why: str) -> None: ...
@error(
    "BG434: `{left} = ..` of {kind} must depend on `{right}`, not on `{found}`",
    "write it in terms of `{right}`",
)
def law_variable_misplaced(span: Span, kind: str, left: str, found: str, right: str) -> None: ...
@error(
    "BG435: `{name}` is a variable of the element and also a value of this model",
    "rename the value `{name}`",
)
def law_variable_is_a_name(span: Span, name: str) -> None: ...
@error(
    "BG436: the law of `{name}` is not linear in `{right}`",
    "write it as a factor or matrix times `{right}`; give nonlinear storage by its energy `H = ..`",
)
def law_not_linear(span: Span, name: str, right: str) -> None: ...
@error(
    "BG437: the law of `{name}` {verb} `{left}[{component}]`, one of its {width} components",
    "write one equation for each component, or one for the whole vector",
)
def law_incomplete(
    span: Span, name: str, left: str, width: int, component: int, repeated: bool = False
) -> Values:
    return {"verb": "repeats" if repeated else "omits"}


@error("BG438: the law of `{name}` has too many equations", "{needed}")
def law_too_many(span: Span, name: str, needed: str) -> None: ...
@error(
    "BG439: {what} must be {expected}, not {found}",
    "give a scalar, a vector with one value for each component, or a matrix",
)
def wrong_matrix(span: Span, what: str, expected: str, found: str) -> None: ...
@error(
    "BG440: `{name}` varies during the run, so it must be a modulated element",
    "write `M{kind}` instead of `{kind}`",
)
def modulated(span: Span, name: str, kind: str) -> None: ...
@error(
    "BG441: the law of `{name}`, {kind:an}, depends on something other than its own state",
    "use constants and parameters, an energy law, or an MTF before it",
)
def storage_varies(span: Span, name: str, kind: str) -> None: ...
@error(
    "BG442: the matrix of `{name}` is not skew: entry [{row}, {column}] is not the opposite of "
    "[{column}, {row}]",
    "correct the matrix; use an R to dissipate power",
)
def not_skew(span: Span, name: str, row: int, column: int) -> None: ...
@error("BG443: `{name}`, {kind:an}, has no bond {missing} it", "write `.. -> name -> ..`")
def one_sided(span: Span, name: str, kind: str, missing: str) -> None: ...
@error(
    "BG444: the two equations of `{name}` are not inverse to each other",
    "correct one, or remove one",
)
def inverse_differs(span: Span, name: str) -> None: ...
@error(
    "BG446: `{name}` is not an initial value of {kind}", "remove it: this element stores nothing"
)
def initial_not_of_this(span: Span, name: str, kind: str, have: Sequence[str]) -> Values:
    return {"help": f"give {either(have)}" if have else ""}


@error("BG450: `{name}` is not a state of this model", "declare it: `state {name} = ..;`")
def not_a_state(span: Span, name: str) -> None: ...
@error("BG451: the state `{name}` has no equation for its rate", "write `der({name}) = ..;`")
def state_without_equation(span: Span, name: str) -> None: ...
@error(
    "BG452: {equations:counted equation} for {unknowns:counted unknown}",
    "give each `unknown`, and each state without `der(x) = ..;`, one equation",
)
def equations_and_unknowns(span: Span, equations: int, unknowns: int) -> None: ...
@error(
    "BG455: `{name}` is {kind:an} and takes no law",
    "put the law on an element that is bonded to it",
)
def law_of_junction(span: Span, name: str, kind: str) -> None: ...
@error("BG456: {message}", "give other constants to the part", labels={"place": "asserted here"})
def false_assert(span: Span, message: str, place: Span) -> None: ...
