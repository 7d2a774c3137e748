"""`bgc step`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import click

from bgc.diagnostics.catalogue.analysis import bad_duration
from bgc.diagnostics.diagnostic import BgError
from bgc.printing.tables import Table
from bgc.runtime.cli.linear_options import (
    PICTURES,
    closed_option,
    gain_option,
    in_loop,
    open_linear,
    plot_option,
    require_one,
    scene_options,
)
from bgc.runtime.cli.options import check_target, input_option, output_option
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.time_response import TimeResponse, impulse_response, step_response
from bgc.runtime.running.quantity import read_quantity


@click.command()
@scene_options
@input_option(multiple=False)
@output_option(multiple=True)
@gain_option
@closed_option
@click.option("--impulse", is_flag=True, help="Take a unit impulse instead of a unit step.")
@click.option("--time", metavar="TIME", help='Duration: "2 s"; by default from the modes.')
@click.option("--out", metavar="FILE", help="Write the response: .csv, or - for standard output.")
@plot_option("the response")
def step(
    input_: str,
    outputs: tuple[str, ...],
    gain: str | None,
    closed: bool,
    impulse: bool,
    time: str | None,
    out: str | None,
    plot: str | None,
    **scene: Any,
) -> None:
    """Compute the response of the linear model of a scene of FILE to a unit step of an input.

    The scene is linearised at the initial state, at a time (--at) or in equilibrium (--steady);
    outputs are deviations from there. With --closed the step is that of the reference.
    """
    check_target(out, (".csv", "-"))
    check_target(plot, PICTURES)
    duration = None if time is None else read_quantity(time, "--time", "s")
    if duration is not None and not duration > 0:
        raise BgError([bad_duration(duration)])
    linear = open_linear(**scene, inputs=[input_], outputs=outputs)
    require_one("input", input_, linear.inputs)
    if gain is not None or closed:
        require_one("output", ", ".join(outputs) or "what the scene observes", linear.outputs)
        linear = in_loop(linear, gain, closed)
    compute = impulse_response if impulse else step_response
    response = compute(linear, duration)
    if out == "-":
        response.write_csv(sys.stdout)
    else:
        print_tables([_facts_table(response, impulse)])
        if out is not None:
            response.to_csv(Path(out))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.step_chart import plot_time_response

        title = f"unit {'impulse' if impulse else 'step'} of {response.input}"
        plot_time_response(response, title, Path(plot))
    print_written(out, plot)


def _facts_table(response: TimeResponse, impulse: bool) -> Table:
    """Tabulate steady value, rise, settling and overshoot of each output."""
    rows = []
    for k, name in enumerate(response.outputs):
        facts = None if impulse else response.facts(k)
        last = float(response.value[-1, k])
        steady = float(response.steady[k])
        cells = ("", "", "", "")
        if facts is not None:
            cells = (
                f"{facts.rise:.4g}", f"{facts.settling:.4g}", f"{100 * facts.overshoot:.4g}",
                f"{facts.peak_time:.4g}" if facts.overshoot else "",
            )  # fmt: skip
        shown = f"{steady:.6g}" if math.isfinite(steady) else "none"
        rows.append((name, response.units[k], f"{last:.6g}", shown, *cells))
    header = (
        "output", "unit", f"at {response.time[-1]:g} s", "steady", "rise s", "settling s",
        "overshoot %", "peak at s",
    )  # fmt: skip
    title = f"unit {'impulse' if impulse else 'step'} of {response.input}"
    return Table(title, header, tuple(rows))
