"""Diagnostics: storage elements and their initial values."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, listed
from bgc.diagnostics.diagnostic import Fault
from bgc.diagnostics.source import Span


@error(
    "BG510: the law of `{name}` depends on {on}",
    "write it as a field with one port for each variable that its energy depends on",
)
def variable_storage(span: Span, name: str, on: str) -> None: ...
@error("BG511: the {what} of `{name}` is zero or singular", "make it positive")
def storage_not_positive(span: Span, name: str, what: str) -> None: ...
@error(
    "BG512: the storage of `{name}` {depends}, and {why}",
    "put an I on the motion that joins them, or an R or a C that acts on it directly",
)
def dependent_storage(span: Span, name: str, others: Sequence[str], why: str) -> Values:
    return {"depends": f"depends on {listed(others)}" if others else "is not independent"}


@error(
    "BG513: {names:listed} can move without inertia",
    "give the moving part an inertia, or connect it by a C",
    fault=Fault.CHOICE,
)
def motion_without_inertia(span: Span, names: Sequence[str]) -> None: ...
@error("BG514: `{name}` is given both `{first}` and `{second}`", "remove one of them")
def initial_twice(span: Span, name: str, first: str, second: str) -> None: ...
@error("BG515: {problem}")
def initial_unusable(span: Span, name: str, variable: str, *, of_junction: bool = False) -> Values:
    if of_junction:
        return {
            "problem": f"`{variable}` of `{name}` does not follow from charges and momenta",
            "help": "omit it; it follows from how fast they change",
        }
    instead = {"e0": "give `q0` instead", "f0": "give `p0` instead"}
    return {
        "problem": f"the state of `{name}` cannot be computed from `{variable}`",
        "help": instead.get(variable, "give the other variable of the element instead"),
    }


@error(
    "BG516: `{variable}` of `{name}` contradicts {against}",
    "give only one of them; the other follows",
    fault=Fault.START,
)
def initial_conflict(span: Span, name: str, variable: str, others: Sequence[str]) -> Values:
    return {
        "against": f"the initial values of {listed(others)}"
        if others
        else "what drives or holds it"
    }


# Make BG516 for an initial value that a source contradicts; see `initial_conflict`.
@error(
    "BG516: `{variable}` of `{name}` contradicts the source `{source}`, which gives its {what}",
    "make the two agree at the start{by}, or bond a resistor between them, across which "
    "they may differ",
    labels={"place": "gives the {what} of `{name}`, with no resistor between them"},
    fault=Fault.START,
)
def initial_against_source(
    span: Span, name: str, variable: str, source: str, place: Span, parameters: Sequence[str]
) -> Values:
    return {
        "what": "effort" if variable in ("q0", "e0") else "flow",
        "by": f" by {listed(parameters, 4)}" if parameters else "",
    }


@error(
    "BG518: there is no `{name}`: the energy does not depend on it",
    "omit it; that port stores energy by its charge `q` alone",
)
def no_momentum(span: Span, name: str) -> None: ...
@error(
    "BG517: no state was found at which `{variable}` of `{name}` has its value",
    "give a value that the laws reach, or give `q0` and `p0` instead",
    note="laws that are not linear, its own or those of others that it starts with, give the state",
    fault=Fault.START,
)
def initial_out_of_reach(span: Span, name: str, variable: str) -> None: ...
