"""`bgc sweep`."""

from __future__ import annotations

import sys
from itertools import islice
from pathlib import Path
from typing import Any

import click
import numpy as np

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
from bgc.runtime.results.ensemble import Ensemble, EnsembleInterrupted
from bgc.runtime.results.study import Study, StudyInterrupted
from bgc.runtime.results.study_kinds import STUDY_KINDS
from bgc.runtime.running.sweep import DESIGNS
from bgc.runtime.studies.sweep import Design, check_reports

_TABLES = (".csv", ".npz")
_STORE = ".zarr"
_PICTURES = (".png", ".svg", ".pdf")
_SHOWN = 3  # failures, and warnings of instances

_EPILOG = """\b
Examples (tuned.bg: the manual, "Many runs"):
  bgc sweep tuned.bg --vary "mass=1..9 kg:20" --out rows.csv
  bgc sweep tuned.bg --vary "mass=1, 2, 4 kg" --observe "max(speed)" \\
      --vary "stiffness=10..1e3 N/m:7 log" --plot map.png
  bgc sweep tuned.bg --vary "mass=1..9 kg" --vary "damping=1..9 N*s/m" \\
      --sample 64 --design saltelli --observe "rms(speed) from 5 s" --rank
  bgc sweep tuned.bg --cases cases.csv --observe "rms(speed)" --out study.zarr
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
    metavar="VALUES",
    help='Values of a parameter: "boom.mass=5..9 t:20" for 20 values, "k=1..100 N/m:5 log", '
    '"seed=1, 2, 5". May be repeated.',
)
@click.option("--cases", metavar="FILE", help="CSV file with a column for each parameter.")
@click.option(
    "--sample",
    type=click.IntRange(min=1),
    metavar="N",
    help="Take N points spread over all ranges instead of all combinations.",
)
@click.option(
    "--design",
    type=click.Choice(DESIGNS),
    default="latin",
    help="How --sample spreads them; saltelli (N base points) is for Sobol indices.",
)
@click.option("--seed", type=int, default=0, help="Seed of the sample; 0 by default.")
@click.option(
    "--observe",
    "observed",
    multiple=True,
    metavar="TEXT",
    help='Keep this number of each run, and no rows: "max(tension)", "quantile(x, 0.95)", '
    '"rms(heave) from 20 s". May be repeated.',
)
@click.option("--rank", is_flag=True, help="Rank the parameters by their influence.")
@click.option(
    "--out",
    metavar="FILE",
    help="File to write: .csv, .npz, .zarr (a directory, resumable), or - for standard output.",
)
@click.option("--plot", metavar="FILE", help="Draw the observables, or all rows: .png, .svg, .pdf.")
@click.option(
    "--kind",
    type=click.Choice(STUDY_KINDS),
    help="Kind of the plot of observables.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler: tcp://10.0.0.5:8786.")
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
    cases: str | None,
    sample: int | None,
    design: str,
    seed: int,
    observed: tuple[str, ...],
    rank: bool,
    out: str | None,
    plot: str | None,
    kind: str | None,
    scheduler: str | None,
    quiet: bool,
    **method: Any,
) -> None:
    """Simulate a scene of FILE for many values of its parameters.

    Runs all combinations of the values, or N points among them (--sample), several at once.
    After Ctrl-C or SIGTERM the instances that are done are written; the same command then
    computes the others.
    """
    if not varied and cases is None:
        raise click.UsageError('give --vary "NAME=LOW..HIGH", or --cases FILE')
    if not observed and out is None and plot is None:
        raise click.UsageError('give --out FILE, --plot FILE or --observe "max(NAME)"')
    if not observed and (rank or kind):
        raise click.UsageError('--rank and --kind need --observe "max(NAME)"')
    if kind and plot is None:
        raise click.UsageError("--kind needs --plot FILE")
    check_target(out, (*_TABLES, _STORE, "-"))
    check_target(plot, _PICTURES)
    store = out if out is not None and Path(out).suffix.lower() == _STORE else None
    arguments = read_method(method)
    model = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(model.warnings)
    check_reports(model, Design(varied, sample, design, seed, cases), kind, rank)
    status = 0
    try:
        found = model.sweep(
            varied, observed, **arguments, sample=sample, design=design, seed=seed, cases=cases,
            scheduler=scheduler, store=store, progress=not quiet, resume=True,
        )  # fmt: skip
    except (EnsembleInterrupted, StudyInterrupted) as problem:
        again = "; the same command computes the others" if problem.kept else ""
        click.echo(f"{problem}{again}", err=True)
        found, status = problem.result, INTERRUPTED
    except KeyboardInterrupt:
        click.echo("interrupted before the first instance: nothing is written", err=True)
        context.exit(INTERRUPTED)
    _report(found)
    if store is None:
        _write(found, out)
    _draw(found, plot, kind, status)
    if not quiet:
        click.echo(_summary(found), err=out == "-")
    tables = []
    if isinstance(found, Study) and not quiet and out != "-":
        tables += found.statistics().tables()
    if isinstance(found, Study) and rank:
        tables += found.sensitivity().tables()
    print_tables(tables)
    if not quiet:
        print_written(out, plot if found.status.count("done") or not status else None)
    context.exit(status or (AT_FAULT if found.failures else 0))


def _report(found: Ensemble | Study) -> None:
    """Print the warnings, and the first failures with their instances."""
    placed = [found.placed_failures()]
    if isinstance(found, Ensemble):
        placed.append(found.placed_warnings())
    shown = (diagnostic for each in placed for diagnostic in islice(each, _SHOWN))
    print_diagnostics((*found.warnings, *shown))


def _write(found: Ensemble | Study, out: str | None) -> None:
    if out == "-":
        found.write_csv(sys.stdout)
    elif out is not None and Path(out).suffix.lower() == ".npz":
        found.to_npz(out)
    elif out is not None:
        found.to_csv(out)


def _draw(found: Ensemble | Study, plot: str | None, kind: str | None, status: int) -> None:
    if plot is None or (status and not found.status.count("done")):
        return
    if isinstance(found, Study):
        found.plot(plot, kind=kind)
    else:
        found.plot(plot)


def _summary(found: Ensemble | Study) -> str:
    """Count the instances by their status, and say how they were run."""
    counts = {name: found.status.count(name) for name in dict.fromkeys(found.status)}
    ended = ", ".join(f"{count} {name}" for name, count in counts.items())
    if isinstance(found, Ensemble):
        undefined = len(found.not_finite)
    else:
        undefined = int((~np.isfinite(found.values[found.done]).all(axis=1)).sum())
    ended += f"; {undefined} with values that are not finite" if undefined else ""
    earlier = f"; {found.recalled} of them before" if found.recalled else ""
    alone = f"; one by one: {found.alone}" if found.alone else ""
    return f"{ended}{earlier}{alone}"
