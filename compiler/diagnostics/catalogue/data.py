"""Diagnostics of `jacobian`, of random numbers, and of data and interpolation."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

# --- jacobian ---------------------------------------------------------------------------


def jacobian_by_expression(span: Span) -> Diagnostic:
    """BG475: a derivative by an expression"""
    return error(
        "BG475",
        "`jacobian` differentiates by states, signals and inputs, not by an expression",
        span,
        help="give the expression a name with `signal`, use the name in both arguments",
    )


def jacobian_of_matrix(span: Span, found: str) -> Diagnostic:
    """BG476: the derivative of a matrix"""
    return error(
        "BG476",
        f"`jacobian` differentiates a scalar or a vector, not {found}",
        span,
        help="differentiate its rows or columns one by one",
    )


# --- random numbers ---------------------------------------------------------------------


def random_of_what_varies(span: Span, what: str, found: str) -> Diagnostic:
    """BG477: a random number of something other than whole constants"""
    return error(
        "BG477",
        f"{what} of `random` must be a whole number"
        + (f", not {found}" if found else " that is known before the run"),
        span,
        help="use a constant, a parameter or the variable of a `for`",
    )


# --- data files -------------------------------------------------------------------------


def data_unreadable(span: Span, file: str, why: str) -> Diagnostic:
    """BG250: a data file that cannot be read"""
    return error(
        "BG250",
        f"cannot read data from `{file}`: {why}",
        span,
        help="give the path relative to this file, of a `.csv` or `.json` file in UTF-8",
    )


def data_malformed(span: Span, file: str, problem: str) -> Diagnostic:
    """BG251: a data file whose contents are not numbers by name"""
    return error(
        "BG251",
        f"`{file}` is not a table of numbers: {problem}",
        span,
        help="correct the file: a line of names, then one finite number per column in each line",
    )


def data_unit(span: Span, file: str, title: str, unit: str, suggestion: str) -> Diagnostic:
    """BG252: an unknown unit in a data file"""
    return error(
        "BG252",
        f"`{unit}` is not a unit, in `{title}` of `{file}`",
        span,
        help=f"write `{suggestion}`" if suggestion else "write a unit such as `mm` or `kN*m`",
    )


def data_missing_name(span: Span, name: str, owner: str, have: Sequence[str]) -> Diagnostic:
    """BG253: a column or key that the data does not have"""
    near = did_you_mean(name, have)
    return error(
        "BG253",
        f"{owner} has no `{name}`, but {listed(have) or 'nothing'}",
        span,
        help=near or "use one of these names",
    )


def data_too_long(span: Span, name: str, size: int, most: int) -> Diagnostic:
    """BG254: a long column used as a vector"""
    return error(
        "BG254",
        f"`{name}` has {size:,} numbers, too many for a vector of expressions (at most {most:,})",
        span,
        help="use `interpolate`, single numbers or a slice such as `[1..100]`",
    )


def data_name_expected(span: Span) -> Diagnostic:
    """BG255: `data` without the name of a file"""
    return error(
        "BG255", "`data` takes the path of a file in quotes", span, help='write `data("road.csv")`'
    )


# --- interpolation ----------------------------------------------------------------------


def too_few_knots(span: Span, name: str, found: int) -> Diagnostic:
    """BG256: data that cannot be interpolated"""
    return error(
        "BG256",
        f"`{name}` has {found} value{'s' if found != 1 else ''}; `interpolate` needs at least 2",
        span,
        help="give at least two knots",
    )


def data_lengths(span: Span, name: str, found: str, needed: str) -> Diagnostic:
    """Report values that are not as many as the knots, as BG256."""
    return error(
        "BG256",
        f"`{name}` is {found}, but the knots need {needed}",
        span,
        help="give one value for each knot: `Z[i, j]` is the value at `xs[i]` and `ys[j]`",
    )


def knots_fall(span: Span, name: str, place: int, before: float, after: float) -> Diagnostic:
    """BG257: knots that do not rise"""
    return error(
        "BG257",
        f"`{name}` does not rise: number {place} is {after:.15g}, after {before:.15g}",
        span,
        help="sort the rows and remove repeated ones",
    )


def repeat_jumps(span: Span, name: str, first: float, last: float) -> Diagnostic:
    """BG258: a period that does not end where it begins"""
    return error(
        "BG258",
        f"`{name}` begins with {first:.15g} and ends with {last:.15g}, so it cannot repeat",
        span,
        help="add a last row with the first value, at the end of the period",
    )


def interpolate_option(span: Span, name: str, value: str, allowed: Sequence[str]) -> Diagnostic:
    """BG259: an unknown option of `interpolate`"""
    if not value:
        message = f"`interpolate` takes no `{name}` here"
        way = f"its options are {listed(allowed)}, once each"
    else:
        message = f"`{value}` is not a {name} of `interpolate` here"
        way = f"use {listed(allowed)}"
    return error("BG259", message, span, help=way)
