"""BG050-BG099: the machine a model meets: C compiler, cache, files written, parameters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.grammar.catalogue import did_you_mean, error, warning
from bgc.grammar.diagnostics import Diagnostic

_INSTALL_COMPILER = (
    "install one (`apt-get install gcc`, `xcode-select --install`) or the compiler that comes "
    "as a Python package (`pip install ziglang`); `bgc doctor` shows what is found"
)


def no_c_compiler(tried: Sequence[str]) -> Diagnostic:
    """BG050: no C compiler was found

    What: a model becomes machine code through a C compiler, and none is on this machine.

    Why: `$CC`, `cc`, `gcc`, `clang` and the `ziglang` wheel are looked for, in this order.

    Example: a slim container image with Python alone.

    Way out: install gcc or clang with the system's package manager, or `pip install ziglang`.
    """
    names = ", ".join(f"`{name}`" for name in tried)
    return error("BG050", f"no C compiler was found (tried {names})", help=_INSTALL_COMPILER)


def chosen_compiler_missing(command: str) -> Diagnostic:
    """BG051: the compiler named by `$CC` is not there

    What: the environment variable `CC` names a program that does not exist or cannot be run.

    Why: a compiler that was asked for by name is never silently replaced by another.

    Example: `CC=gcc-99 bgc run rlc.bg`.

    Way out: correct `CC`, or unset it to let bgc look for `cc`, `gcc` and `clang`.
    """
    return error(
        "BG051",
        f"`$CC` names the C compiler `{command}`, which cannot be run",
        help="correct `CC`, or unset it to let bgc look for `cc`, `gcc` and `clang`",
    )


def compiler_does_not_work(command: str, output: str) -> Diagnostic:
    """BG052: the C compiler does not compile a trivial program

    What: the compiler was found, but fails on ten lines of C that use only the C library.

    Why: mostly the headers of the C library are missing, or `CC` is not a C compiler.

    Example: Debian with `gcc` but without `libc6-dev`.

    Way out: `apt-get install libc6-dev`, or another compiler through `CC`.
    """
    return error(
        "BG052",
        f"the C compiler `{command}` does not work: it fails on a trivial program",
        note=output,
        help="install the C library's headers (`apt-get install libc6-dev`), or name another "
        "compiler in `CC`",
    )


def compiler_rejected_code(command: str, output: str, kept: str) -> Diagnostic:
    """BG053: the C compiler failed on the emitted code

    What: the compiler works, but not on the C that bgc emitted for this model.

    Why: a defect of bgc, of the compiler, or a limit such as the machine's memory.

    Example: gcc killed for lack of memory on a very large model.

    Way out: the C files and the compiler's words are kept: please report them.
    """
    return error(
        "BG053",
        f"the C compiler `{command}` failed on the emitted code",
        note=output,
        help=f"the C files and the whole output are kept in {kept}: please report them",
    )


def cache_not_writable(path: str, reason: str) -> Diagnostic:
    """BG054: the cache directory cannot be written

    What: compiled models are kept in the user's cache directory, which cannot be written.

    Why: a read-only home, no space left, or a file where the directory should be.

    Example: a container that runs as a user without a home.

    Way out: set `BGC_CACHE_DIR` to a directory that can be written. Until then everything is
    compiled anew in a temporary directory.
    """
    return warning(
        "BG054",
        f"the cache directory {path} cannot be written ({reason}): nothing is kept for next time",
        help="set `BGC_CACHE_DIR` to a directory that can be written",
    )


def cannot_write(path: str, reason: str) -> Diagnostic:
    """BG055: a file cannot be written

    What: the operating system refused to write a file.

    Why: no space left, no permission, or the directory does not exist.

    Example: `bgc run rlc.bg --out /missing/r.csv`.

    Way out: write elsewhere, make the directory, or free some space. A file of that name from
    an earlier run is untouched.
    """
    return error(
        "BG055",
        f"cannot write {path}: {reason}",
        help="choose another place, make the directory or free some space",
    )


def dot_missing() -> Diagnostic:
    """BG056: Graphviz is not installed

    What: a bond graph is laid out by the program `dot` of Graphviz, which was not found.

    Why: Graphviz is no Python package: it cannot come with bgc.

    Example: `bgc graph rlc.bg -o rlc.svg` on a bare machine.

    Way out: `apt-get install graphviz` (`brew install graphviz`), or `-o rlc.dot` for the text.
    """
    return error(
        "BG056",
        "the program `dot` of Graphviz was not found",
        help="`apt-get install graphviz` (`brew install graphviz`), or write the graph's text "
        "with `-o FILE.dot`",
    )


def dot_failed(output: str) -> Diagnostic:
    """BG057: Graphviz failed

    What: `dot` was found but ended with an error.

    Why: mostly a build of Graphviz without the wanted output format.

    Example: `-o rlc.pdf` with a Graphviz built without cairo.

    Way out: write SVG, or the graph's text with `-o FILE.dot`.
    """
    return error(
        "BG057",
        "the program `dot` of Graphviz failed",
        note=output,
        help="write SVG, or the graph's text with `-o FILE.dot`",
    )


def package_missing(package: str, purpose: str, extra: str) -> Diagnostic:
    """BG058: an optional Python package is missing

    What: this function needs a Python package that bgc does not require otherwise.

    Why: packages that few users need are extras.

    Example: `result.to_pandas()` without pandas.

    Way out: install the extra that is named.
    """
    return error(
        "BG058",
        f"{purpose} needs the Python package `{package}`",
        help=f"`pip install {package}`, or the extra `{extra}` of bgc",
    )


def cannot_load(path: str, reason: str) -> Diagnostic:
    """BG059: a compiled model cannot be loaded

    What: the shared object exists but this Python cannot load it.

    Why: built on another machine, by another version of bgc, or not a compiled model at all.

    Example: a `.so` copied from an x86 machine to an ARM one.

    Way out: build it again here from the `.bg` file.
    """
    return error(
        "BG059",
        f"cannot load the compiled model {path}: {reason}",
        help="build it again on this machine from the `.bg` file",
    )


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


def bad_option(name: str, value: object, wanted: str) -> Diagnostic:
    """BG066: an option of a run that makes no sense

    What: a tolerance, a step, an interval or a duration is not a usable number.

    Why: all of them have to be finite and positive.

    Example: `--step 0`.

    Way out: a positive number, in seconds where it is a time.
    """
    return error(
        "BG066", f"`{name}` is {value}, which is not {wanted}", help=f"give {wanted}, as `1e-3`"
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


def unknown_file_kind(path: str, kinds: Sequence[str]) -> Diagnostic:
    """BG070: a file name whose ending tells no known kind

    What: the ending of an output file's name says in which form it is written.

    Why: the one given is not among those that can be written.

    Example: `--out r.xlsx`.

    Way out: one of the endings named.
    """
    listed = ", ".join(f"`{kind}`" for kind in kinds)
    return error("BG070", f"cannot tell from its name how to write {path}", help=f"use {listed}")


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


def nothing_to_draw(reason: str) -> Diagnostic:
    """BG075: there is nothing to plot

    What: a plot needs at least one observed column and two rows.

    Why: the scene observes nothing, or the run ended at its start.

    Example: `bgc run f.bg --plot p.png` where the scene has no `observe`.

    Way out: add `observe NAME;` to the scene.
    """
    return error(
        "BG075", f"there is nothing to plot: {reason}", help="add `observe NAME;` to the scene"
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
