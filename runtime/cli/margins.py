"""`bgc margins`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.runtime.cli.linear_options import PICTURES, channel_command, range_options
from bgc.runtime.cli.options import check_target
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.margins import loop_response
from bgc.runtime.linear.margins import margins as margins_of
from bgc.runtime.linear.state_space import Linearisation


@click.command()
@channel_command(closable=False)
@range_options
@click.option("--nyquist", metavar="FILE", help="Draw the Nyquist curve: .png, .svg or .pdf.")
@click.option("--nichols", metavar="FILE", help="Draw the Nichols chart: .png, .svg or .pdf.")
def margins(
    linear: Linearisation,
    low: float | None,
    high: float | None,
    nyquist: str | None,
    nichols: str | None,
) -> None:
    """Print the stability margins of a loop around an input and an output of a scene of FILE.

    The loop is closed by input = gain*(reference - output). The table has all crossovers with
    their margins, the delay margin, the least distance of the curve from -1, and the verdict.
    Without --from and --to the range reaches all crossovers.
    """
    check_target(nyquist, PICTURES)
    check_target(nichols, PICTURES)
    response = loop_response(linear, low, high)
    print_tables(margins_of(linear, response).tables())
    if nyquist is None and nichols is None:
        return
    # Loads matplotlib.
    from bgc.runtime.linear.loop_charts import plot_nichols, plot_nyquist

    if nyquist is not None:
        plot_nyquist(response, Path(nyquist))
    if nichols is not None:
        plot_nichols(response, Path(nichols))
    print_written(nyquist, nichols)
