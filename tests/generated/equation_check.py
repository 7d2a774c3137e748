"""Check that the columns of a run satisfy the raw equations of their program.

Nothing is solved but single equations: every named variable is a column, each other one follows
from a row in which it alone is not known yet, and all rows left over have to hold. That
states move with their rates is checked by Simpson's rule between rows of the table. So the check
works where the reference of `dense_dae.py` gives up, and costs far less.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from flat_expressions import Var, derivative, variables
from program_tree import Expr, Num
from raw_equations import Raw
from sizes_of_values import Sized, sized

FLOOR = 1e-4  # of the largest value of a variable, what its rounding is relative to
LEAST = 1e-2  # in SI, for variables that are zero but for rounding


@dataclass
class Checked:
    """The largest misses of a run, relative to sizes, and the names of rows and states."""

    residual: float = 0.0
    row: str = ""
    rate: float = 0.0
    state: str = ""
    start: float = 0.0
    given: str = ""
    checked: int = 0  # rows that were compared
    unknown: list[str] = field(default_factory=list)  # rows with variables that nothing gave


def check_columns(
    raw: Raw, columns: Mapping[str, np.ndarray], duration: float, *, floor: float = FLOOR
) -> Checked:
    """Compare a table of rows at equal intervals with the equations of the program observed.

    Misses are relative to the terms of a row, with at least `floor` of the largest value that each
    variable reaches in the run.
    """
    count = len(columns["energy.stored"])
    times = np.linspace(0.0, duration, count)
    values: dict[Var, Sized] = {}
    same: list[tuple[str, Expr, np.ndarray]] = []
    for name, e, _ in raw.observed:
        column = np.asarray(columns[name], dtype=float)
        if isinstance(e, Var) and e not in values:
            values[e] = _floored(column, floor)
        else:
            same.append((name, e, column))
    found = Checked()
    instants = _instants(times, raw)
    keep = _between_breaks(times, raw) | instants
    times = np.where(instants, times * (1 + 1e-12), times)  # such a row has the values after it
    with np.errstate(all="ignore"):
        rest = _follow(raw, values, times)
        for name, row in rest:
            if variables(row) - {t for t in variables(row) if not isinstance(t, Var)} <= set(
                values
            ):
                _compare(found, name, *sized(row, values, times), keep)
            else:
                found.unknown.append(name)
        for name, e, column in same:
            if _known(e, values):
                value, size = sized(e, values, times)
                _compare(found, name, value - column, size + np.abs(column), keep)
        _check_rates(found, raw, values, columns, times)
        _check_jumps(found, raw, values, times)
        _check_start(found, raw, values, times)
    return found


def _floored(column: np.ndarray, floor: float) -> Sized:
    largest = float(np.abs(column).max(initial=0.0))
    return column, np.abs(column) + floor * largest + LEAST


def _known(e: Expr, values: Mapping[Var, Sized]) -> bool:
    return all(v in values for v in variables(e) if isinstance(v, Var))


def _follow(raw: Raw, values: dict[Var, Sized], times: np.ndarray) -> list[tuple[str, Expr]]:
    """Solve rows with one unknown that enters linearly; return the rows that were not needed."""
    rest = list(zip(raw.row_names, raw.rows, strict=True))
    unknown = {
        id(row): {v for v in variables(row) if isinstance(v, Var) and v not in values}
        for _, row in rest
    }
    again = True
    while again:
        again, kept = False, []
        for name, row in rest:
            open_ = {v for v in unknown[id(row)] if v not in values}
            unknown[id(row)] = open_
            if len(open_) == 1:
                (var,) = open_
                slope = derivative(row, var)
                if var not in variables(slope) and _solved(row, var, slope, values, times):
                    again = True
                    continue
            kept.append((name, row))
        rest = kept
    return rest


def _solved(row: Expr, var: Var, slope: Expr, values: dict[Var, Sized], times: np.ndarray) -> bool:
    factor, _ = sized(slope, values, times)
    if not (np.abs(factor) > 1e-6 * np.abs(factor).max()).all():
        return False
    values[var] = np.zeros_like(times), np.zeros_like(times)
    constant, size = sized(row, values, times)
    value, size = -constant / factor, np.abs(size / factor)
    values[var] = value, size
    return True


def _instants(times: np.ndarray, raw: Raw) -> np.ndarray:
    """The rows that are at instants of sampled parts."""
    found = np.zeros(len(times), dtype=bool)
    for jump in raw.jumps:
        count = times / jump.period
        found |= np.abs(count - np.round(count)) < 1e-6
    return found


def _between_breaks(times: np.ndarray, raw: Raw) -> np.ndarray:
    """The rows that are at no break of a source, where two values are right."""
    keep = np.ones(len(times), dtype=bool)
    for at in raw.breaks:
        keep &= np.abs(times - at) > 1e-9 * times[-1]
    return keep


def _compare(
    found: Checked, name: str, missed: np.ndarray, size: np.ndarray, keep: np.ndarray
) -> None:
    found.checked += 1
    share = np.abs(missed) / (size + 1e-300)
    share = np.where(missed == 0, 0.0, share)[keep]
    worst = float(share.max(initial=0.0)) if np.isfinite(share).all() else np.inf
    if worst > found.residual:
        found.residual, found.row = worst, name


def _check_rates(
    found: Checked,
    raw: Raw,
    values: Mapping[Var, Sized],
    columns: Mapping[str, np.ndarray],
    times: np.ndarray,
) -> None:
    """Compare changes of states with integrals of their rates, where Simpson's rule is exact."""
    pairs = [
        (raw.x_names[k], values[x], values[rate])
        for k, rate in enumerate(raw.rate)
        if (x := Var("x", k)) in values and rate in values and x not in raw.held
    ]
    for name, powers in (
        ("stored", raw.stored),
        ("supplied", raw.supplied),
        ("dissipated", raw.dissipated),
    ):
        if all(_known(p, values) for p in powers):
            parts = [sized(p, values, times) for p in powers]
            zero = np.zeros_like(times)
            power = sum((v for v, _ in parts), zero), sum((s for _, s in parts), zero)
            column = np.asarray(columns[f"energy.{name}"], dtype=float)
            held = _largest_energy(raw, values, times)
            pairs.append((f"energy.{name}", (column, np.abs(column) + held), power))
    h = float(times[1] - times[0])
    for name, (x, size), (rate, of_rate) in pairs:
        change = x[4:] - x[:-4]
        r = rate
        wide = (r[:-4] + 4 * r[2:-2] + r[4:]) * (4 * h / 6)
        fine = (r[:-4] + 4 * r[1:-3] + 2 * r[2:-2] + 4 * r[3:-1] + r[4:]) * (h / 3)
        doubt = np.abs(fine - wide)
        rounding = size[4:] + size[:-4] + h * of_rate[2:-2]
        missed = np.abs(change - fine)
        # A wrong rate is missed everywhere; a kink or a fast motion only at some rows.
        share = missed / (doubt * 1e5 + rounding + 1e-300)
        share = np.where(missed == 0, 0.0, share)
        worst = float(np.quantile(share, 0.8)) if np.isfinite(share).all() else np.inf
        if worst > found.rate:
            found.rate, found.state = worst, name


