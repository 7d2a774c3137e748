"""BG260-BG264, BG560-BG564: values of inputs from a program, `simulate(inputs={..})`."""

from __future__ import annotations

from collections.abc import Iterable

from bgc.diagnostics.catalogue import did_you_mean, error, with_article
from bgc.diagnostics.diagnostic import Diagnostic

_FORMS = "a value, a pair `(times, values)`, or a function of the time in s"


def input_form(name: str, found: str) -> Diagnostic:
    """BG260: an input in an unsupported form"""
    return error("BG260", f"the input `{name}` is {with_article(found)}", help=f"give {_FORMS}")


def input_times(name: str, problem: str) -> Diagnostic:
    """BG261: times of an input that do not rise"""
    return error(
        "BG261",
        f"the times of the input `{name}` {problem}",
        help="give 2 to 10,000 times that rise; longer recordings are driven in the scene, by "
        "`interpolate` and `data`",
    )


def input_too_short(name: str, first: float, last: float, end: float) -> Diagnostic:
    """BG262: times of an input that do not cover the run"""
    return error(
        "BG262",
        f"the times of the input `{name}` are from {first:g} s to {last:g} s, the run is from 0 to "
        f"{end:g} s",
        help="end the run earlier, or add values at the time 0 and at the end of the run",
    )


def input_not_finite(name: str, value: float, time: float | None) -> Diagnostic:
    """BG263: a value of an input that is not finite"""
    when = "" if time is None else f" at {time:g} s"
    return error(
        "BG263",
        f"the input `{name}` is {value:g}{when}",
        help="omit the times without a value",
    )


def input_lengths(name: str, found: str) -> Diagnostic:
    """BG264: an input whose numbers of values and times differ"""
    return error(
        "BG264",
        f"the input `{name}` has {found}",
        help="give one value of the same shape for each time; the first axis of the values is the "
        "time",
    )


def uneven_inputs(problem: str) -> Diagnostic:
    """BG560: inputs that do not fit the runs"""
    return error(
        "BG560",
        f"the inputs do not fit the runs: {problem}",
        help="give one set of inputs for all runs, or one for each, with the same names and shapes",
    )


def mixed_inputs(name: str) -> Diagnostic:
    """BG561: functions and pairs for one input"""
    return error(
        "BG561",
        f"the input `{name}` is a function in one run and a pair in another",
        help="give pairs in all runs, or functions in all runs",
    )


def too_many_inputs(name: str, times: int, runs: int) -> Diagnostic:
    """BG562: too many values of an input of each run"""
    return error(
        "BG562",
        f"the input `{name}` has {times:,} times in {runs:,} runs: {times * runs:,} values",
        help="10,000 are allowed: give fewer times, the same in all runs, or run it in parts",
    )


def function_in_steps(name: str) -> Diagnostic:
    """BG563: a function as the input of a run in steps"""
    return error(
        "BG563",
        f"the input `{name}` of a run in steps is a function",
        help="give its value with each `advance(.., inputs={..})`, or a pair `(times, values)`",
    )


def not_an_open_input(name: str, known: Iterable[str]) -> Diagnostic:
    """BG564: an input that the run in steps has not opened"""
    found = list(known)
    return error(
        "BG564",
        f"`{name}` is not an input with a value in this run",
        help=did_you_mean(name, found) or f"begin with `model.step(inputs={{{name!r}: 0}})`",
    )
