"""Run 9: compile a scene to C, to a shared object or to an FMU."""

import os
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Annotated, Literal

import click

from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.runtime.cli.command import command, option, require
from bgc.runtime.cli.options import SceneOptions, Strict, Verify, Whole
from bgc.runtime.cli.printing import print_diagnostics, write_file
from bgc.runtime.running.compiling import load_or_compile

_FMI = {"fmu2": 2, "fmu3": 3}


@command()
def build(
    scene: SceneOptions,
    whole: Whole,
    strict: Strict,
    verify: Verify,
    target: Annotated[
        Literal["so", "c", "fmu2", "fmu3", "ssp", "html"],
        option(
            "so: a shared object; c: one self-contained C11 file; fmu2, fmu3: a Functional Mock-up "
            "Unit (FMI 2.0 or 3.0), for Model Exchange and Co-Simulation; ssp: a system of FMUs "
            "(SSP 1.0), see --part; html: a page that runs the model in any browser, one file "
            "without a server (needs ziglang).",
            default="so",
            show_default=True,
        ),
    ],
    out: Annotated[
        str,
        option(
            "Folder to write to; with --target c, - for standard output.",
            "-o",
            "--out",
            metavar="DIR",
            default=".",
        ),
    ],
    prefix: Annotated[
        str | None,
        option("With --target c: names begin with NAME_ instead of bgc_.", metavar="NAME"),
    ],
    platforms: Annotated[
        str | None,
        option(
            "With --target fmu2, fmu3 or ssp: platforms to build binaries for, separated by "
            "commas: linux64, linux-aarch64, win64, darwin64, darwin-aarch64. Default: this "
            "machine's. Others need ziglang.",
            metavar="NAMES",
        ),
    ],
    inputs: Annotated[
        tuple[str, ...],
        option(
            "With --target fmu2, fmu3 or ssp: an input of a model, a source (`supply.e`) or a "
            "parameter that becomes an input of the FMU. It is added to what the scene gives. In "
            "a system of several parts PART.NAME. May be repeated.",
            "--input",
            metavar="NAME",
        ),
    ],
    parts: Annotated[
        tuple[str, ...],
        option(
            "With --target ssp: one more part of the system. Without FILE a scene of the same "
            "file, without SCENE the first one. The part of FILE itself has the file's name. May "
            "be repeated.",
            "--part",
            metavar="NAME=FILE:SCENE",
        ),
    ],
    wires: Annotated[
        tuple[str, ...],
        option(
            'With --target ssp: a connection, "plant.angle -> loop.measured"; its end becomes an '
            "input. May be repeated.",
            "--connect",
            metavar="WIRE",
        ),
    ],
    reference: Annotated[
        bool,
        option(
            "With --target fmu2 or fmu3: write the files of a cross-check too, NAME_ref.csv, "
            "NAME_in.csv and NAME_ref.opt."
        ),
    ],
    timings: Annotated[bool, option("Print the time of each stage.")],
) -> None:
    """Compile a scene of FILE to C, a shared object, an FMU or a live page, and print its path.

    With --target c the header of the C file is written beside it. Two C files link into one
    program if each has a --prefix of its own.
    """
    require(out != "-" or target == "c", "only --target c can be written to standard output")
    for name, given, targets in (
        ("--prefix", prefix is not None, ("c",)),
        ("--platforms", platforms is not None, ("fmu2", "fmu3", "ssp")),
        ("--input", inputs, ("fmu2", "fmu3", "ssp")),
        ("--reference", reference, ("fmu2", "fmu3")),
        ("--part", parts, ("ssp",)),
        ("--connect", wires, ("ssp",)),
    ):
        require(not given or target in targets, f"{name} needs --target {' or '.join(targets)}")
    file, options = scene.file, scene.options(whole=whole, strict=strict, verify=verify)
    goal = Path(out) / f"{file.stem}{f'.{scene.scene}' if scene.scene else ''}.{target}"
    seconds: Mapping[str, float] = {}
    if target in _FMI:
        goals, seconds = _fmus(file, options, _FMI[target], platforms, inputs, reference, goal)
    elif target == "ssp":
        goals = [_system(file, options, parts, wires, platforms, inputs, goal.parent)]
    else:
        contents, seconds = _contents(file, options, target, prefix)
        if out == "-":
            click.echo(contents[0], nl=False)
        else:
            _make(goal.parent)
            for content, path in zip(contents, (goal, goal.with_suffix(".h")), strict=False):
                write_file(path, content)
        goals = [] if out == "-" else [goal]
    if timings and seconds:
        click.echo(_table(seconds), err=True)
    for path in goals:
        click.echo(os.fsencode(path))


