"""`bgc causality`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    model_file,
    read_assignments,
    read_uses,
    scene_option,
    set_option,
    use_option,
)


@click.command()
@model_file
@scene_option
@set_option
@use_option
def causality(
    file: Path, scene: str | None, assignments: tuple[str, ...], uses: tuple[str, ...]
) -> None:
    """Tell how a scene of FILE is computed: strokes with reasons, storage, algebraic loops.

    A stroke, |-> or ->|, stands at the end of the bond that is given the effort.
    """
    from bgc.driver import Compilation
    from bgc.options import Options
    from bgc.printing.causality import causality_tables
    from bgc.runtime.cli.printing import print_tables

    compilation = Compilation(
        file, Options(scene, read_assignments(assignments), uses=read_uses(uses))
    )
    print_tables(causality_tables(compilation))
    print_diagnostics(compilation.warnings)
