"""Diagnostics of the inputs of a run: parameters, options, columns, solvers, devices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def unknown_parameter(name: str, known: Iterable[str]) -> Diagnostic:
    """BG060: a parameter that the compiled model does not have"""
    names = list(known)
    return error(
        "BG060",
        f"the compiled model has no parameter `{name}`",
        help=did_you_mean(name, names)
        or (f"its parameters are {listed(names)}" if names else "nothing in it can be set"),
    )


def parameter_folded(name: str, value: float) -> Diagnostic:
    """BG078: a parameter that was compiled into the model"""
    return error(
        "BG078",
        f"`{name}` is {value:g} in this scene and was folded into the equations",
        help=f"compile with its value (`parameters=`, `--set`), or write `keep {name};` in the "
        "scene",
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
) -> Diagnostic:
    """BG061: a parameter outside the range that the model declares"""
    # A value that follows from others: these are `origins`, the first of them declared at `span`.
    # The range is declared at `declared`.
    shown = f" {unit}" if unit else ""
    others = listed(origins)
    labels = (Label(declared, "the range is declared here"),) if declared and span else ()
    return error(
        "BG061",
        f"{value:g}{shown} is outside the range of parameter `{name}`, {low:g} .. {high:g}{shown}",
        span,
        f"its value follows from {others}" if origins else "",
        labels,
        f"change {others}, or widen the range where `{name}` is declared"
        if origins
        else "give a value inside the range, or widen it where the parameter is declared",
    )


def not_a_value(text: str, name: str, unit: str = "") -> Diagnostic:
    """BG062: a parameter value that cannot be read"""
    return error(
        "BG062",
        f"`{text}` is not a value for `{name}`",
        help=f"a unit has no parentheses: write `{unit}`"
        if unit
        else "write a number, or a number, one blank and a unit: `7`, `7 t`, `45 deg`",
    )


def not_a_quantity(name: str, given: str, unit: str) -> Diagnostic:
    """BG790: an argument that is neither a number nor a text"""
    shown = f" {unit}" if unit else ""
    return error(
        "BG790",
        f"`{name}` is {with_article(given)}, not a number or a text",
        help=f'give an SI number, or a text with a unit: `{name}="2{shown}"`',
    )


def wrong_state(shape: tuple[int, ...], states: int) -> Diagnostic:
    """BG791: a state of the wrong size"""
    given = " x ".join(map(str, shape)) if shape else "a scalar"
    return error(
        "BG791",
        f"a state of this model has {states} numbers; the one given has the shape {given}",
        help="start from `model.initial_state()`; a time is given by name: `time=0.1`",
    )


def run_is_over() -> Diagnostic:
    """BG792: a run that is over"""
    return error("BG792", "this run is over", help="begin another one: `model.step()`")


def bad_magic(line: str) -> Diagnostic:
    """BG793: a cell magic with wrong arguments"""
    return error(
        "BG793",
        f"`%%bgc {line.strip()}` does not name a variable for the model",
        help="write `%%bgc NAME`, `%%bgc NAME SCENE` or `%%bgc NAME --file FILE.bg`",
    )


def wrong_unit(name: str, given: str, unit: str) -> Diagnostic:
    """BG063: a parameter value in the wrong unit"""
    wanted = f"`{unit}`" if unit else "no unit: it is a plain number"
    return error(
        "BG063",
        f"`{given}` is not a unit of `{name}`, which is in {wanted}"
        if unit
        else f"`{name}` has {wanted}; `{given}` does not fit",
        help="give a unit of the same kind, or a number alone for SI",
    )


def bad_assignment(text: str, example: str) -> Diagnostic:
    """BG064: an option without a name and a value"""
    option = example.partition(" ")[0]
    if not text.strip():
        problem = "an empty text"
    elif "=" not in text:
        problem = f"`{text}` without `=` and a value"
    else:
        problem = f"`{text}` without a {'name' if text.strip().startswith('=') else 'value'}"
    return error("BG064", f"`{option}` is given {problem}", help=f"write `{example}`")


def unknown_column(name: object, known: Iterable[str]) -> Diagnostic:
    """BG065: a column that the result does not have"""
    known = list(known)
    columns = ", ".join(f"`{column}`" for column in known[:12])
    if isinstance(name, str):
        way_out = did_you_mean(name, known) or f"add `observe {name};` to the scene"
    else:
        example = known[0] if known else "NAME"
        way_out = f'write `["{example}"]`; of many runs, `["{example}"][k]` is that of run k'
    return error(
        "BG065",
        f"the result has no column `{name}`",
        note=f"observed: {columns}{', ...' if len(known) > 12 else ''}" if known else "",
        help=way_out,
    )


def bad_option(
    name: str, value: object, wanted: str, example: str = "1e-3", span: Span | None = None
) -> Diagnostic:
    """BG066: an option of a run with an unusable value"""
    return error(
        "BG066",
        f"`{name}` is {value}, which is not {wanted}",
        span,
        help=f"give {wanted}, for example `{example}`",
    )


def no_duration(scene: str) -> Diagnostic:
    """BG067: a run without an end"""
    whose = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG067",
        f"{whose} has no duration",
        help="write `run 10 s;` in the scene, or give `--time 10`",
    )


def too_many_rows(rows: int, columns: int) -> Diagnostic:
    """BG068: more rows than fit in memory"""
    size = rows * columns * 8 / 2**20
    amount = f"{size / 1024:.1f} GiB" if size > 100 else f"{size:.1f} MiB"
    return error(
        "BG068",
        f"{rows:,} rows of {columns} columns would take {amount}",
        help="write fewer rows: `run .. every ..;` in the scene, or `--every`",
    )


def bad_panel(text: str) -> Diagnostic:
    """BG069: a panel of a plot that cannot be read"""
    return error(
        "BG069",
        f"`{text}` is not a panel of a plot",
        help='write `--panel "tip.z, handle.z"` or `--panel "force against elevation"`',
    )


def unknown_solver(name: str, known: Sequence[str], span: Span | None = None) -> Diagnostic:
    """BG071: an integration method that does not exist"""
    listed = ", ".join(f"`{method}`" for method in known)
    return error(
        "BG071",
        f"there is no solver `{name}`",
        span,
        help=did_you_mean(name, known) or f"choose one of {listed}",
    )


def step_needed(solver: str) -> Diagnostic:
    """BG072: a fixed-step method without a step"""
    return error(
        "BG072",
        f"solver `{solver}` needs a step",
        help="write `step 1 ms;` in the scene, or give `--step 0.001`",
    )


def option_not_served(solver: str, option: str, fixed: bool, served: Sequence[str]) -> Diagnostic:
    """BG044: an option that the integration method does not have"""
    if fixed and option in ("rtol", "atol", "max_step"):
        reason = "its steps have the fixed length `step`"
        divide = "let it be divided with `substeps = 8`, " if "substeps" in served else ""
        way_out = f"shorten `step`, {divide}or use a method with error control such as `rodas5p`"
    else:
        reason = "it does not apply to this method"
        way_out = f"omit it; `{solver}` takes {', '.join(f'`{name}`' for name in served)}"
    return error("BG044", f"solver `{solver}` has no option `{option}`: {reason}", help=way_out)


def unknown_part(name: str, known: Iterable[str]) -> Diagnostic:
    """BG045: a part that the drawn model does not have"""
    have = sorted(known)
    way_out = did_you_mean(name, have) or (
        f"use one of {listed(have)}" if have else "the model has no parts of parts"
    )
    return error("BG045", f"there is no part `{name}` to collapse", help=way_out)


def unknown_driver(
    device: str, driver: str, have: Sequence[str], span: Span | None = None
) -> Diagnostic:
    """BG073: a device driver that this build does not have"""
    return error(
        "BG073",
        f"device `{device}` uses the driver `{driver}`, which this build does not have",
        span,
        help=did_you_mean(driver, have)
        or f"use one of its drivers: {listed(have)}; `trace(file = ..)` plays a recorded motion",
    )


def device_not_opened(device: str, driver: str, reason: str) -> Diagnostic:
    """BG074: a device that could not be opened"""
    return error(
        "BG074",
        f"device `{device}` ({driver}) could not be opened: {reason}",
        help="correct the device's options in the scene; file paths start at the folder of the "
        "`.bg` file",
    )


def wrong_shape(name: str, given: Sequence[int], components: int) -> Diagnostic:
    """BG077: a vector or matrix of the wrong shape"""
    shape = " x ".join(str(size) for size in given)
    return error(
        "BG077",
        f"{shape} values do not fit `{name}`, which has {components} "
        f"component{'' if components == 1 else 's'}",
        help="give as many values, row by row, or set one component by its own name",
    )
