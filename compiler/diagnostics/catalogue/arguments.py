"""Diagnostics: parameters and options of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isnan

from bgc.diagnostics.catalogue import Values, did_you_mean, error, listed, nearest, quoted
from bgc.diagnostics.diagnostic import Label
from bgc.diagnostics.source import Span


@error("BG060: the compiled model has no parameter `{name}`", "{there}")
def unknown_parameter(name: str, known: Iterable[str]) -> Values:
    names = list(known)
    there = f"its parameters are {listed(names)}" if names else "nothing in it can be set"
    return {"there": there, **nearest(name, names)}


@error(
    "BG078: `{name}` is {value:g} in this scene and was folded into the equations",
    "compile with its value (`parameters=`, `--set`), or write `keep {name};` in the scene",
)
def parameter_folded(name: str, value: float) -> None: ...
@error(
    "BG061: {what} is outside the range of parameter `{name}`, {low:g} .. {high:g}{shown}",
    "give a value inside the range, or widen it where the parameter is declared",
)
def parameter_out_of_range(
    name: str,
    unit: str,
    value: float,
    low: float,
    high: float,
    origins: Sequence[str] = (),
    span: Span | None = None,
    declared: Span | None = None,
) -> Values:
    # A value that follows from others: these are `origins`, the first of them declared at `span`.
    # The range is declared at `declared`.
    shown = f" {unit}" if unit else ""
    what = "an undefined value" if isnan(value) else f"{value:g}{shown}"
    values: dict[str, object] = {"shown": shown, "what": what}
    if isnan(value):
        values["help"] = f"give `{name}` a value, or change what its default follows from"
    if declared and span:
        values["labels"] = [Label(declared, "the range is declared here")]
    if origins:
        values["note"] = f"its value follows from {listed(origins)}"
        values["help"] = f"change {listed(origins)}, or widen the range where `{name}` is declared"
    return values


@error(
    "BG062: `{text}` is not a value for `{name}`",
    "write a number, or a number, one blank and a unit: `7`, `7 t`, `45 deg`",
)
def not_a_value(text: str, name: str, unit: str = "") -> Values:
    return {"help": f"a unit has no parentheses: write `{unit}`" if unit else ""}


@error(
    "BG790: `{name}` is {given:an}, not a number or a text",
    'give an SI number, or a text with a unit: `{name}="2{shown}"`',
)
def not_a_quantity(name: str, given: str, unit: str) -> Values:
    return {"shown": f" {unit}" if unit else ""}


@error(
    "BG791: a state of this model has {states} numbers; the one given has the shape {given}",
    "start from `model.initial_state()`; a time is given by name: `time=0.1`",
)
def wrong_state(shape: tuple[int, ...], states: int) -> Values:
    return {"given": " x ".join(map(str, shape)) if shape else "a scalar"}


@error("BG792: this run is over", "begin another one: `model.step()`")
def run_is_over() -> None: ...
@error(
    "BG793: `%%bgc {line}` does not name a variable for the model",
    "write `%%bgc NAME`, `%%bgc NAME SCENE` or `%%bgc NAME --file FILE.bg`",
)
def bad_magic(line: str) -> Values:
    return {"line": line.strip()}


@error("BG063: {problem}", "give a unit of the same kind, or a number alone for SI")
def wrong_unit(name: str, given: str, unit: str) -> Values:
    if unit:
        return {"problem": f"`{given}` is not a unit of `{name}`, which is in `{unit}`"}
    return {"problem": f"`{name}` has no unit: it is a plain number; `{given}` does not fit"}


@error("BG064: `{option}` is given {problem}", "write `{example}`")
def bad_assignment(text: str, example: str) -> Values:
    option = example.partition(" ")[0]
    if not text.strip():
        problem = "an empty text"
    elif "=" not in text:
        problem = f"`{text}` without `=` and a value"
    else:
        problem = f"`{text}` without a {'name' if text.strip().startswith('=') else 'value'}"
    return {"option": option, "problem": problem}


@error("BG065: the result has no column `{name}`")
def unknown_column(name: object, known: Iterable[str]) -> Values:
    known = list(known)
    more = ", ..." if len(known) > 12 else ""
    if isinstance(name, str):
        way_out = did_you_mean(name, known) or f"add `observe {name};` to the scene"
    else:
        example = known[0] if known else "NAME"
        way_out = f'write `["{example}"]`; of many runs, `["{example}"][k]` is that of run k'
    return {"note": f"observed: {quoted(known[:12])}{more}" if known else "", "help": way_out}


@error(
    "BG066: `{name}` is {value}, which is not {wanted}", "give {wanted}, for example `{example}`"
)
def bad_option(
    name: str, value: object, wanted: str, example: str = "1e-3", span: Span | None = None
) -> None: ...
@error(
    "BG067: {scene:scene} has no duration", "write `run 10 s;` in the scene, or give `--time 10`"
)
def no_duration(scene: str) -> None: ...
@error(
    "BG068: {rows:,} rows of {columns} columns would take {amount}",
    "write fewer rows: `run .. every ..;` in the scene, or `--every`",
)
def too_many_rows(rows: int, columns: int) -> Values:
    size = rows * columns * 8 / 2**20
    return {"amount": f"{size / 1024:.1f} GiB" if size > 100 else f"{size:.1f} MiB"}


@error(
    "BG069: `{text}` is not a panel of a plot",
    'write `--panel "tip.z, handle.z"` or `--panel "force against elevation"`',
)
def bad_panel(text: str) -> None: ...
@error("BG071: there is no solver `{name}`", "choose one of {known:quoted}")
def unknown_solver(name: str, known: Sequence[str], span: Span | None = None) -> Values:
    return nearest(name, known)


@error(
    "BG072: solver `{solver}` needs a step",
    "write `step 1 ms;` in the scene, or give `--step 0.001`",
)
def step_needed(solver: str) -> None: ...
@error("BG044: solver `{solver}` has no option `{option}`: {reason}")
def option_not_served(
    solver: str, option: str, fixed: bool, served: Sequence[str], in_scenes: Sequence[str]
) -> Values:
    if fixed and option in ("rtol", "atol", "max_step"):
        reason = "its steps have the fixed length `step`"
        divide = "let it be divided with `substeps = 8`, " if "substeps" in served else ""
        way_out = f"shorten `step`, {divide}or use a method with error control such as `rodas5p`"
        return {"reason": reason, "help": way_out}
    reason = "it does not apply to this method"
    more = f"; in a scene, `solver {solver}(..)` takes {quoted(in_scenes)} too" if in_scenes else ""
    return {"reason": reason, "help": f"omit it; `{solver}` takes {quoted(served)}{more}"}


@error("BG045: there is no part `{name}` to collapse", "{there}")
def unknown_part(name: str, known: Iterable[str]) -> Values:
    have = sorted(known)
    there = f"use one of {listed(have)}" if have else "the model has no parts of parts"
    return {"there": there, **nearest(name, have)}


@error(
    "BG073: device `{device}` uses the driver `{driver}`, which this build does not have",
    "use one of its drivers: {have:listed}; `trace(file = ..)` plays a recorded motion",
)
def unknown_driver(
    device: str, driver: str, have: Sequence[str], span: Span | None = None
) -> Values:
    return nearest(driver, have)


@error(
    "BG074: device `{device}` ({driver}) could not be opened: {reason}",
    "correct the device's options in the scene; file paths start at the folder of the `.bg` file",
)
def device_not_opened(device: str, driver: str, reason: str) -> None: ...
@error(
    "BG077: {shape} values do not fit `{name}`, which has {components} {noun}",
    "give as many values, row by row, or set one component by its own name",
)
def wrong_shape(name: str, given: Sequence[int], components: int) -> Values:
    return {
        "shape": " x ".join(map(str, given)),
        "noun": "component" if components == 1 else "components",
    }
