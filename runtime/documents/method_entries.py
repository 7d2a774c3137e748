"""Integration methods as entries of the reference."""

from __future__ import annotations

from bgc.language.methods import METHODS, SWITCHING, SWITCHING_FIXED, default_method
from bgc.language.solver import options_of_method
from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Code, Entry, Group, Text
from bgc.reference.word_entries import solver_options

_OTHERS = {
    "cvode": "BDF of SUNDIALS, where it is installed: for comparison",
    "auto": "the configuration that `bgc trade` recommended for the scene",
}


def _entry(name: str) -> Entry:
    if name not in METHODS:
        related = ("BG046", "BG047") if name == "cvode" else ("require", "deadline", "BG090")
        return Entry("method", name, _OTHERS[name], (Code(f"solver {name};"),), related)
    method = METHODS[name]
    example = "step = 1 ms" if method.fixed else "rtol = 1e-8"
    control = (
        "Fixed steps, given by `step`."
        if method.fixed
        else f"Adaptive steps; the error is estimated by a solution of order {method.error_order}."
    )
    needs = (
        "Every step solves linear equations with the analytic Jacobian."
        if method.family.jacobian
        else "Explicit: no Jacobian, no algebraic equations, and a short step where stiff."
    )
    family = method.family.name[:1].upper() + method.family.name[1:]
    body: tuple[Block, ...] = (
        Code(f"solver {name}({example});"),
        Text(f"{family}, order {method.order}. {control} {needs}"),
        solver_options(options_of_method(name)),
    )
    return Entry("method", name, method.purpose, body, ("solver", "methods"))


def _summaries() -> dict[str, str]:
    return {name: method.purpose for name, method in METHODS.items()} | _OTHERS


def _listing() -> tuple[Block, ...]:
    """List the methods with their properties."""
    rows = tuple(
        (m.name, m.family.name, str(m.order), "fixed" if m.fixed else "adaptive", m.purpose)
        for m in METHODS.values()
    )
    others = tuple((name, "", "", "", text) for name, text in _OTHERS.items())
    header = ("name", "family", "order", "step", "for")
    adaptive, fixed = (default_method(fixed=f) for f in (False, True))
    default = (
        f"Without a `solver` it is `{fixed}` where the scene has a `step`, else `{adaptive}`, "
        f"and `{SWITCHING_FIXED}` or `{SWITCHING}` where explicit steps may cost less "
        "(`bgc doc solver`)."
    )
    return (Text(default), Table("", header, (*rows, *others)), solver_options())


GROUP = Group(
    "methods",
    "integration methods and their options",
    _summaries,
    _entry,
    (Code("solver rodas5p(rtol = 1e-8);"),),
    ("method", "solvers", "integrators"),
    _listing,
)
"""All integration methods."""
