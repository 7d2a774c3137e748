"""`bgc bode`."""

from __future__ import annotations

import csv
import sys
from itertools import product
from pathlib import Path
from typing import Any, TextIO

import click
import numpy as np

from bgc.diagnostics.diagnostic import BgError
from bgc.printing.tables import Table
from bgc.runtime.cli.linear_options import (
    PICTURES,
    closed_option,
    gain_option,
    in_loop,
    open_linear,
    plot_option,
    range_options,
    require_one,
    scene_options,
)
from bgc.runtime.cli.options import check_target, input_option, output_option
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.frequency import HEADER, Response, frequency_response
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.results.files import written_whole


@click.command()
@scene_options
@input_option(multiple=True)
@output_option(multiple=True)
@gain_option
@closed_option
@range_options
@click.option("--out", metavar="FILE", help="Write the response: .csv, or - for standard output.")
@plot_option("magnitude and phase")
def bode(
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    gain: str | None,
    closed: bool,
    low: float | None,
    high: float | None,
    out: str | None,
    plot: str | None,
    **scene: Any,
) -> None:
    """Compute the frequency response of an output of a scene of FILE to an input.

    The scene is linearised at the initial state, at a time (--at) or in equilibrium (--steady).
    The input is the effort or flow of a source (supply.e), a parameter (mass) or a channel of a
    device. Several inputs and outputs, and vectors, give a curve for each pair.
    """
    if not (inputs and outputs):
        raise click.UsageError("give an --input and an --output")
    check_target(out, (".csv", "-"))
    check_target(plot, PICTURES)
    linear = open_linear(**scene, inputs=inputs, outputs=outputs)
    if gain is not None or closed:
        require_one("input", ", ".join(inputs), linear.inputs)
        require_one("output", ", ".join(outputs), linear.outputs)
        linear = in_loop(linear, gain, closed)
    responses = _responses(linear, low, high)
    if out == "-":
        _write(responses, sys.stdout)
    elif out is not None:
        with written_whole(Path(out)) as aside, aside.open("w", encoding="utf-8", newline="") as f:
            _write(responses, f)
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.bode_plot import plot_bode

        plot_bode(responses, Path(plot))
    if out != "-":
        print_tables([_summary(response) for response in responses])
    print_written(out, plot)


def _responses(linear: Linearisation, low: float | None, high: float | None) -> list[Response]:
    """Compute the response of each pair; a pair without one is left out where another has one."""
    found: list[Response] = []
    refused: list[BgError] = []
    for k, j in product(range(len(linear.inputs)), range(len(linear.outputs))):
        try:
            found.append(frequency_response(linear.channel(j, k), low, high))
        except BgError as problem:
            refused.append(problem)
    if not found:
        raise refused[0]
    return found


def _write(responses: list[Response], file: TextIO) -> None:
    """Write one response, or several with the names of output and input before each line."""
    if len(responses) == 1:
        responses[0].write_csv(file)
        return
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(("output", "input", *HEADER))
    for response in responses:
        for row in response.rows().tolist():
            writer.writerow((response.output, response.input, *map(repr, row)))


def _summary(response: Response) -> Table:
    """Tabulate a line for each decade, for the peak, and for each crossover with its margin."""
    rows = response.rows()
    decades = np.arange(
        np.ceil(np.log10(response.omega[0]) - 1e-9), np.log10(response.omega[-1]) + 1e-9
    )
    lines = {
        float(response.omega[k]): (*map(_digits, rows[k, :3]), "")
        for k in (int(np.argmin(np.abs(np.log10(response.omega) - d))) for d in decades)
    }
    for mark in response.landmarks:
        at = np.flatnonzero(response.omega == mark.omega)
        values = rows[at[0], 1:3] if len(at) else ()
        if not len(at):  # an unbounded peak: the rows beside it are those of no frequency asked for
            lines = {
                omega: row for omega, row in lines.items() if abs(omega / mark.omega - 1) > 0.01
            }
        cells = [*map(_digits, (mark.omega, *values)), "", ""][:3]
        lines[mark.omega] = (*cells, mark.meaning)
    unit = f" re 1 {response.unit}" if response.unit else ""
    title = f"{response.output} by {response.input}"
    header = ("frequency rad/s", f"magnitude dB{unit}", "phase deg", "")
    return Table(title, header, tuple(lines[omega] for omega in sorted(lines)))


def _digits(value: float) -> str:
    """Six digits; the rounding of a zero, such as that of |G| = 1 in dB, is a zero."""
    return f"{value if abs(value) > 1e-9 else 0.0:.6g}"
