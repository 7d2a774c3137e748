"""BG23x, BG24x: ranges of parameters."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def range_excludes(
    span: Span, name: str, value: float, low: float, high: float, unit: str
) -> Diagnostic:
    """BG239: a parameter outside its own range"""
    ends = f"{low:g} .. {high:g} {unit}".rstrip()
    number = f"{value:g} {unit}".rstrip()
    return error("BG239", f"`{name}` is {number}, outside {ends}", span,
                 help="give a value within the range of its declaration")  # fmt: skip


def range_of_variable(span: Span, name: str, kind: str) -> Diagnostic:
    """BG242: a range of a value that may vary"""
    return error(
        "BG242",
        f"a range needs a `param` or a `const`, and `{name}` is declared as `{kind}`",
        span,
        help=f'write `assert low <= {name} and {name} <= high, "..";` in its place',
    )


def empty_range(span: Span, name: str, low: float, high: float) -> Diagnostic:
    """BG240: an empty range"""
    return error("BG240", f"the range of `{name}` is empty: {low:g} is above {high:g}", span,
                 help="write the lower end first")  # fmt: skip
