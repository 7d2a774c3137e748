"""`bgc optimise`."""

from __future__ import annotations

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
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.compiling import compile_model
from bgc.runtime.studies.optimum import OptimisationInterrupted

_EPILOG = """\b
Examples (tuned.bg: the manual, "Many runs"):
  bgc optimise tuned.bg --vary "stiffness=10..400 N/m" \\
      --minimise "peak(speed)" --require "peak(stretch) < 0.1 m"
  bgc optimise tuned.bg --vary "stiffness=10..400 N/m" \\
      --vary "damping=1..50 N*s/m" --minimise "peak(speed) from 5 s" \\
      --over "mass=1..3 kg:5" --plot way.png
  bgc optimise tuned.bg --vary "stiffness=10..400 N/m" --runs 200 \\
      --maximise "above(speed, 0.1 m/s)"
"""


@click.command(epilog=_EPILOG)
@model_file
@scene_option
@set_option
@use_option
@click.option(
    "--vary",
    "varied",
    multiple=True,
    required=True,
    metavar="RANGE",
    help='Parameter of the design, with its bounds: "k=50..500 N/m". May be repeated.',
)
@click.option("--minimise", metavar="TEXT", help='Objective: "max(load.z)", "rms(x) from 5 s".')
@click.option("--maximise", metavar="TEXT", help="Objective to be made as large as possible.")
@click.option(
    "--require",
    "criteria",
    multiple=True,
    metavar="TEXT",
    help='Limit: "max(pressure) < 210 bar". May be repeated; by default the limits of the scene.',
)
@click.option(
    "--over",
    multiple=True,
    metavar="VALUES",
    help='Run each design with these values of a parameter: "seed=1, 2, 3". May be repeated.',
)
@click.option(
    "--judge",
    type=click.Choice(("worst", "mean")),
    default="worst",
    help="With --over: take the objective of the worst case, or the mean.",
)
@click.option(
    "--search",
    type=click.Choice(("gradient", "evolution")),
    help="gradient where the observables have derivatives, else evolution.",
)
@click.option(
    "--starts",
    type=click.IntRange(min=1),
    default=1,
    metavar="N",
    help="Start at the best of N designs within the bounds.",
)
@click.option(
    "--runs",
    type=click.IntRange(min=1),
    default=10_000,
    metavar="N",
    help="End after N runs with the best design so far; 10,000 by default.",
)
@click.option("--seed", type=int, default=0, help="Seed of the starts and of the evolution.")
@click.option("--out", metavar="FILE", help="Write the design, its objective and limits: .csv.")
@click.option(
    "--plot", metavar="FILE", help="Draw the best objective against the runs: .png, .svg or .pdf."
)
@method_options
@click.option("--quiet", "-q", is_flag=True, help="Print no progress.")
@click.pass_context
def optimise(
    context: click.Context,
    /,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    varied: tuple[str, ...],
    minimise: str | None,
    maximise: str | None,
    criteria: tuple[str, ...],
    over: tuple[str, ...],
    judge: str,
    search: str | None,
    starts: int,
    runs: int,
    seed: int,
    out: str | None,
    plot: str | None,
    quiet: bool,
    **method: Any,
) -> None:
    """Find the parameters of a scene of FILE that make an observable least or largest.

    Searches within bounds and limits, and prints the best design. The exit status is 1 if no
    design meets the limits or the search did not converge. Ctrl-C ends the search with the
    best design so far.
    """
    if (minimise is None) == (maximise is None):
        raise click.UsageError('give either --minimise "max(NAME)" or --maximise "max(NAME)"')
    check_target(out, (".csv",))
    check_target(plot, (".png", ".svg", ".pdf"))
    arguments = read_method(method)
    model = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(model.warnings)
    try:
        found = model.optimise(
            varied, minimise=minimise, maximise=maximise, require=criteria or None, over=over,
            judge=judge, search=search, starts=starts, runs=runs, seed=seed, progress=not quiet,
            **arguments,
        )  # fmt: skip
        status = 0 if found.converged and found.feasible else AT_FAULT
    except OptimisationInterrupted as problem:
        click.echo(str(problem), err=True)
        if problem.result is None:
            context.exit(INTERRUPTED)
        found, status = problem.result, INTERRUPTED
    print_diagnostics(found.warnings)
    if out is not None:
        found.to_csv(out)
    if plot is not None:
        found.plot(plot)
    print_tables(found.tables())
    print_written(out, plot)
    context.exit(status)
