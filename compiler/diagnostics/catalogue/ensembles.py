"""BG74x: many runs of one model at once."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def uneven_values(name: str, count: int, other: str, expected: int) -> Diagnostic:
    """BG740: an ensemble with unequal numbers of values

    What: the varied parameters have different numbers of values.

    Why: instance k takes the k-th value of every parameter.

    Example: `simulate_many({"m": [1, 2, 3], "k": [10, 20]})`.

    Way out: give lists of equal length, and one number or text where all instances share it.
    """
    return error(
        "BG740",
        f"`{name}` has {_values(count)} and `{other}` {_values(expected)}",
        help="give one value for each instance, or a single number for all",
    )


def no_instances() -> Diagnostic:
    """BG741: an ensemble without instances

    What: there are no instances to simulate.

    Why: the list of parameter sets, or of a parameter's values, is empty.

    Example: `simulate_many([])`.

    Way out: give at least one set; `simulate_many([{}])` runs the model unchanged.
    """
    return error(
        "BG741",
        "there are no parameter sets to simulate",
        help="give at least one: `simulate_many([{}])` runs the model unchanged",
    )


def source_changed(path: str) -> Diagnostic:
    """BG742: the file has changed since the model was compiled

    What: the file was edited after the model was compiled. The code for many instances is compiled
    from the file when it is first needed.

    Why: the ensemble and the model would come from two different texts.

    Example: `simulate_many` in a notebook after the file was edited.

    Way out: compile the model again: `model = bgc.compile(path)`.
    """
    return error(
        "BG742",
        f"`{path}` has changed since this model was compiled",
        help="compile it again: `model = bgc.compile(path)`",
    )


def bad_range(text: str, reason: str = "") -> Diagnostic:
    """BG743: text that gives no values of a parameter

    What: the text is neither a range `name=low..high`, optionally with a unit, a count and `log`,
    nor a list `name=1, 2, 5 kg`.

    Why: a sweep varies each parameter from one value to another, or over given values. The ends
    of a logarithmic range are positive.

    Example: `--vary boom.mass`, `--height "sea.height=1:5"`.

    Way out: write `--vary "boom.mass=5..9 t:20"` for 20 values from 5 t to 9 t, or
    `--vary "boom.mass=5, 7, 9 t"`; `--height`, `--period` and others alike.
    """
    return error(
        "BG743",
        f"`{text}` is not a range: {reason}"
        if reason
        else f"`{text}` is not of the form name=low..high unit:count",
        help='write `"boom.mass=5..9 t:20"`, or values, `"boom.mass=5, 7, 9 t"`',
    )


def varied_twice(name: str) -> Diagnostic:
    """BG744: a parameter that is varied twice

    What: two `--vary` options of one command name the same parameter.

    Why: an instance has one value of each parameter.

    Example: `--vary "m=1..2 kg" --vary "m=5..6 kg"`.

    Way out: give one range that covers both, or run two sweeps.
    """
    return error(
        "BG744",
        f"`{name}` is varied twice",
        help="give one range for it, or run two sweeps",
    )


def too_many_instances(count: int, most: int) -> Diagnostic:
    """BG745: too many instances in one sweep

    What: each combination of values is one instance, and there are more than a million.

    Why: the number of instances is the product of the counts of all ranges; a range without a count
    has 10 values.

    Example: seven ranges of 10 values each.

    Way out: give `--sample 1000` to spread that many points over all ranges, or give smaller
    counts.
    """
    return error(
        "BG745",
        f"{count:,} instances exceed the limit of {most:,} in one sweep",
        help="use `--sample 1000` to spread points over the ranges, or give smaller counts",
    )


def _values(count: int) -> str:
    return "1 value" if count == 1 else f"{count} values"
