"""Diagnostics: data, interpolation, random numbers and `jacobian`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, did_you_mean, error, listed
from bgc.diagnostics.source import Span

# --- jacobian ---------------------------------------------------------------------------


@error(
    "BG475: `jacobian` differentiates by states, signals and inputs, not by an expression",
    "give the expression a name with `signal`, use the name in both arguments",
)
def jacobian_by_expression(span: Span) -> None: ...
@error(
    "BG476: `jacobian` differentiates a scalar or a vector, not {found}",
    "differentiate its rows or columns one by one",
)
def jacobian_of_matrix(span: Span, found: str) -> None: ...


# --- random numbers ---------------------------------------------------------------------


@error(
    "BG477: {what} of `random` must be a whole number{but}",
    "use a constant, a parameter or the variable of a `for`",
)
def random_of_what_varies(span: Span, what: str, found: str) -> Values:
    return {"but": f", not {found}" if found else " that is known before the run"}


# --- data files -------------------------------------------------------------------------


@error(
    "BG250: cannot read data from `{file}`: {why}",
    "give the path relative to this file, of a `.csv` or `.json` file in UTF-8",
)
def data_unreadable(span: Span, file: str, why: str) -> None: ...
@error(
    "BG251: `{file}` is not a table of numbers: {problem}",
    "correct the file: a line of names, then one finite number per column in each line",
)
def data_malformed(span: Span, file: str, problem: str) -> None: ...
@error(
    "BG252: `{unit}` is not a unit, in `{title}` of `{file}`", "write a unit such as `mm` or `kN*m`"
)
def data_unit(span: Span, file: str, title: str, unit: str, suggestion: str) -> Values:
    return {"help": f"write `{suggestion}`" if suggestion else ""}


@error("BG253: {owner} has no `{name}`, but {ways}", "use one of these names")
def data_missing_name(span: Span, name: str, owner: str, have: Sequence[str]) -> Values:
    return {"ways": listed(have) or "nothing", "help": did_you_mean(name, have)}


@error(
    "BG254: `{name}` has {size:,} numbers, too many for a vector of expressions (at most {most:,})",
    "use `interpolate`, single numbers or a slice such as `[1..100]`",
)
def data_too_long(span: Span, name: str, size: int, most: int) -> None: ...
@error("BG255: `data` takes the path of a file in quotes", 'write `data("road.csv")`')
def data_name_expected(span: Span) -> None: ...


# --- interpolation ----------------------------------------------------------------------


@error(
    "BG256: `{name}` has {found} {noun}; `interpolate` needs at least 2", "give at least two knots"
)
def too_few_knots(span: Span, name: str, found: int) -> Values:
    return {"noun": "value" if found == 1 else "values"}


# Report values that are not as many as the knots, as BG256.
@error(
    "BG256: `{name}` is {found}, but the knots need {needed}",
    "give one value for each knot: `Z[i, j]` is the value at `xs[i]` and `ys[j]`",
)
def data_lengths(span: Span, name: str, found: str, needed: str) -> None: ...
@error(
    "BG257: `{name}` does not rise: number {place} is {after:.15g}, after {before:.15g}",
    "sort the rows and remove repeated ones",
)
def knots_fall(span: Span, name: str, place: int, before: float, after: float) -> None: ...
@error(
    "BG258: `{name}` begins with {first:.15g} and ends with {last:.15g}, so it cannot repeat",
    "add a last row with the first value, at the end of the period",
)
def repeat_jumps(span: Span, name: str, first: float, last: float) -> None: ...
@error("BG259: {problem}")
def interpolate_option(span: Span, name: str, value: str, allowed: Sequence[str]) -> Values:
    if value:
        return {
            "problem": f"`{value}` is not a {name} of `interpolate` here",
            "help": f"use {listed(allowed)}",
        }
    return {
        "problem": f"`interpolate` takes no `{name}` here",
        "help": f"its options are {listed(allowed)}, once each",
    }
