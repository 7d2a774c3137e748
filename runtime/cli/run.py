"""`bgc run`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from bgc.diagnostics.diagnostic import as_error
from bgc.options import Options
from bgc.runtime.cli.app import AT_FAULT, INTERRUPTED, print_diagnostics
from bgc.runtime.cli.options import (
    check_target,
    model_file,
    preview_option,
    read_assignments,
    read_times,
    read_uses,
    scene_option,
    set_option,
    strict_option,
    use_option,
    whole_option,
)
from bgc.runtime.model import Model
from bgc.runtime.results.result import Result
from bgc.runtime.results.summary import extremes, summarise
from bgc.runtime.running.compiling import load_as
from bgc.runtime.running.failures import RunInterrupted, SimulationError
from bgc.runtime.running.progress import CompilingLine
from bgc.runtime.running.quantity import read_quantity

_TABLES = (".csv", ".npz")
_PICTURES = (".png", ".svg", ".pdf")


@click.command()
@model_file
@scene_option
@set_option
@use_option
@whole_option
@strict_option
@preview_option
@click.option("--out", metavar="FILE", help="Write the rows: .csv, .npz, or - for standard output.")
@click.option("--plot", metavar="FILE", help="Draw the columns: .png, .svg or .pdf.")
@click.option(
    "--panel",
    "panels",
    multiple=True,
    metavar="TEXT",
    help='Panel of the plot: "tip.z, handle.z" or "force against elevation". May be repeated.',
)
@click.option("--solver", metavar="NAME", help="Integration method (see bgc doc methods).")
@click.option("--rtol", type=float, help="Relative tolerance of an adaptive method.")
@click.option("--atol", type=float, help="Absolute tolerance of all states, in SI units.")
@click.option("--step", metavar="TIME", help='Step of a fixed-step method: 0.001, or "1 ms".')
@click.option("--max-step", metavar="TIME", help='Longest step of an adaptive method: "5 ms".')
@click.option("--substeps", type=int, help="Most parts of a fixed step whose error is too large.")
@click.option("--every", metavar="TIME", help='Interval between rows: "10 ms".')
@click.option(
    "--settle", metavar="FREQUENCY", help='Start modes faster than this at rest: "20 Hz".'
)
@click.option(
    "--time",
    "duration",
    metavar="TIME",
    help='Simulated time: "60 s"; by default that of the scene.',
)
@click.option("--quiet", "-q", is_flag=True, help="Print no summary and no progress bar.")
@click.pass_context
def run(
    context: click.Context,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    whole: bool,
    strict: bool,
    preview: bool,
    out: str | None,
    plot: str | None,
    panels: tuple[str, ...],
    solver: str | None,
    rtol: float | None,
    atol: float | None,
    step: str | None,
    max_step: str | None,
    substeps: int | None,
    every: str | None,
    settle: str | None,
    duration: str | None,
    quiet: bool,
) -> None:
    """Simulate a scene of FILE; write and draw what it observes.

    After a failure, Ctrl-C or SIGTERM the rows up to there are still written.
    """
    if panels and plot is None:
        raise click.UsageError("--panel needs --plot FILE")
    check_target(out, (*_TABLES, "-"))
    check_target(plot, _PICTURES)
    times = read_times(step=step, max_step=max_step, every=every, time=duration)
    filled = read_uses(uses)
    options = Options(scene, strict=strict, whole=whole, uses=filled, preview=preview)
    with CompilingLine(file.name, wanted=not quiet) as line:
        model = load_as(Model, file, options, dict(read_assignments(assignments)), line)
    print_diagnostics(model.warnings)
    status = 0
    try:
        result = model.simulate(
            times["time"],
            every=times["every"],
            solver=solver,
            rtol=rtol,
            atol=atol,
            step=times["step"],
            max_step=times["max_step"],
            substeps=substeps,
            settle=None if settle is None else read_quantity(settle, "--settle", "Hz"),
            progress=not quiet,
        )
    except SimulationError as problem:
        print_diagnostics(problem.diagnostics)
        result, status = problem.result, AT_FAULT
    except RunInterrupted as problem:
        print_diagnostics([problem.diagnostic])
        result, status = problem.result, INTERRUPTED
    if strict and result.warnings:
        print_diagnostics([as_error(warning) for warning in result.warnings])
        status = status or AT_FAULT
    else:
        print_diagnostics(result.warnings)
    _write(result, out)
    drawn = plot is not None and (status == 0 or len(result.time) > 1)
    if drawn:
        result.plot(plot, panels=panels or None)
    if not quiet:
        files = _files(result, out, plot if drawn else None)
        texts = filter(None, (summarise(result), extremes(result), files))
        click.echo("\n".join(texts), err=out == "-")
    context.exit(status)


def _files(result: Result, out: str | None, plot: str | None) -> str:
    """Name the files that were written, or the options that write some."""
    names = [
        *([f"{out} ({len(result.time):,} rows)"] if out not in (None, "-") else []),
        *([plot] if plot is not None else []),
    ]
    if names:
        return f"wrote {' and '.join(names)}"
    return "" if out == "-" else "`--out FILE.csv` writes all rows, `--plot FILE.png` draws them"


def _write(result: Result, out: str | None) -> None:
    if out == "-":
        result.write_csv(sys.stdout)
    elif out is not None and Path(out).suffix.lower() == ".npz":
        result.to_npz(out)
    elif out is not None:
        result.to_csv(out)
