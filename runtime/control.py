"""Linear control analysis from Python: the functions behind `bgc bode`, `margins`, `step`, `locus`.

All of them take the `Linearisation` that `model.linearise([input], [output])` returns.

>>> from bgc import control
>>> loop = model.linearise(["supply.e"], ["angle"])  # doctest: +SKIP
>>> control.margins(control.with_gain(loop, 20.0)).delay  # doctest: +SKIP
"""

from __future__ import annotations

from bgc.diagnostics.catalogue.analysis import several_channels
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_function
from bgc.runtime.linear import feedback, frequency, root_loci, time_response, zeros
from bgc.runtime.linear import stability_margins as stability
from bgc.runtime.linear.frequency import Response
from bgc.runtime.linear.loop_charts import plot_nichols, plot_nyquist
from bgc.runtime.linear.pole_charts import plot_locus, plot_poles
from bgc.runtime.linear.response_charts import plot_bode, plot_time_response
from bgc.runtime.linear.root_loci import Locus
from bgc.runtime.linear.stability_margins import Margins
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.linear.time_response import TimeResponse
from bgc.runtime.linear.zeros import Factors
from bgc.runtime.results.arrays import Complex
from bgc.runtime.running.arguments import seconds_of
from bgc.runtime.running.quantity import Quantity, in_si

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


@public_function
def frequency_response(
    linear: Linearisation, low: Quantity | None = None, high: Quantity | None = None
) -> Response:
    """Compute the frequency response of a linear model with one input and one output.

    Parameters
    ----------
    linear
        The model; its output is SI for one SI unit of its input.
    low, high
        Ends of the range, rad/s. By default it extends a decade beyond the slowest and the fastest
        mode, and ends where the response has fallen to 1e-9 of its largest value (-180 dB).
        Points are 60 a decade, and more around resonances.

    Raises
    ------
    BgError
        BG085 if the range is empty, BG086 if the response is zero throughout, BG660 for several
        inputs or outputs.

    Examples
    --------
    >>> response = control.frequency_response(loop, 0.1, "50 rad/s")  # doctest: +SKIP
    >>> control.plot_bode([response], "bode.png")  # doctest: +SKIP
    """
    ends = in_si(low, "low", "rad/s"), in_si(high, "high", "rad/s")
    return frequency.frequency_response(_single(linear), *ends)


@public_function
def margins(linear: Linearisation, response: Response | None = None) -> Margins:
    """Compute the stability margins of an open loop under unit negative feedback.

    Parameters
    ----------
    linear
        The open loop, with one input and one output; `with_gain` puts a controller's gain before
        it.
    response
        Its response, in whose range crossovers are found. By default the range is as wide as the
        crossovers need.

    Raises
    ------
    BgError
        BG086 if the output does not respond, BG660 for several inputs or outputs.

    Examples
    --------
    >>> found = control.margins(control.with_gain(loop, 300.0))  # doctest: +SKIP
    >>> found.phase[0].amount, found.phase[0].omega, found.delay  # doctest: +SKIP
    """
    return stability.margins(_single(linear), response)


@public_function
def with_gain(linear: Linearisation, gain: Quantity) -> Linearisation:
    """Put a gain before the only input; the new input is the deviation that a controller receives.

    Parameters
    ----------
    linear
        A model with one input and one output.
    gain
        In SI units of the input for one of the output, or a text, `"300 V*s/rad"`.

    Raises
    ------
    BgError
        BG063 for a wrong unit, BG660 for several inputs or outputs, BG798 where matrices leave the
        range of double precision.
    """
    return feedback.with_gain(_single(linear), _gain(linear, gain))


