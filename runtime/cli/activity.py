"""`bgc activity`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.runtime.activity.activity import activity_report
from bgc.runtime.activity.tables import as_json as report_json
from bgc.runtime.activity.tables import tables
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
from bgc.runtime.compiling import compile_model
from bgc.runtime.running.quantity import read_quantity


@click.command()
@model_file
@scene_option
@set_option
@use_option
@click.option("--time", "duration", metavar="TIME", help="How much of the scene to simulate.")
@click.option(
    "--negligible",
    type=click.FloatRange(0, 1),
    default=0.01,
    show_default=True,
    help="Share of activity up to which a part is tried to be left out.",
)
@click.option(
    "--within",
    type=float,
    default=0.01,
    show_default=True,
    help="Error that this may cost, of the range; `require` in the scene decides instead.",
)
@click.option(
    "--budget", metavar="TIME", default="120 s", show_default=True, help="How long it may take."
)
@click.option("--elements", is_flag=True, help="List elements, not parts.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: SI units, numbers in full.")
@click.option("--quiet", "-q", is_flag=True, help="No progress bar.")
def activity(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    duration: str | None,
    negligible: float,
    within: float,
    budget: str,
    elements: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Tell where the energy of a scene of FILE goes, and what the scene could do without.

    Parts that carry little are made rigid, simpler or switched off, one by one and together; each
    change is run and compared with the scene as it is, and the lines that do it are printed.
    """
    model = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(model.warnings)
    report = activity_report(
        model,
        duration=None if duration is None else read_quantity(duration, "--time", "s"),
        negligible=negligible,
        within=within,
        budget=read_quantity(budget, "--budget", "s"),
        progress=not quiet,
    )
    if as_json:
        click.echo(report_json(report))
    else:
        print_tables(tables(report, elements))