def _check_jumps(found: Checked, raw: Raw, values: Mapping[Var, Sized], times: np.ndarray) -> None:
    """Compare held values with what they become at instants, and with the row before elsewhere."""
    held = raw.held
    before = dict(values)
    for var in held & values.keys():
        column, size = values[var]
        start = np.full(1, raw.given[var.index])
        before[var] = np.concatenate([start, column[:-1]]), np.concatenate([start, size[:-1]])
    for jump in raw.jumps:
        due = _instants(times, replace(raw, jumps=[jump]))
        for var, e in jump.values.items():
            if var in values and _known(e, before):
                value, size = sized(e, before, times)
                expected = np.where(due, value, before[var][0])
                missed, size = values[var][0] - expected, size + before[var][1]
                name = f"held {raw.x_names[var.index]}"
                _compare(found, name, missed, size, np.ones(len(times), dtype=bool))


def _largest_energy(raw: Raw, values: Mapping[Var, Sized], times: np.ndarray) -> float:
    """About the largest energy of an element; what is stored counts from the start of the run."""
    found = 0.0
    for storage in raw.storage:
        if storage.var in values and _known(storage.slope, values):
            answer, _ = sized(storage.slope, values, times)
            found = max(found, float(np.abs(values[storage.var][0] * answer).max()))
    return found


def _check_start(found: Checked, raw: Raw, values: Mapping[Var, Sized], times: np.ndarray) -> None:
    """Compare the first row with the initial values that the program gives."""
    missed: list[tuple[str, float]] = []
    for k, given in raw.given.items():
        if (x := Var("x", k)) in values and x not in raw.held:
            value, size = values[x]
            missed.append((raw.x_names[k], abs(value[0] - given) / (size[0] + abs(given) + 1e-300)))
    for e in raw.conditions:
        if _known(e, values):
            value, size = sized(e, values, times)
            missed.append(("condition", abs(value[0]) / (size[0] + 1e-300)))
    for name, share in missed:
        if not share <= found.start:
            found.start, found.given = float(share), name


__all__ = ["Checked", "Num", "check_columns"]
