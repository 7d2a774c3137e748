"""`bgc causality`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.printing.causality import causality_tables, stroke_table
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    model_file,
    read_assignments,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_tables


@click.command()
@model_file
@scene_option
@set_option
@use_option
def causality(
    file: Path, scene: str | None, assignments: tuple[str, ...], uses: tuple[str, ...]
) -> None:
    """Show the causality of a scene of FILE: strokes, storage, algebraic loops.

    A stroke, |-> or ->|, stands at the end of the bond that receives the effort. Each is printed
    with its reason.
    """
    options = Options(scene, read_assignments(assignments), uses=read_uses(uses))
    try:
        stages = compile_scene(file, options, until="equations")
    except BgError:
        # Where the strokes are known, they help to understand why there are no equations.
        print_tables([stroke_table(compile_scene(file, options, until="causality").causal)])
        raise
    print_diagnostics(stages.warnings)
    print_tables(causality_tables(stages))
