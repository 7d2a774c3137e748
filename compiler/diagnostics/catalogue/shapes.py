"""Diagnostics of shapes and indices of values."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def shapes_differ(context: str, left: tuple[Span, str], right: tuple[Span, str]) -> Diagnostic:
    """BG310: shapes that do not match"""
    return error(
        "BG310",
        f"{left[1]} and {right[1]} have different shapes in {context}",
        right[0],
        labels=(Label(left[0], left[1]),),
        help="give both the same shape",
    )


def no_product(left: tuple[Span, str], right: tuple[Span, str], help: str) -> Diagnostic:
    """BG311: shapes that have no product"""
    return error(
        "BG311",
        f"there is no product of {left[1]} and {right[1]}",
        right[0],
        labels=(Label(left[0], left[1]),),
        help=help,
    )


def needs_scalar(span: Span, what: str, found: str, help: str = "") -> Diagnostic:
    """BG312: a scalar is needed"""
    way_out = help or "use one component, for example `v[2]` or `v.x`"
    return error("BG312", f"{what} must be a scalar, not {found}", span, help=way_out)


def wrong_argument_shape(span: Span, function: str, expected: str, found: str) -> Diagnostic:
    """BG313: an argument of the wrong shape"""
    message = f"`{function}` takes {expected}, not {found}"
    return error("BG313", message, span, help=f"give it {expected}")


def ragged(span: Span, expected: str, found: str) -> Diagnostic:
    """BG314: rows of different lengths"""
    return error(
        "BG314",
        f"this element is {found}, the first is {expected}",
        span,
        help="use `stack(a, b)` to join vectors, `block([[A, B], [C, D]])` to join matrices",
    )


def wrong_shape(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG315: a value of the wrong shape"""
    message = f"{what} must be {expected}, not {found}"
    return error("BG315", message, span, help="give as many components as declared")


def blocks_differ(span: Span, what: str) -> Diagnostic:
    """BG316: blocks that do not match"""
    return error("BG316", what, span, help="write `block([[A, B], [C, D]])`, by rows")


def too_large(span: Span, what: str) -> Diagnostic:
    """BG317: a value that is too large"""
    return error("BG317", f"{what} is too large", span, help="use a smaller size")


def too_deep(span: Span) -> Diagnostic:
    """BG318: an expression nested too deeply"""
    return error(
        "BG318",
        "this expression is nested too deeply",
        span,
        help="name inner parts of it with `let`",
    )


def too_many_dimensions(span: Span, name: str, found: int) -> Diagnostic:
    """BG319: more than two dimensions"""
    return error(
        "BG319",
        f"`{name}` has {found} dimensions, but a value has at most two",
        span,
        help="combine two dimensions into one, for example `u[8*(i - 1) + j, k]`",
    )


def index_out_of_range(span: Span, index: int, size: int, shape: str) -> Diagnostic:
    """BG320: an index out of range"""
    return error(
        "BG320",
        f"there is no component {index} in {shape}",
        span,
        help=f"use an index from 1 to {size}",
    )


def wrong_index_count(span: Span, shape: str, expected: int, found: int) -> Diagnostic:
    """BG321: too many or too few indices"""
    needs = ("no index", "one index", "two indices")[expected]
    return error(
        "BG321",
        f"{shape} takes {needs}, not {found}",
        span,
        help="write `A[2, 1..3]` for a row" if expected == 2 else "remove the extra indices",
    )


def empty_range(span: Span, first: int, last: int) -> Diagnostic:
    """BG322: an empty range of indices"""
    return error(
        "BG322",
        f"the range {first}..{last} is empty",
        span,
        help=f"write `{last}..{first}`" if first - last > 1 else "write the smaller index first",
    )


def no_component(span: Span, name: str, shape: str) -> Diagnostic:
    """BG323: no component of that name"""
    return error(
        "BG323",
        f"{shape} has no component `{name}`",
        span,
        help="use `.x`, `.y`, `.z` of a vector, or an index `[1]`, `[2]`, ..",
    )


def no_range_of_parts(span: Span, what: str) -> Diagnostic:
    """BG324: a range of parts in an expression"""
    return error(
        "BG324",
        f"a range cannot select from {what} in an expression",
        span,
        help="name one part, for example `mass[2].p`",
    )
