"""`bgc bode`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from bgc.diagnostics.catalogue.analysis import several_components
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.printing.tables import Table
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    check_target,
    input_option,
    model_file,
    output_option,
    point_options,
    read_assignments,
    read_point,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_tables
from bgc.runtime.linear.frequency import Response, frequency_response
from bgc.runtime.linearising.operating import OpenedModel

_TABLES = (".csv",)
_PICTURES = (".png", ".svg", ".pdf")


@click.command()
@model_file
@scene_option
@set_option
@use_option
@input_option(multiple=False)
@output_option(multiple=False)
@point_options
@click.option(
    "--from", "low", type=float, help="Lowest frequency, rad/s; by default from the modes."
)
@click.option(
    "--to", "high", type=float, help="Highest frequency, rad/s; by default from the modes."
)
@click.option("--out", metavar="FILE", help="Write the response: .csv, or - for standard output.")
@click.option("--plot", metavar="FILE", help="Draw magnitude and phase: .png, .svg or .pdf.")
def bode(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    input_: str,
    output: str,
    at: str | None,
    steady: bool,
    low: float | None,
    high: float | None,
    out: str | None,
    plot: str | None,
) -> None:
    """Compute the frequency response of an output of a scene of FILE to an input.

    The scene is linearised at the initial state, at a time (--at) or in equilibrium (--steady).
    The input is the effort or flow of a source (supply.e), a parameter (mass) or a channel of a
    device.
    """
    check_target(out, (*_TABLES, "-"))
    check_target(plot, _PICTURES)
    point = read_point(at, steady)
    options = Options(scene, read_assignments(assignments), uses=read_uses(uses))
    opened = OpenedModel(file, options, [input_], [output])
    linear = opened.linearise(opened.operating_point(point))
    _require_one("input", input_, linear.inputs)
    _require_one("output", output, linear.outputs)
    print_diagnostics(opened.warnings)
    response = frequency_response(linear, low, high)
    if out == "-":
        response.write_csv(sys.stdout)
    elif out is not None:
        response.to_csv(Path(out))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.bode_plot import plot_bode

        plot_bode(response, Path(plot))
    if out != "-":
        _summarise(response)


def _require_one(option: str, text: str, names: Sequence[str]) -> None:
    if len(names) != 1:
        raise BgError([several_components(option, text, names)])


def _summarise(response: Response) -> None:
    """Print a line for each decade, for the peak, and for each crossover with its margin."""
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
    print_tables([Table(title, header, tuple(lines[omega] for omega in sorted(lines)))])


def _digits(value: float) -> str:
    """Six digits; the rounding of a zero, such as that of |G| = 1 in dB, is a zero."""
    return f"{value if abs(value) > 1e-9 else 0.0:.6g}"
