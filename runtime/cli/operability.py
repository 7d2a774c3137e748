"""`bgc operability`."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Any

import click

from bgc.runtime.cli.app import AT_FAULT, INTERRUPTED, print_diagnostics
from bgc.runtime.cli.options import (
    check_target,
    method_options,
    model_file,
    read_assignments,
    read_method,
    read_times,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.compiling import compile_model
from bgc.runtime.results.study import StudyInterrupted

_SHOWN = 3  # failures

_EPILOG = """\b
Example (lift.bg and north_sea.csv: the manual, "Operability"):
  bgc operability lift.bg --height "sea.height=1..5 m:3" \\
      --period "sea.period=5..13 s:5" --seed "sea.seed=1..4:4" \\
      --require "max(tension) < 350 kN" \\
      --require "peak(speed) from 20 s < 3 m/s" --exposure "3 h" \\
      --scatter north_sea.csv --plot map.png
"""


@click.command(epilog=_EPILOG)
@model_file
@scene_option
@set_option
@use_option
@click.option(
    "--height", required=True, metavar="VALUES", help='Heights: "vessel.sea.height=1..4 m:7".'
)
@click.option(
    "--period", required=True, metavar="VALUES", help='Periods: "vessel.sea.period=5..13 s:5".'
)
@click.option("--heading", metavar="VALUES", help='Headings: "vessel.sea.heading=90, 180 deg".')
@click.option("--seed", metavar="VALUES", help='Seeds: "vessel.sea.seed=1..10:10".')
@click.option(
    "--require",
    "criteria",
    multiple=True,
    metavar="TEXT",
    help='Criterion: "max(tension) < 300 kN", "min(clearance) from 20 s > 1 m". May be repeated; '
    "by default the limits of the scene.",
)
@click.option(
    "--judge",
    type=click.Choice(("gumbel", "worst")),
    default="gumbel",
    help="Extreme over the seeds: the most probable one, or that of the worst seed.",
)
@click.option("--exposure", metavar="TIME", help='Time for which extremes are to hold: "3 h".')
@click.option("--scatter", metavar="FILE", help="Scatter diagram (CSV), for the downtime.")
@click.option("--out", metavar="FILE", help="Write all cells and criteria: .csv.")
@click.option("--plot", metavar="FILE", help="Draw the maps: .png, .svg or .pdf.")
@click.option("--store", metavar="DIR", help="Zarr group for all runs (.zarr), resumable.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler: tcp://10.0.0.5:8786.")
@method_options
@click.option("--quiet", "-q", is_flag=True, help="Print no progress bar.")
@click.pass_context
def operability(
    context: click.Context,
    /,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    height: str,
    period: str,
    heading: str | None,
    seed: str | None,
    criteria: tuple[str, ...],
    judge: str,
    exposure: str | None,
    scatter: str | None,
    out: str | None,
    plot: str | None,
    store: str | None,
    scheduler: str | None,
    quiet: bool,
    **method: Any,
) -> None:
    """Find the sea states in which criteria hold: height x period x heading x seed.

    Prints the governing criterion of each sea state, the limiting height of each period, and the
    downtime for a scatter diagram. A sea state with a failed run is not operable;
    the exit status is then 1.
    """
    check_target(out, (".csv",))
    check_target(plot, (".png", ".svg", ".pdf"))
    check_target(store, (".zarr",))
    # Only this command needs it.
    from bgc.runtime.studies.operability_result import read_scatter

    diagram = read_scatter(scatter) if scatter is not None else None
    arguments = read_method(method)
    model = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(model.warnings)
    try:
        found = model.operability(
            height, period, criteria, heading=heading, seed=seed, judge=judge,
            exposure=read_times(exposure=exposure)["exposure"], store=store, scheduler=scheduler,
            progress=not quiet, resume=True, **arguments,
        )  # fmt: skip
    except StudyInterrupted as problem:
        again = "; the same command computes the others" if problem.kept else ""
        click.echo(f"{problem}{again}", err=True)
        context.exit(INTERRUPTED)
    print_diagnostics((*found.warnings, *islice(found.study.placed_failures(), _SHOWN)))
    if out is not None:
        found.to_csv(out)
    if plot is not None:
        found.plot(plot)
    tables = found.tables()
    if diagram is not None:
        tables.append(found.downtime_table(found.downtime(diagram)))
    print_tables(tables)
    print_written(out, plot, store)
    context.exit(AT_FAULT if found.study.failures else 0)
