"""Diagnostics of what a run is given: parameters, options, columns, solvers, devices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_parameter(name: str, known: Iterable[str]) -> Diagnostic:
    """BG060: a parameter that the compiled model does not have

    What: the name given is not among the model's run-time parameters.

    Why: misspelt, a `const` (which is fixed when compiling), or dropped because nothing that
    the scene observes depends on it.

    Example: `model.parameters["crane.bom.mass"] = 7e3`.

    Way out: take one of the names offered; `bgc show FILE --after slice` tells what was dropped.
    """
    return error(
        "BG060",
        f"the compiled model has no parameter `{name}`",
        help=did_you_mean(name, known) or "its names are the keys of `model.parameters`",
    )


def parameter_folded(name: str, value: float) -> Diagnostic:
    """BG078: a parameter that was compiled into the model

    What: the parameter is fixed at zero or one by the scene, and was folded into the equations:
    what it multiplies is not in the model any more.

    Why: a friction of zero needs no resistor. Zeros of parts, and zeros and ones that a scene
    sets, are folded; parameters of the scene's own model are not.

    Example: `model.parameters["crane.elbow.friction"] = 50` where the friction is zero.

    Way out: compile with the value (`bgc.compile(path, parameters={..})`, `--set` on the
    command line), or write `keep crane.elbow.friction;` in the scene: it then stays a run-time
    parameter.
    """
    return error(
        "BG078",
        f"`{name}` is {value:g} in this scene and was compiled in",
        help=f"compile with its value (`parameters=`, `--set`), or write `keep {name};` in the "
        "scene",
    )


def parameter_out_of_range(
    name: str, value: float, unit: str, low: float, high: float
) -> Diagnostic:
    """BG061: a parameter outside the range that the model declares

    What: the value is outside `in low .. high` of the parameter's declaration.

    Why: the author of the model holds other values for meaningless or untested.

    Example: `--set boom.mass=-1` for `param mass = 1 t in 0 t .. 100 t`.

    Way out: a value inside the range, or a wider range in the model.
    """
    shown = f" {unit}" if unit else ""
    return error(
        "BG061",
        f"{value:g}{shown} is out of the range of parameter `{name}`, {low:g} .. {high:g}{shown}",
        help="give a value inside the range, or widen it where the parameter is declared",
    )


def not_a_value(text: str, name: str) -> Diagnostic:
    """BG062: a parameter's value that is not a number with a unit

    What: the text after `=` is not a number, nor a number, a blank and a unit.

    Why: run-time parameters are plain numbers.

    Example: `--set R=2ohm` (without the blank).

    Way out: `--set "R=2 ohm"`, or SI without a unit: `--set R=2`.
    """
    return error(
        "BG062",
        f"`{text}` is not a value for `{name}`",
        help="write a number, or a number, one blank and a unit: `7`, `7 t`, `45 deg`",
    )


def wrong_unit(name: str, given: str, unit: str) -> Diagnostic:
    """BG063: a parameter's value in a unit that does not fit

    What: the unit given measures something else than the parameter.

    Why: units are checked where they are given.

    Example: `--set "boom.mass=7 m"`.

    Way out: a unit of the same kind, or none for SI.
    """
    wanted = f"`{unit}`" if unit else "no unit: it is a plain number"
    return error(
        "BG063",
        f"`{given}` is no unit of `{name}`, which is in {wanted}"
        if unit
        else f"`{name}` has {wanted}, so `{given}` does not fit",
        help="give a unit of the same kind, or a number alone for SI",
    )


def bad_assignment(text: str, example: str) -> Diagnostic:
    """BG064: `--set` or `--use` without a name and a value

    What: the text is not of the form `name=value`.

    Why: a parameter is set, and a slot filled, by its full name.

    Example: `--set boom.mass`.

    Way out: `--set boom.mass=7e3` or `--set "boom.mass=7 t"`; `--use "elbow.lock=Rigid[5]"`.
    """
    found = f"`{text}` is" if text.strip() else "an empty text is"
    return error("BG064", f"{found} not of the form name=value", help=f"write `{example}`")


def unknown_column(name: str, known: Iterable[str]) -> Diagnostic:
    """BG065: a column that the result does not have

    What: the name is not among the observed ones.

    Why: a scene computes only what it observes.

    Example: `result["tip.y"]` where the scene observes `tip.z`.

    Way out: take one of the names offered, or add `observe NAME;` to the scene.
    """
    known = list(known)
    listed = ", ".join(f"`{column}`" for column in known[:12])
    return error(
        "BG065",
        f"the result has no column `{name}`",
        note=f"observed: {listed}{', ...' if len(known) > 12 else ''}" if known else "",
        help=did_you_mean(name, known) or f"add `observe {name};` to the scene",
    )


def bad_option(name: str, value: object, wanted: str, example: str = "1e-3") -> Diagnostic:
    """BG066: an option of a run that makes no sense

    What: a tolerance, a step, an interval or a duration is not a usable number.

    Why: all of them have to be finite and positive, a relative tolerance between 1e-15, where
    rounding begins, and 0.5, and a fixed step no longer than the run.

    Example: `--step 0`; `--rtol 1e300`.

    Way out: a positive number, in seconds where it is a time.
    """
    return error(
        "BG066",
        f"`{name}` is {value}, which is not {wanted}",
        help=f"give {wanted}, as `{example}`",
    )


def no_duration(scene: str) -> Diagnostic:
    """BG067: a run without an end

    What: neither the scene nor the command says how long to run.

    Why: a scene without `run` (or a file without a scene) has no duration.

    Example: `bgc run rlc.bg` where the scene has no `run 10 ms;`.

    Way out: `run 10 s;` in the scene, `--time "10 s"`, or `duration=10`.
    """
    whose = f"scene `{scene}` does not say" if scene else "the file has no scene that says"
    return error(
        "BG067",
        f"{whose} how long to run",
        help="write `run 10 s;` in the scene, or give `--time 10`",
    )


def too_many_rows(rows: int, columns: int) -> Diagnostic:
    """BG068: more rows than fit in memory

    What: the rows of this run would take more than half of the machine's memory.

    Why: a long run with a row for each small step.

    Example: a day at 1 ms: 86 million rows.

    Way out: fewer rows: `run 1 h every 1 s;`, `--every 1`.
    """
    size = rows * columns * 8 / 2**30
    return error(
        "BG068",
        f"{rows:,} rows of {columns} columns would take {size:.1f} GiB",
        help="write fewer rows: `run .. every ..;` in the scene, or `--every`",
    )


def bad_panel(text: str) -> Diagnostic:
    """BG069: a panel of a plot that cannot be read

    What: the text names no columns.

    Why: a panel is `a, b` (against time) or `y against x`.

    Example: `--panel "force against"`.

    Way out: `--panel "tip.z, handle.z"` or `--panel "force against elevation"`.
    """
    return error(
        "BG069",
        f"`{text}` is not a panel of a plot",
        help='write `--panel "tip.z, handle.z"` or `--panel "force against elevation"`',
    )


def unknown_solver(name: str, known: Sequence[str]) -> Diagnostic:
    """BG071: an integration method that does not exist

    What: the name given for the solver is not one of the methods.

    Why: misspelt, or a method of another tool.

    Example: `--solver ode45`.

    Way out: one of the names offered.
    """
    listed = ", ".join(f"`{method}`" for method in known)
    return error(
        "BG071",
        f"there is no solver `{name}`",
        help=did_you_mean(name, known) or f"choose one of {listed}",
    )


def step_needed(solver: str) -> Diagnostic:
    """BG072: a fixed-step method without a step

    What: the method takes steps of a given length, and no length is given.

    Why: neither the scene nor the command gives a step.

    Example: `bgc run rlc.bg --solver rk4`.

    Way out: `step 1 ms;` in the scene, `solver rk4(step = 1 ms);`, or `--step 0.001`.
    """
    return error(
        "BG072",
        f"solver `{solver}` needs a step",
        help="write `step 1 ms;` in the scene, or give `--step 0.001`",
    )


def unknown_driver(device: str, driver: str) -> Diagnostic:
    """BG073: a device driver that this build does not have

    What: the scene's device names a driver which the runtime does not know.

    Why: misspelt, or a driver that is not part of this build.

    Example: `device hand = joystick();`.

    Way out: `device hand = trace(file = "motion.csv");` plays a recorded motion.
    """
    return error(
        "BG073",
        f"device `{device}` uses the driver `{driver}`, which this build does not have",
        help='`trace(file = "motion.csv")` plays a recorded motion',
    )


def device_not_opened(device: str, driver: str, reason: str) -> Diagnostic:
    """BG074: a device that could not be opened

    What: the driver refused to start.

    Why: its file is missing or malformed, or the hardware is not connected.

    Example: `device hand = trace(file = "missing.csv");`.

    Way out: see the reason given; a trace file is looked for beside the `.bg` file.
    """
    return error(
        "BG074",
        f"device `{device}` ({driver}) could not be opened: {reason}",
        help="correct what the scene gives the device; files are looked for beside the `.bg`",
    )


def wrong_shape(name: str, given: Sequence[int], components: int) -> Diagnostic:
    """BG077: a vector or matrix of another shape than the parameter's

    What: the values given do not match the parameter's components one to one.

    Why: a vector `axis[3]` takes three numbers, a matrix `K[2, 2]` two rows of two.

    Example: `model.parameters["axis"] = [0, 1]` for `param axis[3]`.

    Way out: as many values as the parameter has, or one component: `parameters["axis[2]"]`.
    """
    shape = " x ".join(str(size) for size in given)
    return error(
        "BG077",
        f"{shape} values do not fit `{name}`, which has {components} "
        f"component{'' if components == 1 else 's'}",
        help="give as many values, row by row, or set one component by its own name",
    )
