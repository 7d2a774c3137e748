"""Linear models 3: compute and draw frequency responses."""

from itertools import product

import numpy as np

from bgc.diagnostics.diagnostic import BgError
from bgc.printing.text_tables import Table
from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.linear_options import (
    Closed,
    Gain,
    High,
    LinearOptions,
    Low,
)
from bgc.runtime.cli.options import PICTURE, Inputs, Outputs
from bgc.runtime.cli.printing import print_tables, print_written, write_rows
from bgc.runtime.linear.frequency import HEADER, Response, frequency_response
from bgc.runtime.linear.state_space import Linearisation


@command()
def bode(
    model: LinearOptions,
    inputs: Inputs,
    outputs: Outputs,
    gain: Gain,
    closed: Closed,
    low: Low,
    high: High,
    out: str | None = option(
        "Write the response: .csv, or - for standard output.", type=Target(".csv", "-")
    ),
    plot: str | None = option("Draw magnitude and phase: .png, .svg or .pdf.", type=PICTURE),
) -> None:
    """Compute the frequency response of an output of a scene of FILE to an input.

    The scene is linearised at the initial state, at a time (--at) or in equilibrium (--steady).
    The input is the effort or flow of a source (supply.e), a parameter (mass) or a channel of a
    device. Several inputs and outputs, and vectors, give a curve for each pair.
    """
    require(inputs and outputs, "give an --input and an --output")
    responses = _responses(model.linear(inputs, outputs, gain, closed), low, high)
    if out is not None:
        write_rows(out, _rows(responses))
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.response_charts import plot_bode

        plot_bode(responses, plot)
    if out != "-":
        print_tables(map(_summary, responses))
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


def _rows(responses: list[Response]) -> list[tuple[object, ...]]:
    """One response, or several with the names of output and input before each line."""
    if len(responses) == 1:
        return [HEADER, *map(tuple, responses[0].rows().tolist())]
    rows = [(r.output, r.input, *row) for r in responses for row in r.rows().tolist()]
    return [("output", "input", *HEADER), *rows]


def _summary(response: Response) -> Table:
    """Tabulate a line for each decade, for the peak, and for each crossover with its margin."""
    rows = response.rows()
    exponents = np.log10(response.omega)
    decades = np.arange(np.ceil(exponents[0] - 1e-9), exponents[-1] + 1e-9)
    nearest = [int(np.argmin(np.abs(exponents - decade))) for decade in decades]
    lines = {float(response.omega[k]): (*map(_digits, rows[k, :3]), "") for k in nearest}
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
