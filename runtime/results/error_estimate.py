"""Estimated errors of the columns of a run, and where an estimate cannot be relied on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bgc.diagnostics.catalogue import listed
from bgc.runtime.results.arrays import Array

_FOLLOWED = "local errors, carried along by the linearised equations"
_LOST = 0.5  # of a column's size: a larger error at half of the rows is no figure


def judged(
    columns: Mapping[str, Array], errors: Mapping[str, Array]
) -> tuple[dict[str, Array], str]:
    """Judge the estimated errors of columns; return them, and in words how they were made.

    Those that cannot be followed, and those that are as large as the values at half of the rows,
    become NaN: such a run has not begun to converge, or is chaotic.
    """
    kept = {name: _figure(columns[name], error) for name, error in errors.items()}
    withheld = [name for name, error in kept.items() if np.isnan(error).all() and len(error)]
    lost = f"; withheld where they are as large as the values: {listed(withheld)}"
    return kept, _FOLLOWED + (lost if withheld else "")


def _figure(column: Array, error: Array) -> Array:
    if len(error) < 2:
        return error
    size = float(np.maximum(column, 0.0).max() - np.minimum(column, 0.0).min())
    middle = np.median(error[1:])  # the start is exact
    return error if middle < _LOST * size or middle == 0.0 else np.full_like(error, np.nan)
