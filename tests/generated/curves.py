"""Curves through data for `interpolate`, by NumPy and SciPy: values and slopes.

An operator of the tree names its options: `interpolate pchip hold`; `slope pchip hold` is its
derivative. Both take the knots, the values and the argument.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly

METHODS = ("linear", "pchip", "spline")
OUTSIDE = ("hold", "extrapolate")


def is_curve(op: str) -> bool:
    return op.startswith(("interpolate ", "slope "))


@lru_cache(maxsize=1000)
def _pieces(method: str, xs: tuple[float, ...], ys: tuple[float, ...]) -> tuple[PPoly, PPoly]:
    if method == "linear":
        slopes = np.diff(ys) / np.diff(xs)
        made = PPoly(np.array([slopes, ys[:-1]]), np.array(xs))
    else:
        made = (CubicSpline if method == "spline" else PchipInterpolator)(xs, ys)
    return made, made.derivative()


def curve(op: str, xs: tuple[float, ...], ys: tuple[float, ...], u: np.ndarray) -> np.ndarray:
    """The value or slope of a curve; beyond its ends it is held, or goes on straight."""
    what, method, outside = op.split()
    value, slope = _pieces(method, xs, ys)
    inside = np.clip(u, xs[0], xs[-1])
    beyond = u - inside
    going = slope(inside)  # where a straight piece ends at a knot, that of the one behind it
    if what == "slope":
        return np.where((beyond != 0) & (outside == "hold"), 0.0, going)
    if outside == "hold":
        return value(inside)
    return value(inside) + beyond * going


def function(op: str) -> Callable[..., float]:
    """A function of floats, for compiled rows."""
    return lambda xs, ys, u: float(curve(op, xs, ys, u))


OPERATORS = [
    f"{what} {m} {o}" for what in ("interpolate", "slope") for m in METHODS for o in OUTSIDE
]
