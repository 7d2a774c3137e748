"""`bgc fit`."""

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

_EPILOG = """\b
Examples (tuned.bg and shaken.csv: the manual, "Many runs"):
  bgc fit tuned.bg --data shaken.csv --vary "stiffness=50..500 N/m" \\
      --vary "damping=0..50 N*s/m"
  bgc fit tuned.bg --data shaken.csv --vary "stiffness=1..1e4 N/m" \\
      --starts 16 --noise "stretch=1 mm" --loss huber --plot fit.png
"""


@click.command(epilog=_EPILOG)
@model_file
@scene_option
@set_option
@use_option
@click.option(
    "--data",
    required=True,
    metavar="FILE",
    help="CSV file of the recorded motion: columns `time` and observed ones, `x [mm]`.",
)
@click.option(
    "--vary",
    "varied",
    multiple=True,
    required=True,
    metavar="RANGE",
    help='Parameter to estimate, with its bounds: "k=1..1000 N/m". May be repeated.',
)
@click.option(
    "--match",
    "matches",
    multiple=True,
    metavar="OBSERVED=RECORDED",
    help="A column of the file with another name than the scene's. May be repeated.",
)
@click.option(
    "--noise",
    "noises",
    multiple=True,
    metavar="NAME=VALUE",
    help='Standard deviation of a column: "position=1 mm". Estimated by default.',
)
@click.option(
    "--loss",
    type=click.Choice(("linear", "soft_l1", "huber", "cauchy")),
    default="linear",
    help="linear: least squares; the others bear outliers.",
)
@click.option(
    "--starts",
    type=click.IntRange(min=1),
    default=1,
    metavar="N",
    help="Start at the best of N points within the bounds.",
)
@click.option(
    "--confidence",
    type=float,
    default=0.95,
    help="Level of the confidence intervals; 0.95 by default.",
)
@click.option("--out", metavar="FILE", help="Write estimates and intervals: .csv.")
@click.option("--plot", metavar="FILE", help="Draw data and estimate: .png, .svg or .pdf.")
@method_options
@click.pass_context
def fit(
    context: click.Context,
    /,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    data: str,
    varied: tuple[str, ...],
    matches: tuple[str, ...],
    noises: tuple[str, ...],
    loss: str,
    starts: int,
    confidence: float,
    out: str | None,
    plot: str | None,
    **method: Any,
) -> None:
    """Estimate parameters of a scene of FILE from a recorded motion.

    Minimises the squares of computed less recorded values within bounds. Prints the estimates
    with their confidence intervals, and warns of parameters that the data do not determine.
    """
    check_target(out, (".csv",))
    check_target(plot, (".png", ".svg", ".pdf"))
    arguments = read_method(method)
    if arguments.pop("duration") or arguments.pop("every"):
        raise click.UsageError("the data give the times: omit --time and --every")
    model = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(model.warnings)
    pairs = read_assignments(matches, '--match "position=x"')
    match = {recorded: observed for observed, recorded in pairs}
    noise = dict(read_assignments(noises, '--noise "x=2 mm"'))
    arguments.pop("every", None)
    try:
        estimate = model.fit(
            data, varied, match=match, noise=noise, loss=loss, starts=starts,
            confidence=confidence, **arguments,
        )  # fmt: skip
    except KeyboardInterrupt:
        click.echo("interrupted before the estimate was found: nothing is written", err=True)
        context.exit(INTERRUPTED)
    print_diagnostics(estimate.warnings)
    if out is not None:
        estimate.to_csv(out)
    if plot is not None:
        estimate.plot(plot)
    print_tables(estimate.tables())
    print_written(out, plot)
    context.exit(0 if estimate.converged else AT_FAULT)
