"""Run 1: simulate a scene, write and draw the result."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bgc.diagnostics.diagnostic import as_error
from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.options import (
    PICTURE,
    Devices,
    Errors,
    Json,
    MethodOptions,
    Preview,
    SceneOptions,
    Strict,
    Whole,
)
from bgc.runtime.cli.printing import (
    AT_FAULT,
    INTERRUPTED,
    attempt,
    print_diagnostics,
    print_text,
)
from bgc.runtime.model import Model
from bgc.runtime.results.result import Result
from bgc.runtime.results.summary import as_json, extremes, requirements, summarise
from bgc.runtime.running.row_stream import FILES, write_result

_KEPT = 2_000_000  # samples of a run in step with the clock


@command()
def run(
    scene: SceneOptions,
    whole: Whole,
    strict: Strict,
    preview: Preview,
    *,
    out: str | None = option(
        "Write the rows: .csv, .npz, .zarr; - for standard output.", type=Target(*FILES, "-")
    ),
    plot: str | None = option("Draw the columns: .png, .svg or .pdf.", type=PICTURE),
    panels: tuple[str, ...] = option(
        'Panel of the plot: "tip.z, handle.z" or "force against elevation". May be repeated.',
        "--panel",
    ),
    devices: Devices,
    method: MethodOptions,
    error: Errors,
    sensitivities: tuple[str, ...] = option(
        "Differentiate the columns by a parameter or an initial value. May be repeated."
    ),
    shapes: bool = option("Record the poses of all shapes in the .npz file."),
    realtime: bool = option("Run in step with the clock (see bgc haptic)."),
    json: Json,
    quiet: bool = option("Print no summary and no progress bar.", "--quiet", "-q"),
) -> int:
    """Simulate a scene of FILE; write and draw what it observes.

    If the run fails, or Ctrl-C or SIGTERM ends it, the rows so far are still written. A requirement
    of the scene that does not hold is a warning.
    """
    require(plot or not panels, "--panel needs --plot FILE")
    archive = out is not None and Path(out).suffix.lower() == ".npz"
    require(archive or not shapes, "--shapes needs --out FILE.npz")
    require(not (shapes and realtime), "--realtime records no shapes")
    model = scene.model(quiet, strict=strict, whole=whole, preview=preview, shapes=shapes)
    target = sys.stdout if out == "-" else None if out is None else Path(out)
    require(not (error and realtime), "--realtime estimates no errors")
    require(not (json and out == "-"), "--json and --out - both need standard output")
    require(not (sensitivities and realtime), "--realtime gives no sensitivities")
    chosen = {"devices": dict(devices), **method.arguments}
    if realtime:
        result, status = _in_real_time(model, quiet, **chosen)
    else:
        result, status = attempt(
            lambda: model.simulate(
                **chosen,
                progress=not quiet,
                out=target,
                error=error is not False,
                sensitivities=sensitivities,
            )
        )
    if strict and result.warnings:
        print_diagnostics(map(as_error, result.warnings))
        status = status or AT_FAULT
    else:
        print_diagnostics(result.warnings)
    if realtime and target is not None:
        write_result(result, target)
    drawn = plot if status == 0 or len(result.time) > 1 else None
    if drawn is not None:
        result.with_sensitivities().plot(drawn, panels=panels or None)
    if json:
        print_text(as_json(result.with_sensitivities()))
    elif not quiet:
        estimate = f"  +- {result.error_estimate}" if error else ""
        shown = extremes(result.with_sensitivities())
        texts = (summarise(result), estimate, shown, requirements(result))
        files = _files(result, out, drawn)
        print_text("\n".join(filter(None, (*texts, files))), err=out == "-")
    return status


def _in_real_time(
    model: Model,
    quiet: bool,
    *,
    duration: float | None,
    every: float | None,
    devices: Mapping[str, str],
    **solver: Any,
) -> tuple[Result, int]:
    """Run in step with the clock; return the rows, and the status."""
    # Only this needs the loop and its view.
    from bgc.runtime.cli.realtime import follow, print_couplings
    from bgc.runtime.realtime.servo_binding import End
    from bgc.runtime.running.arguments import read_solver
    from bgc.runtime.running.simulate import method_of, times_of

    method, _ = method_of(model, read_solver(solver))
    end = float(times_of(model, method, duration, every)[-1])
    loop = model.realtime(end, keep=_KEPT, devices=devices, **solver)
    print_couplings(loop, quiet)
    report = follow(loop, quiet)
    print_diagnostics([report.problem] if report.problem is not None else [])
    if not quiet:
        print_text("\n".join(report.lines()), err=True)
    interrupted = INTERRUPTED if report.end is End.STOPPED else 0
    return loop.result(every or model.facts.every), AT_FAULT if report.failed else interrupted


def _files(result: Result, out: str | None, plot: str | None) -> str:
    """Name the files that were written, or the options that write some."""
    rows = f"{out} ({result.row_count:,} rows)" if out not in (None, "-") else None
    if names := " and ".join(filter(None, (rows, plot))):
        return f"wrote {names}"
    return "" if out == "-" else "`--out FILE.csv` writes all rows, `--plot FILE.png` draws them"
