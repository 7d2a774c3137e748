"""The reason for which a run ends with a status: a coefficient of an unknown that vanishes.

Where the modulus of a transformer or gyrator passes zero, the equations divide by it and their
solution has a pole, or the number of their states changes. No integrator has a way past it.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np
from flat_expressions import Var, derivative, variables
from program_tree import Num, Program, Time
from raw_equations import Raw
from sizes_of_values import Sized, sized

BEFORE = 0.999  # of the time of the end: the run that is compared with its equations
VANISHED = 1e-3  # of the largest value of a coefficient before the end
POINTS, DEGREE = 6, 3  # of the polynomial that goes on to the end


def cut_before(program: Program, end: float) -> Program:
    """The program with a run that stops short of the time of its end, s."""
    return program.with_scene(duration=Fraction(f"{BEFORE * end:.9g}"))


def vanishing(raw: Raw, columns: Mapping[str, np.ndarray], end: float) -> str:
    """The row in which the coefficient of an unknown is zero at the end; empty where none is.

    `columns` are those of the run that was cut before `end`, at equal intervals.
    """
    times = np.linspace(0.0, BEFORE * end, len(columns["energy.stored"]))
    values: dict[Var, Sized] = {
        e: (columns[name], np.abs(columns[name]))
        for name, e, _ in raw.observed
        if isinstance(e, Var)
    }
    for name, row in zip(raw.row_names, raw.rows, strict=True):
        for unknown in variables(row):
            if not (isinstance(unknown, Var) and unknown.kind == "z"):
                continue
            slope = derivative(row, unknown)
            needed = variables(slope)
            if not needed or unknown in needed or isinstance(slope, Num):
                continue
            if all(isinstance(v, Time) or v in values for v in needed):
                with np.errstate(all="ignore"):
                    slopes, _ = sized(slope, values, times)
                if _is_zero_at(times, slopes, end):
                    return name
    return ""


def _is_zero_at(times: np.ndarray, slopes: np.ndarray, end: float) -> bool:
    """Return whether a smooth curve, which is not zero before, reaches zero at a time."""
    size, last = np.abs(slopes).max(), slopes[-POINTS:]
    if not np.isfinite(slopes).all() or not np.abs(last).min() > 0:
        return False
    t = times[-POINTS:] - end
    there = np.polynomial.Polynomial.fit(t, last, DEGREE)(0.0)
    return bool(abs(there) <= VANISHED * size and abs(last[0]) > 2 * VANISHED * size)
