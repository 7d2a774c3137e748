"""Estimated errors of the columns of a run, and where an estimate cannot be relied on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from bgc.diagnostics.catalogue import listed
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import RunColumns

NOT_ASKED: Final = "not estimated: it was not asked for"
"""Why a result has no errors of which nobody asked."""

_FOLLOWED = "local errors, carried along by the linearised equations"
_LOST = 0.5  # of a column's size: a larger error at half of the rows is no figure


def judged(
    columns: Mapping[str, Array], errors: Mapping[str, Array], doubtful: bool
) -> tuple[dict[str, Array], str]:
    """Judge the estimated errors of columns; return them, and in words how they were made.

    `doubtful` ones have met steps or events at which they were too large for linearised equations.

    Those that could not be followed through a step, and those that are as large as the values at
    half of the rows, are NaN: in the second case the run has not begun to converge, or is chaotic.
    """
    kept, lost, unfollowed = dict(errors), [], []
    for name, error in errors.items():
        if len(error) > 1 and not np.isfinite(error[1:]).any():
            unfollowed.append(name)
        elif _is_lost(columns[name], error):
            kept[name] = np.full_like(error, np.nan)
            lost.append(name)
        elif np.isnan(error).any():
            unfollowed.append(name)
    made = _FOLLOWED + "; uncertain: some were too large for linearised equations" * doubtful
    if lost:
        made += f"; unknown where they are as large as the values: {listed(lost)}"
    if unfollowed:
        made += f"; unknown where they could not be followed: {listed(unfollowed)}"
    return kept, made


def largest_between(errors: Array, between: int) -> Array:
    """The largest errors, (n, columns), since the row before, where every so many is a row."""
    if between == 1 or not len(errors):
        return errors
    starts = np.concatenate(([0], np.arange(1, len(errors), between)))
    return np.maximum.reduceat(errors, starts)[: -(-len(errors) // between)]


def unknown(columns: Mapping[str, Array]) -> dict[str, Array]:
    """Give NaN as the errors of columns whose errors are not known."""
    return {name: np.full(len(column), np.nan) for name, column in columns.items()}


def why_unknown(estimate: str) -> str:
    """The part of `Result.error_estimate` that says which errors are NaN or uncertain, and why."""
    made, _, reason = estimate.partition("; ")
    return reason if made == _FOLLOWED else made


def largest_error(result: RunColumns, name: str) -> str:
    """The largest error of a column in the unit shown, to one digit, as it is known no better.

    `unknown` where it is, and nothing for a column without errors.
    """
    if name not in result.errors:
        return ""
    largest = float(np.max(result.errors[name], initial=0.0)) / result.shown_in(name).factor
    return "0" if largest == 0.0 else f"{largest:.0e}" if np.isfinite(largest) else "unknown"


def _is_lost(column: Array, error: Array) -> bool:
    """Return whether an error is as large as the values of its column at half of the rows."""
    if len(error) < 2:
        return False
    size = float(np.maximum(column, 0.0).max() - np.minimum(column, 0.0).min())
    known = error[1:][np.isfinite(error[1:])]  # the start is exact
    middle = float(np.median(known)) if len(known) else np.inf
    return middle >= _LOST * size and middle != 0.0
