"""`bgc locus`."""

from __future__ import annotations

import csv
from pathlib import Path

import click

from bgc.printing.tables import Table
from bgc.runtime.cli.linear_options import PICTURES, channel_command, plot_option
from bgc.runtime.cli.options import check_target
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.feedback import gain_unit
from bgc.runtime.linear.locus import Locus, root_locus
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.linear.zeros import factors
from bgc.runtime.results.files import written_whole


@click.command()
@channel_command(closable=False)
@click.option("--out", metavar="FILE", help="Write the branches: .csv.")
@plot_option("the root locus")
def locus(linear: Linearisation, out: str | None, plot: str | None) -> None:
    """Follow the poles of the closed loop over its gain, and print where they cross the axis.

    The loop is closed by input = gain*(reference - output), with gains from 0 on; --gain
    multiplies them.
    """
    check_target(out, (".csv",))
    check_target(plot, PICTURES)
    found = root_locus(linear)
    print_tables([_crossing_table(linear, found)])
    if out is not None:
        _write(found, Path(out))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.pole_charts import plot_locus

        title = f"root locus, {linear.outputs[0]} by {linear.inputs[0]}"
        plot_locus(found, factors(linear), title, Path(plot))
    print_written(out, plot)


def _crossing_table(linear: Linearisation, found: Locus) -> Table:
    unit = gain_unit(linear)
    rows = tuple((f"{each.gain:.6g}", f"{each.omega:.6g}") for each in found.crossings)
    note = "" if rows else "no pole crosses the imaginary axis at any positive gain"
    header = (f"gain {unit}".strip(), "frequency rad/s")
    return Table("crossings of the imaginary axis", header, rows, note)


def _write(found: Locus, path: Path) -> None:
    """Write a line for each gain: the gain, then real and imaginary part of each branch."""
    count = found.poles.shape[1]
    names = [f"{part}{k + 1}" for k in range(count) for part in ("real", "imag")]
    with written_whole(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("gain", *names))
        for gain, row in zip(found.gain.tolist(), found.poles.tolist(), strict=True):
            writer.writerow((gain, *(x for pole in row for x in (pole.real, pole.imag))))
