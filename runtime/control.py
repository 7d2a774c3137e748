"""Linear control analysis from Python: the functions behind `bgc bode`, `margins`, `step`, `locus`.

All of them take the `Linearisation` that `model.linearise([input], [output])` returns.

>>> from bgc.runtime import control
>>> loop = model.linearise(["supply.e"], ["angle"])  # doctest: +SKIP
>>> control.margins(control.with_gain(loop, 20.0)).delay  # doctest: +SKIP
"""

from bgc.runtime.linear.bode_plot import plot_bode
from bgc.runtime.linear.feedback import close_loop, with_gain
from bgc.runtime.linear.frequency import Response, frequency_response
from bgc.runtime.linear.locus import Locus, root_locus
from bgc.runtime.linear.loop_charts import plot_nichols, plot_nyquist
from bgc.runtime.linear.margins import Margins, margins
from bgc.runtime.linear.pole_charts import plot_locus, plot_poles
from bgc.runtime.linear.step_chart import plot_time_response
from bgc.runtime.linear.time_response import TimeResponse, impulse_response, step_response
from bgc.runtime.linear.zeros import Factors, factors, transmission_zeros

__all__ = [
    "Factors",
    "Locus",
    "Margins",
    "Response",
    "TimeResponse",
    "close_loop",
    "factors",
    "frequency_response",
    "impulse_response",
    "margins",
    "plot_bode",
    "plot_locus",
    "plot_nichols",
    "plot_nyquist",
    "plot_poles",
    "plot_time_response",
    "root_locus",
    "step_response",
    "transmission_zeros",
    "with_gain",
]
