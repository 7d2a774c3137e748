"""`bgc run`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from bgc.diagnostics.diagnostic import as_error
from bgc.options import Options
from bgc.runtime.cli.app import AT_FAULT, INTERRUPTED, print_diagnostics
from bgc.runtime.cli.options import (
    check_target,
    device_option,
    method_options,
    model_file,
    preview_option,
    read_assignments,
    read_devices,
    read_method,
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
from bgc.runtime.running.streamed import FILES, write_result

_PICTURES = (".png", ".svg", ".pdf")


@click.command()
@model_file
@scene_option
@set_option
@use_option
@whole_option
@strict_option
@preview_option
@click.option(
    "--out", metavar="FILE", help="Write the rows: .csv, .npz, .zarr; - for standard output."
)
@click.option("--plot", metavar="FILE", help="Draw the columns: .png, .svg or .pdf.")
@click.option(
    "--panel",
    "panels",
    multiple=True,
    metavar="TEXT",
    help='Panel of the plot: "tip.z, handle.z" or "force against elevation". May be repeated.',
)
@device_option
@method_options
@click.option("--shapes", is_flag=True, help="Record the poses of all shapes in the .npz file.")
@click.option("--realtime", is_flag=True, help="Run in step with the clock (see bgc haptic).")
@click.option("--quiet", "-q", is_flag=True, help="Print no summary and no progress bar.")
@click.pass_context
def run(
    context: click.Context,
    /,
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
    shapes: bool,
    realtime: bool,
    quiet: bool,
    devices: tuple[str, ...],
    **method: Any,
) -> None:
    """Simulate a scene of FILE; write and draw what it observes.

    If the run fails, or Ctrl-C or SIGTERM ends it, the rows so far are still written.
    """
    if panels and plot is None:
        raise click.UsageError("--panel needs --plot FILE")
    if shapes and (out is None or Path(out).suffix.lower() != ".npz"):
        raise click.UsageError("--shapes needs --out FILE.npz")
    check_target(out, (*FILES, "-"))
    check_target(plot, _PICTURES)
    arguments = read_method(method)
    filled = read_uses(uses)
    chosen = read_devices(devices)
    options = Options(
        scene, strict=strict, whole=whole, uses=filled, preview=preview, shapes=shapes
    )
    with CompilingLine(file.name, wanted=not quiet) as line:
        model = load_as(Model, file, options, dict(read_assignments(assignments)), line)
    print_diagnostics(model.warnings)
    target = sys.stdout if out == "-" else None if out is None else Path(out)
    status = 0
    try:
        if realtime:
            result, status = _in_real_time(model, arguments, chosen, shapes, quiet)
        else:
            result = model.simulate(**arguments, progress=not quiet, devices=chosen, out=target)
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
    if realtime and target is not None:
        write_result(result, target)
    drawn = plot is not None and (status == 0 or len(result.time) > 1)
    if drawn:
        result.plot(plot, panels=panels or None)
    if not quiet:
        files = _files(result, out, plot if drawn else None)
        texts = filter(None, (summarise(result), extremes(result), files))
        click.echo("\n".join(texts), err=out == "-")
    context.exit(status)


def _in_real_time(
    model: Model, arguments: dict[str, Any], devices: dict[str, str], shapes: bool, quiet: bool
) -> tuple[Result, int]:
    """Run in step with the clock; return the rows, and the status."""
    # Only this needs the loop and its view.
    from bgc.runtime.cli.realtime import LiveView, print_couplings
    from bgc.runtime.realtime.binding import End
    from bgc.runtime.running.simulate import method_of, times_of

    if shapes:
        raise click.UsageError("--realtime records no shapes")
    names = ("rtol", "atol", "step", "max_step", "substeps", "settle")
    given = {name: arguments[name] for name in names}
    method, _ = method_of(model, arguments["solver"], given)
    times = times_of(model, method, arguments.get("duration"), arguments.get("every"))
    loop = model.realtime(
        float(times[-1]),
        devices=devices,
        keep=2_000_000,
        solver=arguments["solver"],
        start=arguments["start"],
        **given,
    )
    print_couplings(loop, quiet)
    with LiveView(loop, wanted=not quiet) as view:
        loop.start()
        report = view.follow()
    if report.problem is not None:
        print_diagnostics([report.problem])
    if not quiet:
        click.echo("\n".join(report.lines()), err=True)
    every = arguments.get("every") or model.facts.every
    interrupted = report.end is End.STOPPED
    return loop.result(every), AT_FAULT if report.failed else INTERRUPTED * interrupted


def _files(result: Result, out: str | None, plot: str | None) -> str:
    """Name the files that were written, or the options that write some."""
    names = [
        *([f"{out} ({result.row_count:,} rows)"] if out not in (None, "-") else []),
        *([plot] if plot is not None else []),
    ]
    if names:
        return f"wrote {' and '.join(names)}"
    return "" if out == "-" else "`--out FILE.csv` writes all rows, `--plot FILE.png` draws them"
