"""Motions that are linear in each of two modes, by matrix exponentials: no step, no tolerance."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm
from scipy.optimize import brentq

Floats = npt.NDArray[np.float64]


def motion(
    matrices: Mapping[bool, Floats],
    edge: Floats,
    start: Sequence[float],
    times: Floats,
    scan: float,
    inside: bool,
) -> Floats:
    """y at rising times of y' = A y, where A is `matrices[edge @ y > 0]`.

    `scan` is shorter than any stay in a mode; the first is `inside`, where `edge @ y > 0`, or not.
    """
    rows: list[Floats] = []
    stays = _stays(matrices, edge, np.array(start, dtype=float), float(times[-1]), scan, inside)
    for (begin, y, matrix), (end, _, _) in itertools.pairwise(stays):
        here = [t for t in times[len(rows) :] if t <= end]
        rows += list(expm(np.multiply.outer(np.subtract(here, begin), matrix)) @ y)
    return np.array(rows)


def _stays(
    matrices: Mapping[bool, Floats],
    edge: Floats,
    y: Floats,
    end: float,
    scan: float,
    inside: bool,
) -> Iterator[tuple[float, Floats, Floats]]:
    """Begin, state there and matrix of each stay in a mode; one more begins after the end."""
    t = 0.0
    while t <= end:
        matrix = matrices[inside]
        yield t, y, matrix
        leaves = t + _time_to_leave(matrix, edge, y, inside, end, scan)
        y = expm(matrix * (leaves - t)) @ y
        t, inside = leaves, not inside
    yield t, y, matrices[inside]


def _time_to_leave(
    matrix: Floats, edge: Floats, y: Floats, inside: bool, end: float, scan: float
) -> float:
    """Time until `edge @ y` has the other sign; beyond the end if it keeps it."""

    def over(t: float) -> float:
        return float(edge @ expm(matrix * t) @ y)

    step, ahead = expm(matrix * scan), y
    for k in range(int(2 * end / scan)):
        ahead = step @ ahead
        if k > 0 and (edge @ ahead > 0) != inside:
            low = k * scan if (over(k * scan) > 0) == inside else 1e-6 * scan
            return float(brentq(over, low, (k + 1) * scan, xtol=1e-16))
    return 2 * end
