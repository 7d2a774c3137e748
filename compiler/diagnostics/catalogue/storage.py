"""Diagnostics of storage and its initial values."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def variable_storage(span: Span, name: str, on: str) -> Diagnostic:
    """BG510: a storage law that depends on another variable"""
    return error(
        "BG510",
        f"the law of `{name}` depends on {on}",
        span,
        help="write it as a field with one port for each variable that its energy depends on",
    )


def storage_not_positive(span: Span, name: str, what: str) -> Diagnostic:
    """BG511: a storage element without a usable value"""
    return error(
        "BG511", f"the {what} of `{name}` is zero or singular", span, help="make it positive"
    )


def dependent_storage(span: Span, name: str, others: Sequence[str], why: str) -> Diagnostic:
    """BG512: dependent storage that cannot be merged"""
    depends = f"depends on {listed(others)}" if others else "is not independent"
    return error(
        "BG512",
        f"the storage of `{name}` {depends}, and {why}",
        span,
        help="put an I on the motion that joins them, or an R or a C that acts on it directly",
    )


def motion_without_inertia(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG513: a motion without inertia"""
    return error(
        "BG513",
        f"{listed(names)} can move without inertia",
        span,
        help="give the moving part an inertia, or connect it by a C",
    )


def initial_twice(span: Span, name: str, first: str, second: str) -> Diagnostic:
    """BG514: an initial value given twice"""
    return error(
        "BG514", f"`{name}` is given both `{first}` and `{second}`", span, help="remove one of them"
    )


def initial_unusable(
    span: Span, name: str, variable: str, *, of_junction: bool = False
) -> Diagnostic:
    """BG515: an initial value that cannot be converted"""
    if of_junction:
        return error(
            "BG515",
            f"`{variable}` of `{name}` does not follow from charges and momenta",
            span,
            help="omit it; it follows from how fast they change",
        )
    instead = {"e0": "give `q0` instead", "f0": "give `p0` instead"}
    return error(
        "BG515",
        f"the state of `{name}` cannot be computed from `{variable}`",
        span,
        help=instead.get(variable, "give the other variable of the element instead"),
    )


def initial_conflict(span: Span, name: str, variable: str, others: Sequence[str]) -> Diagnostic:
    """BG516: contradictory initial values"""
    against = f"the initial values of {listed(others)}" if others else "what drives or holds it"
    return error(
        "BG516",
        f"`{variable}` of `{name}` contradicts {against}",
        span,
        help="give only one of them; the other follows",
    )


def initial_against_source(
    span: Span, name: str, variable: str, source: str, place: Span, parameters: Sequence[str]
) -> Diagnostic:
    """Make BG516 for an initial value that a source contradicts; see `initial_conflict`."""
    what = "effort" if variable in ("q0", "e0") else "flow"
    by = f" by {listed(parameters, 4)}" if parameters else ""
    return error(
        "BG516",
        f"`{variable}` of `{name}` contradicts the source `{source}`, which gives its {what}",
        span,
        labels=[Label(place, f"gives the {what} of `{name}`, with nothing between them")],
        help=f"make the two agree at the start{by}, or bond a resistor between them, across which "
        "they may differ",
    )


def no_momentum(span: Span, name: str) -> Diagnostic:
    """BG518: a momentum that does not exist"""
    return error(
        "BG518",
        f"there is no `{name}`: the energy does not depend on it",
        span,
        help="omit it; that port stores energy by its charge `q` alone",
    )


def initial_out_of_reach(span: Span, name: str, variable: str) -> Diagnostic:
    """BG517: an initial value out of reach"""
    return error(
        "BG517",
        f"no state was found at which `{variable}` of `{name}` has its value",
        span,
        note="the element is rigidly connected to others, and not all laws are linear",
        help="give a value that the laws reach, or give `q0` and `p0` instead",
    )
