"""`bgc build`."""

from __future__ import annotations

import shutil
from pathlib import Path

import click
from bgc.grammar.catalogue.machine import cannot_write
from bgc.grammar.diagnostics import BgError
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import model_file, read_assignments, scene_option, set_option


@click.command()
@model_file
@scene_option
@set_option
@click.option(
    "--target",
    type=click.Choice(["so", "c"]),
    default="so",
    show_default=True,
    help="A shared object, or one self-contained C11 file.",
)
@click.option(
    "-o",
    "--out",
    "folder",
    metavar="DIR",
    type=click.Path(path_type=Path),
    default=Path(),
    help="Where to write it; here by default.",
)
@click.option("--timings", is_flag=True, help="Tell what each stage took.")
def build(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    target: str,
    folder: Path,
    timings: bool,
) -> None:
    """Compile a scene of FILE to C or to a shared object, and print its path."""
    from bgc.driver import amalgamate_source, compile_source
    from bgc.options import Options
    from bgc.runtime.files import written_whole

    options = Options(scene, tuple(read_assignments(assignments).items()))
    name = file.stem if scene is None else f"{file.stem}.{scene}"
    goal = folder / f"{name}.{target}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise BgError([cannot_write(str(folder), problem.strerror or "")]) from problem
    if target == "c":
        text = amalgamate_source(file, options)
        with written_whole(goal) as aside:
            aside.write_text(text, encoding="utf-8")
    else:
        built = compile_source(file, options)
        print_diagnostics(built.warnings)
        with written_whole(goal) as aside:
            shutil.copyfile(built.library, aside)
    click.echo(goal)
