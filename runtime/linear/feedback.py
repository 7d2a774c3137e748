"""A loop closed around a linear model: a gain, and unit negative feedback."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bgc.diagnostics.catalogue.analysis import no_loop, out_of_range
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.linear.state_space import Linearisation
from bgc.values.units import DIMENSIONLESS, divide, parse_unit, si_symbol

REFERENCE = "reference"
_LARGEST = 1e100  # of an entry: a product of three is finite


def with_gain(linear: Linearisation, gain: float) -> Linearisation:
    """Put a gain before the only input, in SI units of the input for one of the output.

    The new input is the deviation that a controller receives, with the unit of the output.
    """
    units = {**linear.units, linear.inputs[0]: linear.units[linear.outputs[0]]}
    return _in_range(replace(linear, B=gain * linear.B, D=gain * linear.D, units=units))


def close_loop(linear: Linearisation, gain: float = 1.0) -> Linearisation:
    """Close `u = gain*(reference - y)` around a model with one input and one output.

    Parameters
    ----------
    linear
        The open loop, `y = G(s) u`.
    gain
        In SI units of the input for one SI unit of the output.

    Returns
    -------
    Linearisation
        `y = gain*G/(1 + gain*G) reference`, with the states of the open loop; the reference has
        the unit of the output.

    Raises
    ------
    BgError
        BG795 if the output answers the input at once by exactly -1/gain, so that no input solves
        the loop.
    """
    direct = float(linear.D[0, 0])
    around = 1.0 + gain * direct
    if abs(around) <= 1e-14 * (1.0 + abs(gain * direct)):
        raise BgError([no_loop(gain, linear.inputs[0], linear.outputs[0])])
    inner = gain / around
    units = {**linear.units, REFERENCE: linear.units[linear.outputs[0]]}
    closed = replace(
        linear,
        A=linear.A - inner * linear.B @ linear.C,
        B=inner * linear.B,
        C=linear.C / around,
        D=np.array([[inner * direct]]),
        inputs=(REFERENCE,),
        units=units,
    )
    return _in_range(closed)


def _in_range(linear: Linearisation) -> Linearisation:
    """Refuse matrices whose products leave the range of double precision (BG798)."""
    for matrix in (linear.A, linear.B, linear.C, linear.D):
        size = np.abs(matrix).max(initial=0.0)
        if not size <= _LARGEST or 0 < size < 1 / _LARGEST:
            raise BgError([out_of_range(linear.outputs[0])])
    return linear


def gain_unit(linear: Linearisation) -> str:
    """The SI unit of a gain from the output to the input, as `parse_unit` reads it."""
    units = (parse_unit(linear.units[name]) for name in (linear.inputs[0], linear.outputs[0]))
    above, below = (unit.dimension if unit else DIMENSIONLESS for unit in units)
    return si_symbol(divide(above, below))
