"""Arguments of a run as SI numbers."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.diagnostic import BgError
from bgc.language.records import Where, options_of
from bgc.language.solver import Solver, SolverKeywords
from bgc.runtime.running.quantity import Quantity, in_si

_Function = TypeVar("_Function", bound=Callable[..., Any])
_RUN = re.compile(r" {8}\*\*run\n(?: {12}.*\n)+")  # the paragraph of a docstring
_STARTS = (None, "rest", "given")


def seconds_of(value: Quantity | None, name: str = "duration") -> float | None:
    """Return a time in s; None for None."""
    return in_si(value, name, "s")


def read_solver(given: Mapping[str, Any]) -> Solver:
    """Read `SolverKeywords`.

    Raises BgError: BG066 for a value out of its range, BG062, BG063 or BG790 for one that is no
    number of its unit. The doors refuse unknown keywords (`bgc.diagnostics.public`).
    """
    values: dict[str, Any] = {}
    for name, option in options_of(Solver, Where.PYTHON).items():
        keyword = option.keyword
        value: Any = given.get(keyword)
        if option.kind is bool and value not in _STARTS:
            raise BgError([bad_option(keyword, value, "`rest` or `given`", "rest")])
        if value is None:
            continue
        value = in_si(value, keyword, option.unit or "") if option.kind is float else value
        if option.kind in (float, int) and (problem := option.problem(keyword, value)):
            raise BgError([problem])
        values[name] = value
    return Solver(**values)


def with_solver_keywords(function: _Function) -> _Function:
    """Show the keywords of a solver in the signature and the documentation of a function.

    They take the place of its argument `**run: Unpack[SolverKeywords]`; in its documentation that
    of a paragraph `**run`, or of that name among others.
    """
    own = inspect.signature(function)
    shown = [p for p in own.parameters.values() if p.kind is not p.VAR_KEYWORD]
    text, options = "", options_of(Solver, Where.PYTHON).values()
    for option in options:
        kind = getattr(SolverKeywords.__annotations__[option.keyword], "__forward_arg__", "")
        keyword_only = inspect.Parameter.KEYWORD_ONLY
        shown.append(inspect.Parameter(option.keyword, keyword_only, default=None, annotation=kind))
        meaning = f"{option.help} By default {option.default}."
        text += (
            f"        {option.keyword}\n{textwrap.indent(textwrap.fill(meaning, 88), ' ' * 12)}\n"
        )
    function.__signature__ = own.replace(parameters=shown)  # type: ignore[attr-defined]
    named = _RUN.sub(text, function.__doc__ or "")
    function.__doc__ = named.replace("**run", ", ".join(option.keyword for option in options))
    return function
