"""BG23x, BG24x: ranges of parameters."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def range_excludes(
    span: Span, name: str, value: float, low: float, high: float, unit: str
) -> Diagnostic:
    """BG239: a parameter outside its own range

    What: the value of a parameter is outside the range after `in`.
    Why: the author of the model declares for which values it holds.
    Example: `param mass = 1 t in 0 t .. 100 t;` with `set boom.mass = 200 t;`
    Way out: give a value within the range.
    """
    ends = f"{low:g} .. {high:g} {unit}".rstrip()
    number = f"{value:g} {unit}".rstrip()
    return error("BG239", f"`{name}` is {number}, outside {ends}", span,
                 help="give a value within the range of its declaration")  # fmt: skip


def range_of_variable(span: Span, name: str, kind: str) -> Diagnostic:
    """BG242: a range of a value that may vary

    What: a range `in low .. high` stands after a `let`, `signal`, `input`, `output`, `state` or
    `unknown`.
    Why: a range is checked when a run begins, so it needs a `param` or a `const`.
    Example: `state angle = 0 in -1 .. 1;`
    Way out: write an `assert`, which holds during the run:
    `assert abs(angle) <= 1, "the angle is out of range";`. Or declare the range at the parameter
    that gives the value.
    """
    return error(
        "BG242",
        f"a range needs a `param` or a `const`, and `{name}` is declared as `{kind}`",
        span,
        help=f'write `assert low <= {name} and {name} <= high, "..";` in its place',
    )


def empty_range(span: Span, name: str, low: float, high: float) -> Diagnostic:
    """BG240: an empty range

    What: the lower end of a parameter's range is above the upper end.
    Why: no value would be allowed.
    Example: `param mass = 1 t in 100 t .. 0 t;`
    Way out: write the lower end first.
    """
    return error("BG240", f"the range of `{name}` is empty: {low:g} is above {high:g}", span,
                 help="write the lower end first")  # fmt: skip
