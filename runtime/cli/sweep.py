"""`bgc sweep`."""

from __future__ import annotations

import sys
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
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.compiling import compile_model
from bgc.runtime.results.ensemble import EnsembleInterrupted
from bgc.runtime.running.sweep import points, read_range

_TABLES = (".csv", ".npz")
_SHOWN = 3  # failures, and warnings of instances


@click.command()
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
    help='Values of a parameter: "boom.mass=5..9 t:20" for 20 values. May be repeated.',
)
@click.option(
    "--sample",
    type=click.IntRange(min=1),
    metavar="N",
    help="Take N points spread over all ranges instead of all combinations.",
)
@click.option(
    "--out",
    metavar="FILE",
    required=True,
    help="File to write: .csv, .npz, or - for standard output.",
)
@method_options
@click.option("--quiet", "-q", is_flag=True, help="Print no summary and no progress bar.")
@click.pass_context
def sweep(
    context: click.Context,
    /,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    varied: tuple[str, ...],
    sample: int | None,
    out: str,
    quiet: bool,
    **method: Any,
) -> None:
    """Simulate a scene of FILE for many values of its parameters.

    Runs all combinations of the values, or N points among them (--sample), several at once.
    After Ctrl-C or SIGTERM the instances that are done are written; the same command then
    computes the others.
    """
    check_target(out, (*_TABLES, "-"))
    arguments = read_method(method)
    model = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(model.warnings)
    ranges = [read_range(text, model.parameters) for text in varied]
    values = points(ranges, sample)
    status = 0
    try:
        ensemble = model.simulate_many(values, **arguments, progress=not quiet, resume=True)
    except EnsembleInterrupted as problem:
        again = "; the same command computes the others" if problem.kept else ""
        click.echo(f"{problem}{again}", err=True)
        ensemble, status = problem.result, INTERRUPTED
    except KeyboardInterrupt:
        click.echo("interrupted before the first instance: nothing is written", err=True)
        context.exit(INTERRUPTED)
    placed = (ensemble.placed_failures(), ensemble.placed_warnings())
    shown = (diagnostic for each in placed for diagnostic in islice(each, _SHOWN))
    print_diagnostics((*ensemble.warnings, *shown))
    if out == "-":
        ensemble.write_csv(sys.stdout)
    elif Path(out).suffix.lower() == ".npz":
        ensemble.to_npz(out)
    else:
        ensemble.to_csv(out)
    if not quiet:
        counts = {name: ensemble.status.count(name) for name in dict.fromkeys(ensemble.status)}
        ended = ", ".join(f"{count} {name}" for name, count in counts.items())
        undefined = len(ensemble.not_finite)
        ended += f"; {undefined} with values that are not finite" if undefined else ""
        earlier = f"; {ensemble.recalled} of them before" if ensemble.recalled else ""
        alone = f"; one by one: {ensemble.alone}" if ensemble.alone else ""
        click.echo(f"{ended}{earlier}{alone}", err=out == "-")
    context.exit(status or (AT_FAULT if ensemble.failures else 0))
