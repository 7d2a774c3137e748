"""Linear models 2: print and draw poles and zeros."""

import numpy as np

from bgc.printing.text_tables import Table
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.linear_options import ChannelOptions, Closed
from bgc.runtime.cli.options import PICTURE
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.state_space import modes_of
from bgc.runtime.linear.zeros import factors
from bgc.runtime.results.arrays import Complex
from bgc.values.units import quotient_unit


@command()
def poles(
    channel: ChannelOptions,
    closed: Closed,
    plot: str | None = option("Draw poles and zeros: .png, .svg or .pdf.", type=PICTURE),
) -> None:
    """Print poles, zeros and static gain of an output of a scene of FILE by an input.

    Poles that the input does not excite or the output does not show appear as zeros, too. The
    zeros are compared with the frequency response, and a note says where they do not agree.
    """
    linear = channel.linear(closed)
    (input_,), (output,) = linear.inputs, linear.outputs
    found, title = factors(linear), f"{output} by {input_}"
    at_rest = float(linear.response(np.zeros(1))[0, 0, 0].real)
    static = f"{at_rest:.6g}" if np.isfinite(at_rest) else "infinite"
    unit = quotient_unit(linear.units[output], linear.units[input_])
    note = "" if found.accurate else (
        "the zeros do not reproduce the frequency response: they are too sensitive for double "
        "precision"
    )  # fmt: skip
    header = ("1/s", "natural frequency rad/s", "damping")
    print_tables(
        [
            Table(f"{title}: poles", header, _rows(found.poles)),
            Table(f"{title}: zeros", header, _rows(found.zeros)),
            Table("static gain", (), ((static, unit),), note),
        ]
    )
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.pole_charts import plot_poles

        plot_poles(found.poles, found.zeros, title, plot)
    print_written(plot)


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
