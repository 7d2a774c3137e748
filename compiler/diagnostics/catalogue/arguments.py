"""Diagnostics of the inputs of a run: parameters, options, columns, solvers, devices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def unknown_parameter(name: str, known: Iterable[str]) -> Diagnostic:
    """BG060: a parameter that the compiled model does not have

    What: the name is not a run-time parameter of the compiled model.

    Why: it is misspelt, it is a `const` (fixed at compile time), or it was dropped because no
    observed quantity depends on it.

    Example: `model.parameters["crane.bom.mass"] = 7e3`.

    Way out: use one of the names suggested; `bgc show FILE --after slice` shows what was dropped.
    """
    names = list(known)
    return error(
        "BG060",
        f"the compiled model has no parameter `{name}`",
        help=did_you_mean(name, names)
        or (f"its parameters are {listed(names)}" if names else "nothing in it can be set"),
    )


def parameter_folded(name: str, value: float) -> Diagnostic:
    """BG078: a parameter that was compiled into the model

    What: the scene fixes the parameter at zero or one, so it was folded into the equations. The
    terms that it multiplies are simplified or gone.

    Why: a friction of zero needs no resistor. Zeros of parts, and zeros and ones that a scene sets,
    are folded; parameters of the scene's own model are not.

    Example: `model.parameters["crane.elbow.friction"] = 50` where the friction is zero.

    Way out: compile with the value (`bgc.compile(path, parameters={..})`, or `--set` on the command
    line), or write `keep crane.elbow.friction;` in the scene: it then stays a run-time parameter.
    """
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
    """BG061: a parameter outside the range that the model declares

    What: the value is outside the range `in low .. high` of the parameter's declaration.

    Why: the author of the model declared other values meaningless or untested.

    Example: `--set boom.mass=-1` for `param mass = 1 t in 0 t .. 100 t`.

    Way out: give a value inside the range, or widen the range in the model.
    """
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
    """BG062: a parameter value that cannot be read

    What: the text after `=` is neither a number nor a number, a blank and a unit.

    Why: run-time parameters are plain numbers.

    Example: `--set R=2ohm` (without the blank).

    Way out: write `--set "R=2 ohm"`, or omit the unit for SI: `--set R=2`.
    """
    return error(
        "BG062",
        f"`{text}` is not a value for `{name}`",
        help=f"a unit has no parentheses: write `{unit}`"
        if unit
        else "write a number, or a number, one blank and a unit: `7`, `7 t`, `45 deg`",
    )


def not_a_quantity(name: str, given: str, unit: str) -> Diagnostic:
    """BG790: an argument that is neither a number nor a text

    What: a function of the Python interface was given a value of another type where it takes a
    quantity.

    Why: a quantity is an SI number, or a text with a number and a unit.

    Example: `model.simulate(duration=[1, 2])`

    Way out: write `model.simulate(duration=2)` or `model.simulate(duration="2 s")`.
    """
    shown = f" {unit}" if unit else ""
    return error(
        "BG790",
        f"`{name}` is {with_article(given)}, not a number or a text",
        help=f'give an SI number, or a text with a unit: `{name}="2{shown}"`',
    )


def wrong_state(shape: tuple[int, ...], states: int) -> Diagnostic:
    """BG791: a state of the wrong size

    What: a function of the Python interface was given a state whose size is not the number of
    states of the model.

    Why: a state is an array in the order of `model.states`.

    Example: `model.rhs(0.1)` to mean a time.

    Way out: `model.rhs(time=0.1)`, or a state such as `model.initial_state()`.
    """
    given = " x ".join(map(str, shape)) if shape else "a scalar"
    return error(
        "BG791",
        f"a state of this model has {states} numbers; the one given has the shape {given}",
        help="start from `model.initial_state()`; a time is given by name: `time=0.1`",
    )


def run_is_over() -> Diagnostic:
    """BG792: a run that is over

    What: a run of `model.step()` was advanced or read after it had ended.

    Why: it ends where its `with` block ends, by `close`, or with the error of an earlier `advance`.

    Example: `with model.step() as run: pass`, then `run.advance("1 s")`

    Way out: begin another run with `model.step()`.
    """
    return error("BG792", "this run is over", help="begin another one: `model.step()`")


def bad_magic(line: str) -> Diagnostic:
    """BG793: a cell magic with wrong arguments

    What: the line of `%%bgc` does not name a variable for the model, or has more than it takes.

    Why: the model is bound to that variable.

    Example: `%%bgc` alone.

    Way out: write `%%bgc motor`, `%%bgc motor start` for its scene `start`, or
    `%%bgc motor --file motor.bg` to keep the text in a file.
    """
    return error(
        "BG793",
        f"`%%bgc {line.strip()}` does not name a variable for the model",
        help="write `%%bgc NAME`, `%%bgc NAME SCENE` or `%%bgc NAME --file FILE.bg`",
    )


def wrong_unit(name: str, given: str, unit: str) -> Diagnostic:
    """BG063: a parameter value in the wrong unit

    What: the unit measures another kind of quantity than the parameter.

    Why: a wrong unit is nearly always a wrong value or a wrong parameter.

    Example: `--set "boom.mass=7 m"`.

    Way out: give a unit of the same kind, or a number alone for SI.
    """
    wanted = f"`{unit}`" if unit else "no unit: it is a plain number"
    return error(
        "BG063",
        f"`{given}` is not a unit of `{name}`, which is in {wanted}"
        if unit
        else f"`{name}` has {wanted}; `{given}` does not fit",
        help="give a unit of the same kind, or a number alone for SI",
    )


def bad_assignment(text: str, example: str) -> Diagnostic:
    """BG064: an option without a name and a value

    What: the text of `--set`, `--use`, `--match` or `--noise` is not of the form `name=value`.

    Why: a parameter is set, and a slot filled, as `full.name=value`.

    Example: `--set boom.mass`.

    Way out: write `--set boom.mass=7e3` or `--set "boom.mass=7 t"`; `--use "elbow.lock=Rigid[5]"`.
    """
    option = example.partition(" ")[0]
    if not text.strip():
        problem = "an empty text"
    elif "=" not in text:
        problem = f"`{text}` without `=` and a value"
    else:
        problem = f"`{text}` without a {'name' if text.strip().startswith('=') else 'value'}"
    return error("BG064", f"`{option}` is given {problem}", help=f"write `{example}`")


def unknown_column(name: object, known: Iterable[str]) -> Diagnostic:
    """BG065: a column that the result does not have

    What: the result has no observed quantity of that name.

    Why: a scene computes only what it observes.

    Example: `result["tip.y"]` where the scene observes `tip.z`.

    Way out: use one of the names suggested, or add `observe NAME;` to the scene.
    """
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


def bad_option(name: str, value: object, wanted: str, example: str = "1e-3") -> Diagnostic:
    """BG066: an option of a run with an unusable value

    What: a tolerance, step, interval or duration is not a usable number.

    Why: all of them must be finite and positive. A relative tolerance lies between 1e-15 (rounding)
    and 0.5, and a fixed step is not longer than the run.

    Example: `--step 0`; `--rtol 1e300`.

    Way out: give a positive number; times are in seconds.
    """
    return error(
        "BG066",
        f"`{name}` is {value}, which is not {wanted}",
        help=f"give {wanted}, for example `{example}`",
    )


def no_duration(scene: str) -> Diagnostic:
    """BG067: a run without an end

    What: neither the scene nor the command gives a duration.

    Why: a file without a scene, or a scene without `run`, has no duration.

    Example: `bgc run rlc.bg` where the scene has no `run 10 ms;`.

    Way out: write `run 10 s;` in the scene, or give `--time "10 s"` or `duration=10`.
    """
    whose = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG067",
        f"{whose} has no duration",
        help="write `run 10 s;` in the scene, or give `--time 10`",
    )


def too_many_rows(rows: int, columns: int) -> Diagnostic:
    """BG068: more rows than fit in memory

    What: the rows of this run would take more than half of the machine's memory, or, where they go
    to a file, more than the whole disk.

    Why: the run is long and writes a row at each small step.

    Example: a day at 1 ms: 86 million rows.

    Way out: write fewer rows: `run 1 h every 1 s;`, or `--every 1`. Or write them to a file, which
    does not hold them in memory: `--out FILE.npz`, `model.simulate(out="FILE.npz")`.
    """
    size = rows * columns * 8 / 2**20
    amount = f"{size / 1024:.1f} GiB" if size > 100 else f"{size:.1f} MiB"
    return error(
        "BG068",
        f"{rows:,} rows of {columns} columns would take {amount}",
        help="write fewer rows: `run .. every ..;` in the scene, or `--every`",
    )


def bad_panel(text: str) -> Diagnostic:
    """BG069: a panel of a plot that cannot be read

    What: the text does not name the columns of a panel.

    Why: a panel is `a, b` (against time) or `y against x`.

    Example: `--panel "force against"`.

    Way out: write `--panel "tip.z, handle.z"` or `--panel "force against elevation"`.
    """
    return error(
        "BG069",
        f"`{text}` is not a panel of a plot",
        help='write `--panel "tip.z, handle.z"` or `--panel "force against elevation"`',
    )


def unknown_solver(name: str, known: Sequence[str], span: Span | None = None) -> Diagnostic:
    """BG071: an integration method that does not exist

    What: the solver's name is not one of the methods.

    Why: it is misspelt, or a method of another tool.

    Example: `--solver ode45`.

    Way out: choose one of the names suggested.
    """
    listed = ", ".join(f"`{method}`" for method in known)
    return error(
        "BG071",
        f"there is no solver `{name}`",
        span,
        help=did_you_mean(name, known) or f"choose one of {listed}",
    )


def step_needed(solver: str) -> Diagnostic:
    """BG072: a fixed-step method without a step

    What: the method takes fixed steps, and no step is given.

    Why: neither the scene nor the command gives a step.

    Example: `bgc run rlc.bg --solver rk4`.

    Way out: write `step 1 ms;` or `solver rk4(step = 1 ms);` in the scene, or give `--step 0.001`.
    """
    return error(
        "BG072",
        f"solver `{solver}` needs a step",
        help="write `step 1 ms;` in the scene, or give `--step 0.001`",
    )


def option_not_served(solver: str, option: str, fixed: bool, served: Sequence[str]) -> Diagnostic:
    """BG044: an option that the integration method does not have

    What: an option is given for a method to which it does not apply.

    Why: ignoring it would leave the accuracy as it was. A fixed-step method has tolerances only
    where it may divide its steps (`substeps`); otherwise the length of its `step` determines its
    error. An adaptive method chooses its steps by `rtol` and `atol`, and evaluates the Jacobian in
    each of them, so it has no `keep`.

    Example: `bgc run crane.bg --rtol 1e-10` for a scene with `solver ros34prw; step 1 ms;`.

    Way out: shorten `step`, let steps be divided where their error is too large (`--substeps 8`),
    or choose a method with error control (`--solver rodas5p`).
    """
    if fixed and option in ("rtol", "atol", "max_step"):
        reason = "its steps have the fixed length `step`"
        divide = "let it be divided with `substeps = 8`, " if "substeps" in served else ""
        way_out = f"shorten `step`, {divide}or use a method with error control such as `rodas5p`"
    else:
        reason = "it does not apply to this method"
        way_out = f"omit it; `{solver}` takes {', '.join(f'`{name}`' for name in served)}"
    return error("BG044", f"solver `{solver}` has no option `{option}`: {reason}", help=way_out)


def unknown_part(name: str, known: Iterable[str]) -> Diagnostic:
    """BG045: a part that the drawn model does not have

    What: `--collapse` names no part of the model.

    Why: a part is named by its path from the model, such as `crane.shoulder`.

    Example: `bgc graph crane.bg --collapse shoulder`.

    Way out: take a path that the drawing shows as nested boxes.
    """
    have = sorted(known)
    way_out = did_you_mean(name, have) or (
        f"use one of {listed(have)}" if have else "the model has no parts of parts"
    )
    return error("BG045", f"there is no part `{name}` to collapse", help=way_out)


def unknown_driver(
    device: str, driver: str, have: Sequence[str], span: Span | None = None
) -> Diagnostic:
    """BG073: a device driver that this build does not have

    What: a device of the scene names a driver that the runtime does not have.

    Why: it is misspelt, or the driver is not part of this build.

    Example: `device hand = joystick();`.

    Way out: use `device hand = trace(file = "motion.csv");` to play a recorded motion.
    """
    return error(
        "BG073",
        f"device `{device}` uses the driver `{driver}`, which this build does not have",
        span,
        help=did_you_mean(driver, have)
        or f"use one of its drivers: {listed(have)}; `trace(file = ..)` plays a recorded motion",
    )


def device_not_opened(device: str, driver: str, reason: str) -> Diagnostic:
    """BG074: a device that could not be opened

    What: the driver could not start.

    Why: its file is missing or malformed, or the hardware is not connected.

    Example: `device hand = trace(file = "missing.csv");`.

    Way out: follow the reason given. A trace file is searched for in the folder of the `.bg` file.
    """
    return error(
        "BG074",
        f"device `{device}` ({driver}) could not be opened: {reason}",
        help="correct the device's options in the scene; file paths start at the folder of the "
        "`.bg` file",
    )


def wrong_shape(name: str, given: Sequence[int], components: int) -> Diagnostic:
    """BG077: a vector or matrix of the wrong shape

    What: the values given do not match the parameter's components one to one.

    Why: a vector `axis[3]` takes three numbers, a matrix `K[2, 2]` two rows of two.

    Example: `model.parameters["axis"] = [0, 1]` for `param axis[3]`.

    Way out: give as many values as the parameter has components, or set one component:
    `parameters["axis[2]"]`.
    """
    shape = " x ".join(str(size) for size in given)
    return error(
        "BG077",
        f"{shape} values do not fit `{name}`, which has {components} "
        f"component{'' if components == 1 else 's'}",
        help="give as many values, row by row, or set one component by its own name",
    )
