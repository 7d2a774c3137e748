"""Linear models 1: print the modes: periods, damping, participating states."""

from pathlib import Path

import numpy as np

from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.linear_options import LinearOptions
from bgc.runtime.cli.options import PICTURE, TABLE
from bgc.runtime.cli.printing import print_tables, print_text, print_written
from bgc.runtime.linear.linear_tables import mode_table, write_modes


@command()
def modes(
    model: LinearOptions,
    full: bool = option("Print all modes, however many."),
    out: str | None = option("Write the modes: .csv.", type=TABLE),
    plot: str | None = option(
        "Draw the eigenvalues in the complex plane: .png, .svg or .pdf.", type=PICTURE
    ),
) -> None:
    """Print the modes of a scene of FILE: period, damping, time constant, participating states.

    The scene is linearised at the initial state, at a time (--at) or in equilibrium (--steady).
    """
    linear = model.linear()
    found = linear.modes()
    print_tables([mode_table(found, full)])
    if not found:
        print_text("no states, and so no modes")
    if out is not None:
        write_modes(found, Path(out))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.pole_charts import plot_poles

        plot_poles(linear.eigenvalues(), np.empty(0, dtype=complex), "eigenvalues", plot)
    print_written(out, plot)
