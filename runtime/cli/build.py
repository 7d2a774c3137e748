"""`bgc build`."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter

import click

from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    model_file,
    read_assignments,
    read_uses,
    scene_option,
    set_option,
    strict_option,
    use_option,
    verify_option,
    whole_option,
)
from bgc.runtime.results.files import written_whole
from bgc.runtime.running.compiling import load_or_compile

_FMI = {"fmu2": 2, "fmu3": 3}


@click.command()
@model_file
@scene_option
@set_option
@use_option
@whole_option
@strict_option
@verify_option
@click.option(
    "--target",
    type=click.Choice(["so", "c", "fmu2", "fmu3", "ssp", "html"]),
    default="so",
    show_default=True,
    help="so: a shared object; c: one self-contained C11 file; fmu2, fmu3: a Functional Mock-up "
    "Unit (FMI 2.0 or 3.0), for Model Exchange and Co-Simulation; ssp: a system of FMUs (SSP 1.0), "
    "see --part; html: a page that runs the model in any browser, one file without a server (needs "
    "ziglang).",
)
@click.option(
    "-o",
    "--out",
    "out",
    metavar="DIR",
    default=".",
    help="Folder to write to; with --target c, - for standard output.",
)
@click.option(
    "--prefix",
    metavar="NAME",
    help="With --target c: names begin with NAME_ instead of bgc_.",
)
@click.option(
    "--platforms",
    metavar="NAMES",
    help="With --target fmu2, fmu3 or ssp: platforms to build binaries for, separated by commas: "
    "linux64, linux-aarch64, win64, darwin64, darwin-aarch64. Default: this machine's. Others need "
    "ziglang.",
)
@click.option(
    "--input",
    "inputs",
    metavar="NAME",
    multiple=True,
    help="With --target fmu2, fmu3 or ssp: an input of a model, a source (`supply.e`) or a "
    "parameter that becomes an input of the FMU. It is added to what the scene gives. In a system "
    "of several parts PART.NAME. May be repeated.",
)
@click.option(
    "--part",
    "parts",
    metavar="NAME=FILE:SCENE",
    multiple=True,
    help="With --target ssp: one more part of the system. Without FILE a scene of the same file, "
    "without SCENE the first one. The part of FILE itself has the file's name. May be repeated.",
)
@click.option(
    "--connect",
    "wires",
    metavar="WIRE",
    multiple=True,
    help='With --target ssp: a connection, "plant.angle -> loop.measured"; its end '
    "becomes an input. May be repeated.",
)
@click.option(
    "--reference",
    is_flag=True,
    help="With --target fmu2 or fmu3: write the files of a cross-check too, NAME_ref.csv, "
    "NAME_in.csv and NAME_ref.opt.",
)
@click.option("--timings", is_flag=True, help="Print the time of each stage.")
def build(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    whole: bool,
    strict: bool,
    verify: bool,
    target: str,
    out: str,
    prefix: str | None,
    platforms: str | None,
    inputs: tuple[str, ...],
    parts: tuple[str, ...],
    wires: tuple[str, ...],
    reference: bool,
    timings: bool,
) -> None:
    """Compile a scene of FILE to C, a shared object, an FMU or a live page, and print its path.

    With --target c the header of the C file is written beside it. Two C files link into one
    program if each has a --prefix of its own.
    """
    if prefix is not None and target != "c":
        raise click.UsageError("--prefix needs --target c")
    if out == "-" and target != "c":
        raise click.UsageError("only --target c can be written to standard output")
    for name, given, targets in (
        ("--platforms", platforms is not None, ("fmu2", "fmu3", "ssp")),
        ("--input", bool(inputs), ("fmu2", "fmu3", "ssp")),
        ("--reference", reference, ("fmu2", "fmu3")),
        ("--part", bool(parts), ("ssp",)),
        ("--connect", bool(wires), ("ssp",)),
    ):
        if given and target not in targets:
            raise click.UsageError(f"{name} needs --target {' or '.join(targets)}")
    options = Options(
        scene,
        read_assignments(assignments),
        strict=strict,
        verify=verify,
        whole=whole,
        uses=read_uses(uses),
    )
    if target in _FMI:
        _fmu(file, options, _FMI[target], platforms, inputs, reference, Path(out), timings)
        return
    if target == "ssp":
        _system(file, options, parts, wires, platforms, inputs, Path(out))
        return
    header = b""
    if target == "html":
        content, seconds = _live_page(file, options)
    elif target == "c":
        content, header, seconds = _c_file(file, options, prefix)
    else:
        content, seconds = _shared_object(file, options)
    if timings:
        click.echo(_table(seconds), err=True)
    if out == "-":
        click.echo(content, nl=False)
        return
    name = file.stem if scene is None else f"{file.stem}.{scene}"
    goal = Path(out) / f"{name}.{target}"
    _make(goal.parent)
    with written_whole(goal) as aside:
        aside.write_bytes(content)
    if header:
        with written_whole(goal.with_name(f"{name}.h")) as aside:
            aside.write_bytes(header)
    click.echo(os.fsencode(goal))


def _fmu(
    file: Path,
    options: Options,
    version: int,
    platforms: str | None,
    inputs: tuple[str, ...],
    reference: bool,
    folder: Path,
    timings: bool,
) -> None:
    """Write an FMU and the files beside it, and print their paths."""
    # The compiler and Jinja2 are slow to load, and a shared object does without them.
    from bgc.runtime.fmi.binaries import read_platforms
    from bgc.runtime.fmi.export import write_fmu
    from bgc.runtime.fmi.model import prepare_model

    wanted = read_platforms(platforms)
    model = prepare_model(file, options, version, inputs)
    _make(folder)
    goals = write_fmu(model, wanted, folder, reference)
    print_diagnostics(model.built.warnings)
    if timings:
        click.echo(_table(model.stages.seconds), err=True)
    for goal in goals:
        click.echo(os.fsencode(goal))


def _system(
    file: Path,
    options: Options,
    parts: tuple[str, ...],
    wires: tuple[str, ...],
    platforms: str | None,
    inputs: tuple[str, ...],
    folder: Path,
) -> None:
    """Write a system of FMUs, and print its path."""
    # As for `_fmu`.
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
    click.echo(os.fsencode(goal))


def _c_file(
    file: Path, options: Options, prefix: str | None
) -> tuple[bytes, bytes, Mapping[str, float]]:
    """Compile to C: the C file, its header, and the seconds of the stages."""
    # The compiler is slow to load, and a shared object from the cache does without it.
    from bgc.building.build import runtime_directory
    from bgc.driver import compile_scene
    from bgc.emission.amalgamate import public_header
    from bgc.emission.emit import amalgamate_lowered
    from bgc.emission.prefix import prefix_problem, with_prefix

    stages = compile_scene(file, options, until="lower")
    begin = perf_counter()
    text = amalgamate_lowered(stages.lowered, stages.source_hash, runtime_directory())
    seconds = {**stages.seconds, "emit": perf_counter() - begin}
    header = public_header(runtime_directory())
    if prefix is not None:
        if problem := prefix_problem(prefix, text):
            raise click.UsageError(f"--prefix {prefix}: {problem}")
        text, header = with_prefix(text, prefix), with_prefix(header, prefix)
    print_diagnostics(stages.warnings)
    return text.encode(), header.encode(), seconds


def _live_page(file: Path, options: Options) -> tuple[bytes, Mapping[str, float]]:
    """Make the page of a scene; return it with the seconds of the stages."""
    # The compiler is slow to load, and a shared object from the cache does without it.
    from bgc.runtime.web.export import live_page

    made = live_page(file, options)
    print_diagnostics(made.notices)
    return made.document.encode(), made.seconds


def _shared_object(file: Path, options: Options) -> tuple[bytes, Mapping[str, float]]:
    seconds: dict[str, float] = {}
    built = load_or_compile(file, options, seconds)
    print_diagnostics(built.warnings)
    return built.library.read_bytes(), seconds


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise BgError([cannot_write(str(folder), reason)]) from problem


def _table(seconds: Mapping[str, float]) -> str:
    """Tabulate the seconds of the stages, and their sum."""
    rows = [*seconds.items(), ("together", sum(seconds.values()))]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}} {spent:8.3f} s" for name, spent in rows)
