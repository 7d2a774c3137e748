"""Warnings of rows with values that are infinite or undefined, of a run or an instance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from bgc.diagnostics.catalogue.accuracy import value_not_finite
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.runtime.results.arrays import Array


def not_finite(time: Array, columns: Mapping[str, Array]) -> Iterator[Diagnostic]:
    """Warn of the column that is the first to have a value that is not finite (BG712)."""
    worst: tuple[int, str, bool] | None = None
    for name, column in columns.items():
        finite = np.isfinite(column)
        row = int(np.argmin(finite)) if len(finite) else 0  # the first that is not
        if not finite.all() and (worst is None or row < worst[0]):
            worst = row, name, not finite[row:].any()
    if worst is not None:
        row, name, to_the_end = worst
        yield value_not_finite(name, float(time[row]), to_the_end)
