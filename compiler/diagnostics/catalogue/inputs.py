"""Diagnostics: inputs from a program."""

from __future__ import annotations

from collections.abc import Iterable

from bgc.diagnostics.catalogue import Values, error, nearest

_FORMS = "a value, a pair `(times, values)`, or a function of the time in s"


@error("BG260: the input `{name}` is {found:an}", "give " + _FORMS)
def input_form(name: str, found: str) -> None: ...
@error(
    "BG261: the times of the input `{name}` {problem}",
    "give 2 to 10,000 times that rise; longer recordings are driven in the scene, by "
    "`interpolate` and `data`",
)
def input_times(name: str, problem: str) -> None: ...
@error(
    "BG262: the times of the input `{name}` are from {first:g} s to {last:g} s, the run is from "
    "0 to {end:g} s",
    "end the run earlier, or add values at the time 0 and at the end of the run",
)
def input_too_short(name: str, first: float, last: float, end: float) -> None: ...
@error("BG263: the input `{name}` is {value:g}{when}", "omit the times without a value")
def input_not_finite(name: str, value: float, time: float | None) -> Values:
    return {"when": "" if time is None else f" at {time:g} s"}


@error(
    "BG264: the input `{name}` has {found}",
    "give one value of the same shape for each time; the first axis of the values is the time",
)
def input_lengths(name: str, found: str) -> None: ...
@error(
    "BG560: the inputs do not fit the runs: {problem}",
    "give one set of inputs for all runs, or one for each, with the same names and shapes",
)
def uneven_inputs(problem: str) -> None: ...
@error(
    "BG561: the input `{name}` is a function in one run and a pair in another",
    "give pairs in all runs, or functions in all runs",
)
def mixed_inputs(name: str) -> None: ...
@error(
    "BG562: the input `{name}` has {times:,} times in {runs:,} runs: {values:,} values",
    "10,000 are allowed: give fewer times, the same in all runs, or run it in parts",
)
def too_many_inputs(name: str, times: int, runs: int) -> Values:
    return {"values": times * runs}


@error(
    "BG563: the input `{name}` of a run in steps is a function",
    "give its value with each `advance(.., inputs={..})`, or a pair `(times, values)`",
)
def function_in_steps(name: str) -> None: ...
@error(
    "BG564: `{name}` is not an input with a value in this run",
    "begin with `model.step(inputs={{key}: 0})`",
)
def not_an_open_input(name: str, known: Iterable[str]) -> Values:
    return {"key": repr(name), **nearest(name, known)}
