"""`bgc build`."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

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
    type=click.Choice(["so", "c"]),
    default="so",
    show_default=True,
    help="so: a shared object; c: one self-contained C11 file.",
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
    timings: bool,
) -> None:
    """Compile a scene of FILE to C or to a shared object, and print its path.

    With --target c the header of the C file is written beside it. Two C files link into one
    program if each has a --prefix of its own.
    """
    if prefix is not None and target != "c":
        raise click.UsageError("--prefix needs --target c")
    if out == "-" and target != "c":
        raise click.UsageError("only --target c can be written to standard output")
    options = Options(
        scene,
        read_assignments(assignments),
        strict=strict,
        verify=verify,
        whole=whole,
        uses=read_uses(uses),
    )
    header = b""
    if target == "c":
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


def _c_file(
    file: Path, options: Options, prefix: str | None
) -> tuple[bytes, bytes, Mapping[str, float]]:
    """Compile to C: the C file, its header, and the seconds of the stages."""
    # The compiler is slow to load, and a shared object from the cache does without it.
    from bgc.building.build import runtime_directory
    from bgc.driver import compile_scene
    from bgc.emission.emit import amalgamate, public_header
    from bgc.emission.prefix import prefix_problem, with_prefix

    stages = compile_scene(file, options, until="emit")
    text = amalgamate(stages.emitted, runtime_directory())
    header = public_header(runtime_directory())
    if prefix is not None:
        if problem := prefix_problem(prefix, text):
            raise click.UsageError(f"--prefix {prefix}: {problem}")
        text, header = with_prefix(text, prefix), with_prefix(header, prefix)
    print_diagnostics(stages.warnings)
    return text.encode(), header.encode(), stages.seconds


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