def _contents(
    file: Path, options: Options, target: str, prefix: str | None
) -> tuple[list[bytes], Mapping[str, float]]:
    """Make a C file and its header, a page, or a shared object; and the seconds of the stages."""
    if target == "c":
        return _c_file(file, options, prefix)
    if target == "html":
        # The compiler is slow to load, and a shared object from the cache does without it.
        from bgc.runtime.web.export import live_page

        made = live_page(file, options)
        print_diagnostics(made.notices)
        return [made.document.encode()], made.seconds
    seconds: dict[str, float] = {}
    built = load_or_compile(file, options, seconds)
    print_diagnostics(built.warnings)
    return [built.library.read_bytes()], seconds


def _c_file(
    file: Path, options: Options, prefix: str | None
) -> tuple[list[bytes], Mapping[str, float]]:
    # As above.
    from bgc.building.build import runtime_directory
    from bgc.driver import compile_scene
    from bgc.emission.amalgamate import public_header
    from bgc.emission.emit import amalgamate_lowered
    from bgc.emission.prefix import prefix_problem, with_prefix

    stages = compile_scene(file, options, until="lower")
    begin = perf_counter()
    text = amalgamate_lowered(stages.lowered, stages.source_hash, runtime_directory())
    seconds = {**stages.seconds, "emit": perf_counter() - begin}
    texts = [text, public_header(runtime_directory())]
    if prefix is not None:
        problem = prefix_problem(prefix, text)
        require(not problem, f"--prefix {prefix}: {problem}")
        texts = [with_prefix(each, prefix) for each in texts]
    print_diagnostics(stages.warnings)
    return [each.encode() for each in texts], seconds


def _fmus(
    file: Path,
    options: Options,
    version: int,
    platforms: str | None,
    inputs: tuple[str, ...],
    reference: bool,
    goal: Path,
) -> tuple[list[Path], Mapping[str, float]]:
    """Write an FMU and the files beside it; return them and the seconds of the stages."""
    # The compiler and Jinja2 are slow to load, and a shared object does without them.
    from bgc.runtime.fmi.binaries import read_platforms
    from bgc.runtime.fmi.export import write_fmu
    from bgc.runtime.fmi.model import prepare_model

    wanted = read_platforms(platforms)
    model = prepare_model(file, options, version, inputs)
    _make(goal.parent)
    goals = write_fmu(model, wanted, goal.parent, reference)
    print_diagnostics(model.built.warnings)
    return list(goals), model.stages.seconds


def _system(
    file: Path,
    options: Options,
    parts: tuple[str, ...],
    wires: tuple[str, ...],
    platforms: str | None,
    inputs: tuple[str, ...],
    folder: Path,
) -> Path:
    """Write a system of FMUs."""
    # As for `_fmus`.
    from bgc.runtime.fmi.binaries import read_platforms
    from bgc.runtime.fmi.ssp import (
        first_part,
        prepare_system,
        read_part,
        read_wire,
        write_system,
    )

    wanted = read_platforms(platforms)
    files = [first_part(file, options), *(read_part(text, file) for text in parts)]
    system = prepare_system(files, [read_wire(text) for text in wires], inputs)
    _make(folder)
    goal = write_system(system, wanted, folder)
    print_diagnostics([each for part in system.parts for each in part.model.built.warnings])
    return goal


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise BgError([cannot_write(str(folder), reason)]) from problem


def _table(seconds: Mapping[str, float]) -> str:
    """Tabulate the seconds of the stages, and their sum."""
    rows = {**seconds, "together": sum(seconds.values())}
    width = max(map(len, rows))
    return "\n".join(f"{name:<{width}} {spent:8.3f} s" for name, spent in rows.items())
