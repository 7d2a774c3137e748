"""BG74x: many runs of one model at once."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def uneven_values(name: str, count: int, other: str, expected: int) -> Diagnostic:
    """BG740: an ensemble with unequal numbers of values"""
    return error(
        "BG740",
        f"`{name}` has {_values(count)} and `{other}` {_values(expected)}",
        help="give one value for each instance, or a single number for all",
    )


def no_instances() -> Diagnostic:
    """BG741: an ensemble without instances"""
    return error(
        "BG741",
        "there are no parameter sets to simulate",
        help="give at least one: `simulate_many([{}])` runs the model unchanged",
    )


def source_changed(path: str) -> Diagnostic:
    """BG742: the file has changed since the model was compiled"""
    return error(
        "BG742",
        f"`{path}` has changed since this model was compiled",
        help="compile it again: `model = bgc.compile(path)`",
    )


def bad_range(text: str, reason: str = "") -> Diagnostic:
    """BG743: text that gives no values of a parameter"""
    return error(
        "BG743",
        f"`{text}` is not a range: {reason}"
        if reason
        else f"`{text}` is not of the form name=low..high unit:count",
        help='write `"boom.mass=5..9 t:20"`, or values, `"boom.mass=5, 7, 9 t"`',
    )


def varied_twice(name: str) -> Diagnostic:
    """BG744: a parameter that is varied twice"""
    return error(
        "BG744",
        f"`{name}` is varied twice",
        help="give one range for it, or run two sweeps",
    )


def too_many_instances(count: int, most: int) -> Diagnostic:
    """BG745: too many instances in one sweep"""
    return error(
        "BG745",
        f"{count:,} instances exceed the limit of {most:,} in one sweep",
        help="use `--sample 1000` to spread points over the ranges, or give smaller counts",
    )


def _values(count: int) -> str:
    return "1 value" if count == 1 else f"{count} values"
