"""`bgc modes`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from bgc.runtime.cli.linear_options import PICTURES, open_linear, plot_option, scene_options
from bgc.runtime.cli.options import check_target
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.tables import mode_table, write_modes


@click.command()
@scene_options
@click.option("--full", is_flag=True, help="Print all modes, however many.")
@click.option("--out", metavar="FILE", help="Write the modes: .csv.")
@plot_option("the eigenvalues in the complex plane")
def modes(full: bool, out: str | None, plot: str | None, **scene: Any) -> None:
    """Print the modes of a scene of FILE: period, damping, time constant, participating states.

    The scene is linearised at the initial state, at a time (--at) or in equilibrium (--steady).
    """
    check_target(out, (".csv",))
    check_target(plot, PICTURES)
    linear = open_linear(**scene)
    found = linear.modes()
    print_tables([mode_table(found, full)])
    if not found:
        click.echo("no states, and so no modes")
    if out is not None:
        write_modes(found, Path(out))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.pole_charts import plot_poles

        plot_poles(linear.eigenvalues(), np.empty(0, dtype=complex), "eigenvalues", Path(plot))
    print_written(out, plot)
