"""`bgc show`."""

from __future__ import annotations

from pathlib import Path

import click

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
@click.option("--after", "name", metavar="PASS", default="equations", show_default=True)
def show(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    whole: bool,
    name: str,
) -> None:
    """Print what a pass of the compiler made of a scene of FILE."""
    from bgc.options import Options
    from bgc.printing.stages import PASSES, show_pass

    if name not in PASSES:
        raise click.UsageError(f"there is no pass {name}; there are {', '.join(PASSES)}")
    options = Options(scene, read_assignments(assignments), whole=whole, uses=read_uses(uses))
    click.echo(show_pass(name, file, options), nl=False)