@public_function
def close_loop(linear: Linearisation, gain: Quantity = 1.0) -> Linearisation:
    """Close `u = gain*(reference - y)` around a model with as many inputs as outputs.

    Parameters
    ----------
    linear
        The open loop, `y = G(s) u`. Output k acts on input k.
    gain
        In SI units of the input for one of the output, or, of a model with one of both, a text,
        `"300 V*s/rad"`.

    Returns
    -------
    Linearisation
        `y = gain*G/(1 + gain*G) reference`, with the states of the open loop; the reference has
        the unit of the output. Of several outputs each has its reference, `reference speed`.

    Raises
    ------
    BgError
        BG795 if the output answers the input at once by exactly -1/gain, so that no input solves
        the loop; those of `with_gain`.
    """
    is_square = len(linear.inputs) == len(linear.outputs) > 1
    if is_square and not isinstance(gain, str):
        return feedback.close_loop(linear, gain)
    return feedback.close_loop(_single(linear), _gain(linear, gain))


@public_function
def step_response(linear: Linearisation, duration: Quantity | None = None) -> TimeResponse:
    """Compute the outputs after a unit step of the only input, SI, from rest.

    Each row follows from the one before by the matrix exponential, so that no step size limits
    the accuracy (C. F. Van Loan, IEEE Trans. Automatic Control 23(3), 1978).

    Parameters
    ----------
    linear
        A model with one input and any number of outputs.
    duration
        End time, s; by default six time constants of the slowest mode.

    Raises
    ------
    BgError
        BG660 for several inputs, BG796 where algebraic equations that cannot be eliminated remain
        in the model, BG798 where values leave the range of double precision.

    Examples
    --------
    >>> response = control.step_response(control.close_loop(loop, 300.0), "50 ms")  # doctest: +SKIP
    >>> response.facts().overshoot  # doctest: +SKIP
    """
    return time_response.step_response(_one_input(linear), seconds_of(duration))


@public_function
def impulse_response(linear: Linearisation, duration: Quantity | None = None) -> TimeResponse:
    """Compute the outputs after a unit impulse of the only input, SI, from rest.

    `linear`, `duration` and errors are those of `step_response`. An impulse in the outputs
    themselves at time 0, by D, has no value in a row and is left out.
    """
    return time_response.impulse_response(_one_input(linear), seconds_of(duration))


@public_function
def root_locus(linear: Linearisation) -> Locus:
    """Follow the poles of the loop that `close_loop` closes, from the open loop's to its zeros.

    `linear` has one input and one output. The gains are positive and extend a thousandfold beyond
    those at which the response has magnitude 1; further ones are inserted where a pole moves far
    from one to the next. Errors are those of `margins`.
    """
    return root_loci.root_locus(_single(linear))


@public_function
def factors(linear: Linearisation) -> Factors:
    """Compute zeros, poles and gain of `linear`, a model with one input and one output.

    Poles are all eigenvalues of the model; those that do not reach the output are zeros, too. The
    gain is that of the product of factors that agrees best with the response. BgError BG660 for
    several inputs or outputs.
    """
    return zeros.factors(_single(linear))


@public_function
def transmission_zeros(linear: Linearisation) -> Complex:
    """Compute the finite transmission zeros of `linear`, 1/s, by rising real part.

    A zero is an s at which `[A - sE, B; C, D]` has less than its normal rank, for any number of
    inputs and outputs. Infinite zeros are removed by orthogonal transformations before eigenvalues
    are computed (A. Emami-Naeini and P. Van Dooren, Automatica 18(4), 1982). A mode that is not
    controllable or not observable is among them, and is a pole too.
    """
    return zeros.transmission_zeros(linear)


def _gain(linear: Linearisation, gain: Quantity) -> float:
    found = in_si(gain, "gain", feedback.gain_unit(_single(linear)))
    return 1.0 if found is None else found


def _single(linear: Linearisation) -> Linearisation:
    """Return a model that has one input and one output; refuse another one (BG660)."""
    if len(linear.outputs) != 1:
        raise BgError([several_channels("output", linear.outputs)])
    return _one_input(linear)


def _one_input(linear: Linearisation) -> Linearisation:
    if len(linear.inputs) != 1:
        raise BgError([several_channels("input", linear.inputs)])
    return linear
