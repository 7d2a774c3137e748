"""Motions that are linear in each of two modes, by matrix exponentials: no step, no tolerance."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence

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
        rows += [expm(matrix * (t - begin)) @ y for t in times[len(rows) :] if t <= end]
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
        leaves = t + _time_to(lambda s, m=matrix, y=y: edge @ expm(m * s) @ y, inside, end, scan)
        y = expm(matrix * (leaves - t)) @ y
        t, inside = leaves, not inside
    yield t, y, matrices[inside]


def _time_to(over: Callable[[float], float], inside: bool, end: float, scan: float) -> float:
    """How long until `over` has the other sign; beyond the end if it keeps it."""
    for k in range(1, int(2 * end / scan)):
        if (over((k + 1) * scan) > 0) != inside:
            low = k * scan if (over(k * scan) > 0) == inside else 1e-6 * scan
            return float(brentq(over, low, (k + 1) * scan, xtol=1e-16))
    return 2 * end
