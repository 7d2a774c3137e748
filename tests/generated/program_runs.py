"""Run programs, and compare the tables of two runs."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np
from program_text import write
from program_tree import Program

import bgc

RTOL = 1e-9
CLOSE = 1e-5  # of the largest value of a column, or of a hundredth of its size in the program
END = re.compile(r"at t = (\S+) s\b")  # in the message of a run that ended with a status
ACCOUNTS = ("energy.stored", "energy.supplied", "energy.dissipated")
Columns = dict[str, np.ndarray]


class Refused(Exception):
    """A diagnostic of the compiler or of the run; the text is its code.

    `end` is the time at which a run ended, s; None where there was no run.
    """

    def __init__(self, codes: str, end: float | None = None) -> None:
        super().__init__(codes)
        self.end = end


def run_text(
    text: str,
    place: Path,
    *,
    rtol: float = RTOL,
    solver: str | None = None,
    parameters: Mapping[str, float] | None = None,
    whole: bool = False,
) -> Columns:
    """Compile a program and run its scene; the model of the text before is kept."""
    try:
        model = _compiled(text, place / "program.bg", whole)
        result = model.simulate(rtol=rtol, solver=solver, parameters=parameters, error=False)
    except bgc.BgError as err:
        found = [END.search(d.message) for d in err.diagnostics]
        ends = [float(at[1]) for at in found if at is not None]
        codes = ",".join(sorted({d.code for d in err.diagnostics}))
        raise Refused(codes, ends[0] if ends else None) from err
    return {name.removesuffix("[1]"): np.asarray(column) for name, column in result.columns.items()}


@lru_cache(maxsize=1)  # a program runs at several tolerances one after the other
def _compiled(text: str, path: Path, whole: bool) -> bgc.Model:
    path.write_text(text, encoding="utf-8")
    return bgc.compile(path, preview=True, whole=whole)


def difference(
    a: Columns, b: Columns, scales: Mapping[str, float], *, first: int = 0
) -> tuple[float, str]:
    """The largest difference from a row on, relative to the size of its column, and the column."""
    worst, where = 0.0, ""
    for name in sorted(set(a) & set(b) & set(scales)):
        size = np.abs(a[name]).max() + 1e-2 * scales[name]
        error = float(np.abs(a[name] - b[name])[first:].max())
        error /= size or (error or 1.0)  # a column of zeros
        if not error <= worst:
            worst, where = error, name
    return worst, where


def first_difference(a: Columns, b: Columns, scales: Mapping[str, float], close: float) -> int:
    """The first row in which a column differs by more than `close` of its size."""
    rows = []
    for name in set(a) & set(b) & set(scales):
        size = np.abs(a[name]).max() + 1e-2 * scales[name]
        rows += list(np.flatnonzero(~(np.abs(a[name] - b[name]) <= close * size))[:1])
    return int(min(rows)) if rows else -1


def scales_of(program: Program) -> dict[str, float]:
    """The sizes of the columns; energies are those of a second in the least powerful domain."""
    return {o.name: o.scale for o in program.scene.observed} | dict.fromkeys(ACCOUNTS, 1.0)


def scales_of_columns(columns: Columns) -> dict[str, float]:
    """The sizes of columns of unknown scale: what they reach, or a little of what others reach.

    Accounts count from the start: without sources and resistors they are errors of integration.
    """
    sizes = {name: float(np.abs(column).max(initial=0.0)) for name, column in columns.items()}
    most = max(sizes.values(), default=0.0)
    least = 1e-6 * most or 1.0
    return {
        name: max(size, 1e-2 * most if name in ACCOUNTS else least) for name, size in sizes.items()
    }


def first_row(program: Program) -> int:
    """The first row to compare with the reference.

    States that start at 0 start at the kink of many laws, and what depends on the slope of such a
    law (reactions of dependent storage) has two values there.
    """
    return int(any(word in write(program) for word in (" if ", "(if", "abs(", "min(", "max(")))
