"""Linear models 4: print stability margins, draw Nyquist and Nichols charts."""

from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.linear_options import ChannelOptions, High, Low
from bgc.runtime.cli.options import PICTURE
from bgc.runtime.cli.printing import print_tables, print_written
from bgc.runtime.linear.stability_margins import loop_response
from bgc.runtime.linear.stability_margins import margins as margins_of


@command()
def margins(
    channel: ChannelOptions,
    low: Low,
    high: High,
    nyquist: str | None = option("Draw the Nyquist curve: .png, .svg or .pdf.", type=PICTURE),
    nichols: str | None = option("Draw the Nichols chart: .png, .svg or .pdf.", type=PICTURE),
) -> None:
    """Print the stability margins of a loop around an input and an output of a scene of FILE.

    The loop is closed by input = gain*(reference - output). The table has all crossovers with
    their margins, the delay margin, the least distance of the curve from -1, and the verdict.
    Without --from and --to the range reaches all crossovers.
    """
    linear = channel.linear()
    response = loop_response(linear, low, high)
    print_tables(margins_of(linear, response).tables())
    if nyquist is None and nichols is None:
        return
    # Loads matplotlib.
    from bgc.runtime.linear.loop_charts import plot_nichols, plot_nyquist

    if nyquist is not None:
        plot_nyquist(response, nyquist)
    if nichols is not None:
        plot_nichols(response, nichols)
    print_written(nyquist, nichols)
