"""Linear models 5: compute and draw a step response of the linear model."""

import math

from bgc.diagnostics.catalogue.analysis import bad_duration
from bgc.printing.text_tables import Table
from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.linear_options import Closed, Gain, LinearOptions, require_one
from bgc.runtime.cli.options import PICTURE, SECONDS, Input, Outputs
from bgc.runtime.cli.printing import print_tables, print_written, save
from bgc.runtime.linear.time_response import TimeResponse, impulse_response, step_response


@command()
def step(
    model: LinearOptions,
    input_: Input,
    outputs: Outputs,
    gain: Gain,
    closed: Closed,
    impulse: bool = option("Take a unit impulse instead of a unit step."),
    time: float | None = option('Duration: "2 s"; by default from the modes.', type=SECONDS),
    out: str | None = option(
        "Write the response: .csv, or - for standard output.", type=Target(".csv", "-")
    ),
    plot: str | None = option("Draw the response: .png, .svg or .pdf.", type=PICTURE),
) -> None:
    """Compute the response of the linear model of a scene of FILE to a unit step of an input.

    The scene is linearised at the initial state, at a time (--at) or in equilibrium (--steady);
    outputs are deviations from there. With --closed the step is that of the reference.
    """
    require(time is None or time > 0, bad_duration(time or 0.0))
    linear = model.linear([input_], outputs, gain, closed)
    require_one("input", input_, linear.inputs)
    response = (impulse_response if impulse else step_response)(linear, time)
    title = f"unit {'impulse' if impulse else 'step'} of {response.input}"
    if out != "-":
        print_tables([_facts_table(response, title, impulse)])
    save(response, out)
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.linear.response_charts import plot_time_response

        plot_time_response(response, title, plot)
    print_written(out, plot)


def _facts_table(response: TimeResponse, title: str, impulse: bool) -> Table:
    """Tabulate steady value, rise, settling and overshoot of each output."""
    rows = []
    for k, name in enumerate(response.outputs):
        facts = None if impulse else response.facts(k)
        steady = float(response.steady[k])
        shown = f"{steady:.6g}" if math.isfinite(steady) else "none"
        cells = ("", "", "", "") if facts is None else (
            f"{facts.rise:.4g}", f"{facts.settling:.4g}", f"{100 * facts.overshoot:.4g}",
            f"{facts.peak_time:.4g}" if facts.overshoot else "",
        )  # fmt: skip
        rows.append((name, response.units[k], f"{response.value[-1, k]:.6g}", shown, *cells))
    header = (
        "output", "unit", f"at {response.time[-1]:g} s", "steady", "rise s", "settling s",
        "overshoot %", "peak at s",
    )  # fmt: skip
    return Table(title, header, tuple(rows))
