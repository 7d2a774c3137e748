"""`bgc stress`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.runtime.cli.app import AT_FAULT, print_diagnostics
from bgc.runtime.cli.options import (
    check_target,
    model_file,
    read_assignments,
    read_times,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.compiling import compile_model
from bgc.runtime.stress.stress import stress as stress_map
from bgc.runtime.stress.tables import as_json as map_json
from bgc.runtime.stress.tables import summary, tables, write_csv


@click.command()
@model_file
@scene_option
@set_option
@use_option
@click.option(
    "--drive",
    "drives",
    multiple=True,
    metavar="NAME=LOW..HIGH",
    help='Parameter and its values: "k=1e3..1e14 N/m", "step=1 us..0.1 s:11", "rtol=1e-3, 1e-6", '
    '"*.lock.stiffness=.." for several at once. May be repeated; by default all are driven.',
)
@click.option(
    "--grid", is_flag=True, help="Drive two --drive together, over all pairs of their values."
)
@click.option("--solver", metavar="NAME", help="Method to judge; by default that of the scene.")
@click.option("--rtol", type=float, help="Relative tolerance of the method.")
@click.option("--step", metavar="TIME", help="Step of the method.")
@click.option(
    "--time", "duration", metavar="TIME", help="Simulated time; by default that of the scene."
)
@click.option(
    "--within", type=float, help="Largest acceptable error, as a fraction of the range of a result."
)
@click.option(
    "--budget",
    metavar="TIME",
    default="120 s",
    show_default=True,
    help="Longest time for the measurements.",
)
@click.option("--fresh", is_flag=True, help="Discard earlier results.")
@click.option("--out", metavar="FILE", help="Write the results: .csv.")
@click.option("--plot", metavar="FILE", help="Draw the map: .png, .svg or .pdf.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, in SI units with all digits.")
@click.option("--quiet", "-q", is_flag=True, help="Print the totals only.")
@click.pass_context
def stress(
    context: click.Context,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    drives: tuple[str, ...],
    grid: bool,
    solver: str | None,
    rtol: float | None,
    step: str | None,
    duration: str | None,
    within: float | None,
    budget: str,
    fresh: bool,
    out: str | None,
    plot: str | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Drive a scene of FILE to its extremes; map where it holds and fails.

    Varies stiffnesses, inertias, resistances, sources and angles through their ranges, and the
    step, the tolerance and the simulated time. Compares each run with other methods. Re-running
    resumes where Ctrl-C or the budget ended it. The exit status is 1 where results are wrong
    without an error or a warning.
    """
    if grid and len(drives) != 2:
        raise click.UsageError("--grid takes two --drive")
    check_target(out, (".csv",))
    check_target(plot, (".png", ".svg", ".pdf"))
    times = read_times(step=step, time=duration, budget=budget)
    model = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(model.warnings)
    found = stress_map(
        model,
        drives,
        grid=grid,
        solver=solver,
        rtol=rtol,
        step=times["step"],
        duration=times["time"],
        within=within,
        budget=times["budget"] or 0.0,
        fresh=fresh,
        progress=not quiet,
    )
    if as_json:
        click.echo(map_json(found))
    elif quiet:
        click.echo(summary(found))
    else:
        print_tables(tables(found))
    if out is not None:
        write_csv(found, out)
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.stress.plot import draw

        draw(found, plot)
    if not (quiet or as_json):
        print_written(out, plot)
    context.exit(AT_FAULT if found.wrong else 0)
