"""`bgc show`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.driver import compile_scene
from bgc.options import Options
from bgc.printing.stages import PASSES, needed_for, show_pass
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    model_file,
    read_assignments,
    read_uses,
    scene_option,
    set_option,
    use_option,
    whole_option,
)


@click.command()
@model_file
@scene_option
@set_option
@use_option
@whole_option
@click.option(
    "--after",
    "name",
    metavar="PASS",
    default="equations",
    show_default=True,
    help="Name of the pass; an unknown name lists all passes.",
)
def show(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    whole: bool,
    name: str,
) -> None:
    """Print the result of one pass of the compiler for a scene of FILE."""
    chosen = next((known for known in PASSES if known == name), None)
    if chosen is None:
        raise click.UsageError(f"there is no pass {name}; there are {', '.join(PASSES)}")
    options = Options(scene, read_assignments(assignments), whole=whole, uses=read_uses(uses))
    stages = compile_scene(file, options, until=needed_for(chosen))
    print_diagnostics(stages.warnings)
    click.echo(show_pass(chosen, stages), nl=False)
