"""A loop closed around a linear model: a gain, and unit negative feedback."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bgc.diagnostics.catalogue.analysis import no_loop, out_of_range
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.linear.state_space import Linearisation
from bgc.values.units import DIMENSIONLESS, divide, parse_unit, si_symbol

REFERENCE = "reference"
_LARGEST_ENTRY = 1e100  # of an entry: a product of three is finite


def with_gain(linear: Linearisation, gain: float) -> Linearisation:
    """Put a gain before the only input, in SI units of the input for one of the output.

    The new input is the deviation that a controller receives, with the unit of the output.
    """
    units = {**linear.units, linear.inputs[0]: linear.units[linear.outputs[0]]}
    return _in_range(replace(linear, B=gain * linear.B, D=gain * linear.D, units=units))


def close_loop(linear: Linearisation, gain: float = 1.0) -> Linearisation:
    """Close `u = gain*(reference - y)` around a model with as many inputs as outputs.

    `gain` is in SI units of the input for one SI unit of the output; the rest, and BG795, is as
    in `bgc.control.close_loop`.
    """
    loop = gain * linear.D
    around = np.eye(len(loop)) + loop
    weight = 1.0 + float(np.abs(loop).max())
    if np.linalg.svd(around, compute_uv=False)[-1] <= 1e-14 * weight:
        raise BgError([no_loop(gain, linear.inputs[0], linear.outputs[0])])
    inner = gain * np.linalg.inv(around)  # u = inner*(reference - C x)
    single = len(linear.outputs) == 1
    names = tuple(REFERENCE if single else f"{REFERENCE} {name}" for name in linear.outputs)
    units = [linear.units[name] for name in linear.outputs]
    closed = replace(
        linear,
        A=linear.A - linear.B @ inner @ linear.C,
        B=linear.B @ inner,
        C=linear.C - linear.D @ inner @ linear.C,
        D=linear.D @ inner,
        inputs=names,
        units={**linear.units, **dict(zip(names, units, strict=True))},
    )
    return _in_range(closed)


def _in_range(linear: Linearisation) -> Linearisation:
    """Refuse matrices whose products leave the range of double precision (BG798)."""
    for matrix in (linear.A, linear.B, linear.C, linear.D):
        size = np.abs(matrix).max(initial=0.0)
        if not size <= _LARGEST_ENTRY or 0 < size < 1 / _LARGEST_ENTRY:
            raise BgError([out_of_range(linear.outputs[0])])
    return linear


def gain_unit(linear: Linearisation) -> str:
    """The SI unit of a gain from the output to the input, as `parse_unit` reads it."""
    units = (parse_unit(linear.units[name]) for name in (linear.inputs[0], linear.outputs[0]))
    above, below = (unit.dimension if unit else DIMENSIONLESS for unit in units)
    return si_symbol(divide(above, below))
