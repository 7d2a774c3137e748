"""Slopes of a compiled program against differences of its rates.

The slopes in C, which implicit steps use, and those of linear models, evaluated in Python,
come from the same expressions; the differences use the rates in C alone.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from bgc.runtime.model import Model
from bgc.runtime.running.structures import Status

Array = npt.NDArray[np.float64]

PARTS = (1e-4, 1e-5, 1e-6)  # of a state, for a difference
CLOSE = 1e-4


def slope_errors(model: Model, place: float = 0.3, seed: int = 1) -> dict[str, float]:
    """The largest differences of slopes from difference quotients, in parts of a row's largest.

    At the start, moved by a random part `place` of the scales of the states. A row for which two
    lengths of the differences disagree has a kink there and is left out. Empty where none is left.
    """
    instance = model.instance_at(None, 0.0)
    scale, start = instance.scale.copy(), instance.state.copy()
    x = start + place * scale * np.random.default_rng(seed).uniform(-1, 1, len(start))
    if not len(start):
        return {}
    linear = np.asarray(model.linearise(state=x).A)

    def rates(state: Array) -> Array:
        instance.state[:] = state
        status, found = instance.rhs()
        return found.copy() if status is Status.OK else np.full(len(state), np.nan)

    instance.state[:] = x
    status, exact, _ = instance.jacobian()
    found = [_differences(rates, x, part * np.maximum(scale, np.abs(x))) for part in PARTS]
    size = np.abs(exact * scale).max(axis=1, initial=0.0)
    size[size == 0] = 1.0
    smooth = np.abs((found[0] - found[1]) * scale).max(axis=1, initial=0.0) <= CLOSE * size
    smooth |= np.abs((found[1] - found[2]) * scale).max(axis=1, initial=0.0) <= CLOSE * size
    rows = smooth & np.isfinite(found[1]).all(axis=1)
    if status is not Status.OK or not rows.any():
        return {}
    errors = {"C": _distance(found, exact, scale, size, rows)}
    if linear.shape == exact.shape and (instance.mass()[1] == np.eye(len(x))).all():
        errors["linear"] = _distance(found, linear, scale, size, rows)
    return errors


def _distance(
    found: list[Array], slope: Array, scale: Array, size: Array, rows: npt.NDArray[np.bool_]
) -> float:
    """The least over the lengths of the differences of the largest error of each row."""
    each = [np.abs((d - slope) * scale).max(axis=1, initial=0.0) / size for d in found]
    return float(np.nanmin(each, axis=0)[rows].max())


def _differences(rates: Callable[[Array], Array], x: Array, parts: Array) -> Array:
    columns = []
    for k, part in enumerate(parts):
        moved = x.copy()
        moved[k] = x[k] + part
        above = rates(moved)
        moved[k] = x[k] - part
        columns.append((above - rates(moved)) / (2 * part))
    return np.stack(columns, axis=1)
