"""Decide whether raw equations have a single solution near random points, without solving.

The equations 0 = F(x, z, t), x' = S z are linearised at a point. If the matrix pencil

    [ F_z  F_x ]
    [  S   -sI ]

is singular for a random s, they have no solution or infinitely many near that point (Kronecker;
Gantmacher 1959, chapter XII), whatever their index. A pencil that is regular proves nothing about
other points. Nothing is integrated, so that stiff programs and poles in time do no harm.
"""

from __future__ import annotations

import numpy as np
from dense_rows import equilibrated
from flat_expressions import Var, compiled, derivative, variables
from raw_equations import Raw

_ROUNDING = 1e-14  # beside the largest singular value, of an equilibrated matrix
_SHIFT = 1.7
_SIZES = (1.0, 1.0, 1e-3, 1e-3)  # of the points


def is_singular(raw: Raw) -> bool:
    """Return whether the pencil is singular at each random point where it has a value."""
    nx, nz, rows = len(raw.x_names), len(raw.z_names), len(raw.rows)
    if rows != nz:
        return True
    places = [(i, v) for i, row in enumerate(raw.rows) for v in variables(row)]
    places = [(i, v) for i, v in places if isinstance(v, Var)]
    slopes = compiled("x, z, t", [derivative(raw.rows[i], v) for i, v in places])
    rng = np.random.default_rng(3)
    found = []
    for size in _SIZES:
        x, z = (size * rng.uniform(0.2, 1.5, n) * rng.choice([-1, 1], n) for n in (nx, nz))
        for k, guess in raw.guesses.items():
            z[k] = guess or z[k]
        with np.errstate(all="ignore"):
            try:
                values = slopes(x.tolist(), z.tolist(), 0.37)
            except (OverflowError, ZeroDivisionError, ValueError):
                continue
        table = np.zeros((rows + nx, nz + nx))
        for (i, v), value in zip(places, values, strict=True):
            table[i, v.index if v.kind == "z" else nz + v.index] += value
        for k, var in enumerate(raw.rate):
            table[rows + k, var.index] = 1
            table[rows + k, nz + k] = -_SHIFT
        if np.isfinite(table).all():
            left, right = equilibrated(table)
            sizes = np.linalg.svd(left[:, None] * table * right, compute_uv=False)
            found.append(sizes[-1] <= _ROUNDING * sizes[0])
    return bool(found) and all(found)
