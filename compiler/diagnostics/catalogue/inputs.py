"""BG260-BG264: values of inputs from a program, `simulate(inputs={..})`."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error, with_article
from bgc.diagnostics.diagnostic import Diagnostic

_FORMS = "a value, a pair `(times, values)`, or a function of the time in s"


def input_form(name: str, found: str) -> Diagnostic:
    """BG260: an input that is given in another form

    What: a value of `simulate(inputs={..})` is not a number, text or array, nor a pair of times
    and values, nor a function.

    Why: a dictionary or a set has no order in time, and numbers that are complex have no unit.

    Example: `model.simulate(inputs={"road": {0: 0, 1: 0.1}})`

    Way out: `inputs={"road": ([0, 1], [0, 0.1])}`, `inputs={"road": 0.1}`, or
    `inputs={"road": lambda t: 0.1*t}`.
    """
    return error("BG260", f"the input `{name}` is {with_article(found)}", help=f"give {_FORMS}")


def input_times(name: str, problem: str) -> Diagnostic:
    """BG261: times of an input that do not rise

    What: the times of `inputs={"NAME": (times, values)}` are not a list of 2 to 10,000 numbers
    that rise.

    Why: an input has one value at each time; the model is compiled with the table, which would
    take long for more values.

    Example: `inputs={"road": ([0, 1, 1], [0, 0, 0.1])}`

    Way out: put a step between two times that are close to each other. Drive the input by
    `interpolate` with columns of `data("FILE.csv")` in the scene where there are more values; for
    a function, ask for fewer rows (`every`), or give its values at times of your choice.
    """
    return error(
        "BG261",
        f"the times of the input `{name}` {problem}",
        help="give 2 to 10,000 times that rise; longer recordings are driven in the scene, by "
        "`interpolate` and `data`",
    )


def input_too_short(name: str, first: float, last: float, end: float) -> Diagnostic:
    """BG262: times of an input that do not cover the run

    What: the times of `inputs={"NAME": (times, values)}` begin after 0 or end before the run.

    Why: nothing is known of the input there. To hold the last value is an assumption, which the
    program has to state.

    Example: `model.simulate("10 s", inputs={"road": ([0, 5], [0, 0.1])})`

    Way out: end the run with the times, or repeat the last value at a time behind its end.
    """
    return error(
        "BG262",
        f"the times of the input `{name}` are from {first:g} s to {last:g} s, the run is from 0 to "
        f"{end:g} s",
        help="end the run earlier, or add values at the time 0 and at the end of the run",
    )


def input_not_finite(name: str, value: float, time: float | None) -> Diagnostic:
    """BG263: a value of an input that is not finite

    What: a value of an input is NaN or infinite.

    Why: the equations would have no solution from that time on.

    Example: a recording with gaps: `inputs={"road": ([0, 1, 2], [0, nan, 0.1])}`

    Way out: omit the times without a value; the input is interpolated between the others.
    """
    when = "" if time is None else f" at {time:g} s"
    return error(
        "BG263",
        f"the input `{name}` is {value:g}{when}",
        help="omit the times without a value",
    )


def input_lengths(name: str, found: str) -> Diagnostic:
    """BG264: an input with another number of values than of times

    What: the values of `inputs={"NAME": (times, values)}` are not one for each time, or have
    different shapes.

    Why: the first axis of the values is the time, also those of a vector: n times go with values
    of the shape n x 3.

    Example: `inputs={"road": ([0, 1, 2], [0, 0.1])}`

    Way out: give one value for each time; transpose an array whose last axis is the time.
    """
    return error(
        "BG264",
        f"the input `{name}` has {found}",
        help="give one value of the same shape for each time; the first axis of the values is the "
        "time",
    )
