"""Diagnostics: ranges of parameters."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, error
from bgc.diagnostics.source import Span


@error(
    "BG239: `{name}` is {number}, outside {ends}",
    "give a value within the range of its declaration",
)
def range_excludes(
    span: Span, name: str, value: float, low: float, high: float, unit: str
) -> Values:
    return {"number": f"{value:g} {unit}".rstrip(), "ends": f"{low:g} .. {high:g} {unit}".rstrip()}


@error(
    "BG242: a range needs a `param` or a `const`, and `{name}` is declared as `{kind}`",
    'write `assert low <= {name} and {name} <= high, "..";` in its place',
)
def range_of_variable(span: Span, name: str, kind: str) -> None: ...
@error(
    "BG240: the range of `{name}` is empty: {low:g} is above {high:g}", "write the lower end first"
)
def empty_range(span: Span, name: str, low: float, high: float) -> None: ...
