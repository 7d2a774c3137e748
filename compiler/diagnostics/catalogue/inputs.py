"""BG260-BG264, BG560-BG564: values of inputs from a program, `simulate(inputs={..})`."""

from __future__ import annotations

from collections.abc import Iterable

from bgc.diagnostics.catalogue import did_you_mean, error, with_article
from bgc.diagnostics.diagnostic import Diagnostic

_FORMS = "a value, a pair `(times, values)`, or a function of the time in s"


def input_form(name: str, found: str) -> Diagnostic:
    """BG260: an input in an unsupported form

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
    """BG264: an input whose numbers of values and times differ

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


def uneven_inputs(problem: str) -> Diagnostic:
    """BG560: inputs that do not fit the runs

    What: in `simulate_many(parameters, inputs=[..])` the number of sets of inputs differs from the
    number of runs, or the sets differ in their inputs or in the shapes of their values.

    Why: a list has one set of inputs for each run, in the order of the parameter sets. All runs
    are of one compiled model, in which the same inputs are driven.

    Example: `model.simulate_many({"mass": [1, 2, 3]}, inputs=[{"road": 0}, {"road": 0.1}])`

    Way out: give as many sets as there are runs, each with all inputs; or give one set for all
    runs: `inputs={"road": 0.1}`.
    """
    return error(
        "BG560",
        f"the inputs do not fit the runs: {problem}",
        help="give one set of inputs for all runs, or one for each, with the same names and shapes",
    )


def mixed_inputs(name: str) -> Diagnostic:
    """BG561: functions and pairs for one input

    What: in `simulate_many(parameters, inputs=[..])`, an input is a function of the time in one
    run, and a pair of times and values in another.

    Why: functions are joined by smooth curves between the rows, pairs by straight lines between
    their times. One table cannot do both.

    Example: `inputs=[{"road": lambda t: 0.1*t}, {"road": ([0, 1], [0, 0.1])}]`

    Way out: give pairs in all runs, `(times, [f(t) for t in times])`, or functions in all runs. A
    constant goes with either.
    """
    return error(
        "BG561",
        f"the input `{name}` is a function in one run and a pair in another",
        help="give pairs in all runs, or functions in all runs",
    )


def too_many_inputs(name: str, times: int, runs: int) -> Diagnostic:
    """BG562: too many values of an input of each run

    What: an input of the runs has too many values: the number of its different times in all runs,
    multiplied by the number of runs, is above 10,000.

    Why: the values of all runs are compiled into one table over the time and the run, and a larger
    table would take long to compile.

    Example: 100 runs, each with a function of the time and rows at 1,001 times.

    Way out: give the runs the same times, and fewer; ask for fewer rows (`every`) where inputs are
    functions; or run parts of the ensemble one after the other.
    """
    return error(
        "BG562",
        f"the input `{name}` has {times:,} times in {runs:,} runs: {times * runs:,} values",
        help="10,000 are allowed: give fewer times, the same in all runs, or run it in parts",
    )


def function_in_steps(name: str) -> Diagnostic:
    """BG563: a function as the input of a run in steps

    What: `model.step(inputs={..})` is given a function of the time.

    Why: a function is sampled at the rows of a run, and a run in steps has none.

    Example: `model.step(inputs={"road": lambda t: 0.1*t})`

    Way out: give the value of each piece, `run.advance("10 ms", inputs={"road": 0.1*run.time})`,
    which is held; or a pair `(times, values)`, which is joined by straight lines.
    """
    return error(
        "BG563",
        f"the input `{name}` of a run in steps is a function",
        help="give its value with each `advance(.., inputs={..})`, or a pair `(times, values)`",
    )


def not_an_open_input(name: str, known: Iterable[str]) -> Diagnostic:
    """BG564: an input that the run in steps has not opened

    What: `run.advance(.., inputs={..})` names an input to which `model.step(inputs={..})` gave no
    value.

    Why: the model is compiled with the inputs that can change between two pieces. An input that is
    given as a pair follows its straight lines.

    Example: `model.step(inputs={"road": 0})`, then `run.advance("1 s", inputs={"wind": 1})`

    Way out: `model.step(inputs={"road": 0, "wind": 0})`.
    """
    found = list(known)
    return error(
        "BG564",
        f"`{name}` is not an input with a value in this run",
        help=did_you_mean(name, found) or f"begin with `model.step(inputs={{{name!r}: 0}})`",
    )
