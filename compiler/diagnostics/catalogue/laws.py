"""Diagnostics of elements' laws, initial values, states and equations."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def law_of_model(span: Span, name: str) -> Diagnostic:
    """BG430: a law block on a model"""
    return error(
        "BG430",
        f"`{name}` is a model and takes no law",
        span,
        help="give it arguments, or extend it with `model .. is`",
    )


def law_missing(span: Span, name: str, kind: str, way: str) -> Diagnostic:
    """BG431: an element without a law"""
    return error("BG431", f"`{name}`, {with_article(kind)}, has no law", span, help=way)


def law_and_argument(span: Span, name: str, argument: str, other: str = "a law") -> Diagnostic:
    """BG432: an element with two laws"""
    return error(
        "BG432",
        f"`{name}` has both the argument `{argument}` and {other}",
        span,
        help="remove one of them",
    )


def law_not_of_this(span: Span, kind: str, left: str, have: Sequence[str]) -> Diagnostic:
    """BG433: a law for a variable that the element does not have"""
    listing = " or ".join(f"`{h}`" for h in have)
    return error(
        "BG433", f"a law of {kind} cannot start with `{left}`", span, help=f"write {listing}"
    )


def flows_not_invertible(span: Span, name: str, why: str) -> Diagnostic:
    """BG447: a gyrator given by flows that cannot be inverted"""
    return error(
        "BG447",
        f"the ratio of `{name}` cannot be computed from its flows: {why}",
        span,
        help="give efforts instead: `e2 = r*f1` or `e1 = r*f2`",
    )


def law_variable_misplaced(span: Span, kind: str, left: str, found: str, right: str) -> Diagnostic:
    """BG434: a law in terms of the wrong variable"""
    return error(
        "BG434",
        f"`{left} = ..` of {kind} must depend on `{right}`, not on `{found}`",
        span,
        help=f"write it in terms of `{right}`",
    )


def law_variable_is_a_name(span: Span, name: str) -> Diagnostic:
    """BG435: a name that means two things in a law"""
    return error(
        "BG435",
        f"`{name}` is a variable of the element and also a value of this model",
        span,
        help=f"rename the value `{name}`",
    )


def law_not_linear(span: Span, name: str, right: str) -> Diagnostic:
    """BG436: a law that is not linear where it must be"""
    return error(
        "BG436",
        f"the law of `{name}` is not linear in `{right}`",
        span,
        help=f"write it as a factor or matrix times `{right}`; give nonlinear storage by its "
        "energy `H = ..`",
    )


def law_incomplete(
    span: Span, name: str, left: str, width: int, component: int, repeated: bool = False
) -> Diagnostic:
    """BG437: a law with missing or repeated components"""
    verb = "repeats" if repeated else "omits"
    return error(
        "BG437",
        f"the law of `{name}` {verb} `{left}[{component}]`, one of its {width} components",
        span,
        help="write one equation for each component, or one for the whole vector",
    )


def law_too_many(span: Span, name: str, needed: str) -> Diagnostic:
    """BG438: more equations than a law has"""
    return error("BG438", f"the law of `{name}` has too many equations", span, help=needed)


def wrong_matrix(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG439: a law's matrix of the wrong size"""
    return error(
        "BG439",
        f"{what} must be {expected}, not {found}",
        span,
        help="give a scalar, a vector with one value for each component, or a matrix",
    )


def modulated(span: Span, name: str, kind: str) -> Diagnostic:
    """BG440: a modulated element without the `M`"""
    return error(
        "BG440",
        f"`{name}` varies during the run, so it must be a modulated element",
        span,
        help=f"write `M{kind}` instead of `{kind}`",
    )


def storage_varies(span: Span, name: str, kind: str) -> Diagnostic:
    """BG441: a storage element with a varying law"""
    return error(
        "BG441",
        f"the law of `{name}`, {with_article(kind)}, depends on something other than its own state",
        span,
        help="use constants and parameters, an energy law, or an MTF before it",
    )


def not_skew(span: Span, name: str, row: int, column: int) -> Diagnostic:
    """BG442: a one-sided gyrator that is not skew"""
    return error(
        "BG442",
        f"the matrix of `{name}` is not skew: entry [{row}, {column}] is not the opposite of "
        f"[{column}, {row}]",
        span,
        help="correct the matrix; use an R to dissipate power",
    )


def one_sided(span: Span, name: str, kind: str, missing: str) -> Diagnostic:
    """BG443: a two-port with bonds on one side only"""
    return error(
        "BG443",
        f"`{name}`, {with_article(kind)}, has no bond {missing} it",
        span,
        help="write `.. -> name -> ..`",
    )


def inverse_differs(span: Span, name: str) -> Diagnostic:
    """BG444: two laws of a transformer that contradict each other"""
    return error(
        "BG444",
        f"the two equations of `{name}` are not inverse to each other",
        span,
        help="correct one, or remove one",
    )


def initial_not_of_this(span: Span, name: str, kind: str, have: Sequence[str]) -> Diagnostic:
    """BG446: an initial value that the element does not take"""
    listing = " or ".join(f"`{h}`" for h in have)
    return error(
        "BG446",
        f"`{name}` is not an initial value of {kind}",
        span,
        help=f"give {listing}" if have else "remove it: this element stores nothing",
    )


def not_a_state(span: Span, name: str) -> Diagnostic:
    """BG450: the derivative of a value that is not a state"""
    return error(
        "BG450",
        f"`{name}` is not a state of this model",
        span,
        help=f"declare it: `state {name} = ..;`",
    )


def state_without_equation(span: Span, name: str) -> Diagnostic:
    """BG451: a state without an equation"""
    return error(
        "BG451",
        f"the state `{name}` has no equation for its rate",
        span,
        help=f"write `der({name}) = ..;`",
    )


def equations_and_unknowns(span: Span, equations: int, unknowns: int) -> Diagnostic:
    """BG452: unequal numbers of equations and unknowns"""
    return error(
        "BG452",
        f"{_counted(equations, 'equation')} for {_counted(unknowns, 'unknown')}",
        span,
        help="give each `unknown`, and each state without `der(x) = ..;`, one equation",
    )


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def law_of_junction(span: Span, name: str, kind: str) -> Diagnostic:
    """BG455: a junction with a law"""
    return error(
        "BG455",
        f"`{name}` is {with_article(kind)} and takes no law",
        span,
        help="put the law on an element that is bonded to it",
    )


def false_assert(span: Span, message: str, place: Span) -> Diagnostic:
    """BG456: an `assert` that the constants of a part break"""
    return error(
        "BG456",
        message,
        span,
        labels=[Label(place, "asserted here")],
        help="give other constants to the part",
    )
