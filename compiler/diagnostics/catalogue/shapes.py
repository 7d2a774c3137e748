"""Diagnostics: shapes and indices of values."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, error
from bgc.diagnostics.diagnostic import Label
from bgc.diagnostics.source import Span


def _both(left: tuple[Span, str], right: tuple[Span, str]) -> Values:
    """Return the two sides of an operation: the error is at the right one."""
    labels = [Label(left[0], left[1])]
    return {"one": left[1], "other": right[1], "span": right[0], "labels": labels}


@error("BG310: {one} and {other} have different shapes in {context}", "give both the same shape")
def shapes_differ(context: str, left: tuple[Span, str], right: tuple[Span, str]) -> Values:
    return _both(left, right)


@error("BG311: there is no product of {one} and {other}")
def no_product(left: tuple[Span, str], right: tuple[Span, str], help: str) -> Values:
    return _both(left, right)


@error(
    "BG312: {what} must be a scalar, not {found}", "use one component, for example `v[2]` or `v.x`"
)
def needs_scalar(span: Span, what: str, found: str, help: str = "") -> None: ...
@error("BG313: `{function}` takes {expected}, not {found}", "give it {expected}")
def wrong_argument_shape(span: Span, function: str, expected: str, found: str) -> None: ...
@error(
    "BG314: this element is {found}, the first is {expected}",
    "use `stack(a, b)` to join vectors, `block([[A, B], [C, D]])` to join matrices",
)
def ragged(span: Span, expected: str, found: str) -> None: ...
@error("BG315: {what} must be {expected}, not {found}", "give as many components as declared")
def wrong_shape(span: Span, what: str, expected: str, found: str) -> None: ...
@error("BG316: {what}", "write `block([[A, B], [C, D]])`, by rows")
def blocks_differ(span: Span, what: str) -> None: ...
@error("BG317: {what} is too large", "use a smaller size")
def too_large(span: Span, what: str) -> None: ...
@error("BG318: this expression is nested too deeply", "name inner parts of it with `let`")
def too_deep(span: Span) -> None: ...
@error(
    "BG319: `{name}` has {found} dimensions, but a value has at most two",
    "combine two dimensions into one, for example `u[8*(i - 1) + j, k]`",
)
def too_many_dimensions(span: Span, name: str, found: int) -> None: ...
@error("BG320: there is no component {index} in {shape}", "use an index from 1 to {size}")
def index_out_of_range(span: Span, index: int, size: int, shape: str) -> None: ...
@error("BG321: {shape} takes {needs}, not {found}", "remove the extra indices")
def wrong_index_count(span: Span, shape: str, expected: int, found: int) -> Values:
    return {
        "needs": ("no index", "one index", "two indices")[expected],
        "help": "write `A[2, 1..3]` for a row" if expected == 2 else "",
    }


@error("BG322: the range {first}..{last} is empty", "write the smaller index first")
def empty_range(span: Span, first: int, last: int) -> Values:
    return {"help": f"write `{last}..{first}`" if first - last > 1 else ""}


@error(
    "BG323: {shape} has no component `{name}`",
    "use `.x`, `.y`, `.z` of a vector, or an index `[1]`, `[2]`, ..",
)
def no_component(span: Span, name: str, shape: str) -> None: ...
@error(
    "BG324: a range cannot select from {what} in an expression",
    "name one part, for example `mass[2].p`",
)
def no_range_of_parts(span: Span, what: str) -> None: ...
