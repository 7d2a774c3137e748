"""BG74x: many runs of one model at once."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def uneven_values(name: str, count: int, other: str, expected: int) -> Diagnostic:
    """BG740: the parameters of an ensemble have different numbers of values

    What: each varied parameter needs one value for each instance.

    Why: instance k takes the k-th value of every parameter.

    Example: `simulate_many({"m": [1, 2, 3], "k": [10, 20]})`.

    Way out: lists of equal length; one number or text where all instances share it.
    """
    return error(
        "BG740",
        f"`{name}` has {_values(count)} and `{other}` {_values(expected)}",
        help="give one value for each instance, or a single number that all share",
    )


def no_instances() -> Diagnostic:
    """BG741: an ensemble without instances

    What: there is nothing to simulate.

    Why: the list of parameter sets, or of a parameter's values, is empty.

    Example: `simulate_many([])`.

    Way out: at least one set; `simulate_many([{}])` runs the model as it is.
    """
    return error(
        "BG741",
        "there are no parameter sets to simulate",
        help="give at least one: `simulate_many([{}])` runs the model as it is",
    )


def source_changed(path: str) -> Diagnostic:
    """BG742: the file has changed since the model was compiled

    What: what runs many instances at once is compiled when it is first needed, and the file is no
    longer what the model was made of.

    Why: it was edited in between; one model would mix two texts.

    Example: `simulate_many` in a notebook after an edit of the file.

    Way out: compile the model again: `model = bgc.compile(path)`.
    """
    return error(
        "BG742",
        f"`{path}` has changed since this model was compiled",
        help="compile it again, and simulate that",
    )


def bad_range(text: str) -> Diagnostic:
    """BG743: `--vary` without a range

    What: the text is not of the form `name=low..high`, with a unit and a count if need be.

    Why: a sweep takes each varied parameter from one value to another.

    Example: `--vary boom.mass=7`.

    Way out: `--vary "boom.mass=5..9 t:20"` for 20 values from 5 t to 9 t.
    """
    return error(
        "BG743",
        f"`{text}` is not of the form name=low..high unit:count",
        help='write `--vary "boom.mass=5..9 t:20"`; the unit and the count may be left out',
    )


def varied_twice(name: str) -> Diagnostic:
    """BG744: a parameter that is varied twice

    What: two `--vary` of one command name the same parameter.

    Why: an instance has one value of it.

    Example: `--vary "m=1..2 kg" --vary "m=5..6 kg"`.

    Way out: one range that holds both, or two sweeps.
    """
    return error(
        "BG744",
        f"`{name}` is varied twice",
        help="give one range for it, or sweep once for each",
    )


def too_many_instances(count: int, most: int) -> Diagnostic:
    """BG745: more instances than one sweep takes

    What: every combination of the values of all ranges is an instance, and these are too many.

    Why: the number of combinations is the product of the counts, 10 where a range says none; a
    million runs are all that one sweep holds.

    Example: seven ranges of 10 values each.

    Way out: `--sample 1000` spreads as many points over all ranges.
    """
    return error(
        "BG745",
        f"{count:,} instances are more than the {most:,} that one sweep takes",
        help="spread points over the ranges by `--sample 1000`, or give smaller counts",
    )


def _values(count: int) -> str:
    return "1 value" if count == 1 else f"{count} values"
