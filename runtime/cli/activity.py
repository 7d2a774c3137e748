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
@click.option(
    "--time", "duration", metavar="TIME", help="Simulated time; by default that of the scene."
)
@click.option(
    "--negligible",
    type=click.FloatRange(0, 1),
    default=0.01,
    show_default=True,
    help="Share of the activity up to which to try leaving a part out.",
)
@click.option(
    "--within",
    type=float,
    default=0.01,
    show_default=True,
    help="Largest error of a change, as a part of the range; unless the scene has `require`.",
)
@click.option(
    "--budget",
    metavar="TIME",
    default="120 s",
    show_default=True,
    help="Longest time for the measurements.",
)
@click.option("--elements", is_flag=True, help="List elements instead of parts.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, in SI units with all digits.")
@click.option("--quiet", "-q", is_flag=True, help="Show no progress bar.")
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
    """Show where the energy of a scene of FILE goes, and what could be left out.

    Ranks parts by the integral of the absolute power. Makes parts with little activity rigid or
    simpler or switches them off, one by one and together, runs each change, and compares it with
    the scene. Prints the lines to add to the scene, with the error of each.
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
