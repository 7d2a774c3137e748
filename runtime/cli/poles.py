"""`bgc poles`."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from bgc.printing.tables import Table
from bgc.runtime.cli.linear_options import PICTURES, channel_command, plot_option
from bgc.runtime.cli.options import check_target
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.state_space import Linearisation, modes_of
from bgc.runtime.linear.zeros import Factors, factors
from bgc.runtime.results.arrays import Complex
from bgc.values.units import quotient_unit


@click.command()
@channel_command(closable=True)
@plot_option("poles and zeros")
def poles(linear: Linearisation, plot: str | None) -> None:
    """Print poles, zeros and static gain of an output of a scene of FILE by an input.

    Poles that the input does not excite or the output does not show appear as zeros, too. The
    zeros are compared with the frequency response, and a note says where they do not agree.
    """
    check_target(plot, PICTURES)
    found = factors(linear)
    title = f"{linear.outputs[0]} by {linear.inputs[0]}"
    print_tables(_tables(linear, found, title))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.pole_charts import plot_poles

        plot_poles(found.poles, found.zeros, title, Path(plot))
    print_written(plot)


def _tables(linear: Linearisation, found: Factors, title: str) -> list[Table]:
    header = ("1/s", "natural frequency rad/s", "damping")
    tables = [
        Table(f"{title}: {name}", header, rows)
        for name, rows in (("poles", _rows(found.poles)), ("zeros", _rows(found.zeros)))
    ]
    unit = quotient_unit(linear.units[linear.outputs[0]], linear.units[linear.inputs[0]])
    at_rest = float(linear.response(np.zeros(1))[0, 0, 0].real)
    static = f"{at_rest:.6g}" if np.isfinite(at_rest) else "infinite"
    note = "" if found.accurate else (
        "the zeros do not reproduce the frequency response: they are too sensitive for double "
        "precision"
    )  # fmt: skip
    tables.append(Table("static gain", (), ((static, unit),), note))
    return tables


def _rows(values: Complex) -> tuple[tuple[str, str, str], ...]:
    """One row for each real value and each conjugate pair, by rising magnitude."""
    zero = 1e-12 * float(np.abs(values).max(initial=0.0))
    rows = []
    for mode in modes_of(values):
        value = mode.eigenvalue
        real = value.real if abs(value.real) > zero else 0.0
        if value.imag <= zero:
            rows.append((f"{real:.6g}", "", ""))
        else:
            pair = f"{real:.6g} +- {value.imag:.6g}i"
            rows.append((pair, f"{abs(value):.6g}", f"{-real / abs(value):.6g}"))
    return tuple(rows)
