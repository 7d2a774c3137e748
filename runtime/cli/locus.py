"""Linear models 6: follow the poles of a closed loop over its gain."""

import numpy as np

from bgc.printing.text_tables import Table
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.linear_options import ChannelOptions
from bgc.runtime.cli.options import PICTURE, TABLE
from bgc.runtime.cli.printing import print_tables, print_written, write_rows
from bgc.runtime.linear.feedback import gain_unit
from bgc.runtime.linear.root_loci import Locus, root_locus
from bgc.runtime.linear.zeros import factors


@command()
def locus(
    channel: ChannelOptions,
    out: str | None = option("Write the branches: .csv.", type=TABLE),
    plot: str | None = option("Draw the root locus: .png, .svg or .pdf.", type=PICTURE),
) -> None:
    """Follow the poles of the closed loop over its gain, and print where they cross the axis.

    The loop is closed by input = gain*(reference - output), with gains from 0 on; --gain
    multiplies them.
    """
    linear = channel.linear()
    found = root_locus(linear)
    rows = tuple((f"{each.gain:.6g}", f"{each.omega:.6g}") for each in found.crossings)
    note = "" if rows else "no pole crosses the imaginary axis at any positive gain"
    header = (f"gain {gain_unit(linear)}".strip(), "frequency rad/s")
    print_tables([Table("crossings of the imaginary axis", header, rows, note)])
    if out is not None:
        write_rows(out, _branches(found))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.pole_charts import plot_locus

        title = f"root locus, {linear.outputs[0]} by {linear.inputs[0]}"
        plot_locus(found, factors(linear), title, plot)
    print_written(out, plot)


def _branches(found: Locus) -> list[tuple[object, ...]]:
    """A header, and for each gain the real and the imaginary part of each branch."""
    names = [f"{part}{k + 1}" for k in range(found.poles.shape[1]) for part in ("real", "imag")]
    parts = np.ascontiguousarray(found.poles).view(float)
    return [("gain", *names), *map(tuple, np.column_stack((found.gain, parts)).tolist())]
