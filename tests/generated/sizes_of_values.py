"""Values of flat expressions over many rows at once, with the sizes that rounding acts on.

The size of a value is the sum of the sizes that entered it, each times the slope of what came
after: a value that is off by a small share of its size is rounding, where `a - b` nearly cancels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from curves import curve, is_curve
from flat_expressions import COMPARISONS, Var
from program_tree import Apply, Expr, Num, Time
from scipy.special import erf

Sized = tuple[np.ndarray, np.ndarray]
SHARE = 1e-7  # of a size, the largest error of an argument that slopes near a root have to cover

_SMOOTH: dict[str, tuple[Callable, Callable]] = {  # type: ignore[type-arg]
    "sin": (np.sin, np.cos),
    "cos": (np.cos, np.sin),
    "tanh": (np.tanh, lambda u: 1 - np.tanh(u) ** 2),
    "atan": (np.arctan, lambda u: 1 / (1 + u * u)),
    "exp": (np.exp, np.exp),
    "expm1": (np.expm1, np.exp),
    "asinh": (np.arcsinh, lambda u: 1 / np.sqrt(1 + u * u)),
    "log1p": (np.log1p, lambda u: 1 / (1 + u)),
    "sinh": (np.sinh, np.cosh),
    "cosh": (np.cosh, np.sinh),
    "erf": (erf, lambda u: np.exp(-u * u) * 1.2),
    "abs": (np.abs, lambda u: 1.0),
}
_TESTS = dict(zip(COMPARISONS, (np.less, np.greater, np.less_equal, np.greater_equal), strict=True))


def sized(e: Expr, values: Mapping[Var, Sized], t: np.ndarray) -> Sized:
    """Value and size of an expression in each row; KeyError where a variable has no value."""
    match e:
        case Num(value=value):
            number = np.full_like(t, float(value))
            return number, np.abs(number)
        case Time():
            return t, np.abs(t)
        case Var():
            return values[e]
        case Apply(op="if", args=(condition, a, b)):
            (x, of_x), (y, of_y) = sized(a, values, t), sized(b, values, t)
            return np.where(_holds(condition, values, t), x, y), np.maximum(of_x, of_y)
        case Apply(op="neg", args=(a,)):
            value, size = sized(a, values, t)
            return -value, size
        case Apply(op="^", args=(a, Num(value=n))):
            value, size = sized(a, values, t)
            power = float(n)
            return value**power, np.abs(power * value ** (power - 1)) * size
        case Apply(op=op, args=(Apply(args=xs), Apply(args=ys), u)) if is_curve(op):
            data = [tuple(float(n.value) for n in part) for part in (xs, ys)]  # type: ignore[attr-defined]
            value, size = sized(u, values, t)
            slope = curve(op.replace("interpolate", "slope"), *data, value)
            found = curve(op, *data, value)
            return found, np.abs(slope) * size + np.abs(found)
        case Apply(op=op, args=(a, b)):
            return _of_two(op, sized(a, values, t), sized(b, values, t))
        case Apply(op="sign", args=(a,)):
            value, size = sized(a, values, t)
            doubtful = np.abs(value) <= SHARE * size
            return np.sign(value), np.where(doubtful, 2 / SHARE, 0.0)
        case Apply(op="sqrt", args=(a,)):
            value, size = sized(a, values, t)
            value = np.maximum(value, 0.0)
            slope = 0.5 / np.sqrt(np.maximum(np.maximum(value, SHARE * size), 1e-300))
            return np.sqrt(value), slope * size
        case Apply(op=op, args=(a,)):
            value, size = sized(a, values, t)
            function, slope = _SMOOTH[op]
            # An argument beyond a multiple of pi, say, is off by a share of its size.
            return function(value), np.abs(slope(value)) * size
    raise AssertionError(e)


def _of_two(op: str, a: Sized, b: Sized) -> Sized:
    (x, of_x), (y, of_y) = a, b
    match op:
        case "+":
            return x + y, of_x + of_y
        case "-":
            return x - y, of_x + of_y
        case "*":
            return x * y, np.abs(x) * of_y + np.abs(y) * of_x
        case "/":
            return x / y, of_x / np.abs(y) + np.abs(x) * of_y / (y * y)
        case "min":
            return np.minimum(x, y), np.maximum(of_x, of_y)
        case "max":
            return np.maximum(x, y), np.maximum(of_x, of_y)
    raise AssertionError(op)


def _holds(e: Expr, values: Mapping[Var, Sized], t: np.ndarray) -> np.ndarray:
    assert isinstance(e, Apply)
    left, right = (sized(a, values, t)[0] for a in e.args)
    return np.asarray(_TESTS[e.op](left, right))
