"""Tables and files of a linear model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bgc.printing.text_tables import Table, elided
from bgc.runtime.linear.state_space import Linearisation, Mode
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.files import write_rows, written_whole

_COLUMNS, _ROWS, _MODES = 8, 16, 48  # of a matrix and of the modes, shown without --full
_SHARE = 0.15  # of a mode: a state with a smaller participation is not named
_NAMED = 3  # states at most that are named for a mode
_ALMOST_ZERO = 1e-12  # of the largest eigenvalue: rounding


def linear_tables(linear: Linearisation, full: bool) -> list[Table]:
    """Tabulate the operating point, the matrices and the modes, in full or abridged."""
    rates = [f"{name}'" for name in linear.states]
    matrices = [
        ("A: rates by states", linear.A, rates, linear.states),
        ("B: rates by inputs", linear.B, rates, linear.inputs),
        ("C: outputs by states", linear.C, linear.outputs, linear.states),
        ("D: outputs by inputs", linear.D, linear.outputs, linear.inputs),
    ]
    if not linear.is_explicit:
        matrices.insert(0, ("E: factors of the rates", linear.E, linear.states, linear.states))
    return [
        _point_table(linear, full),
        *(_matrix_table(*matrix, full) for matrix in matrices if matrix[1].size),
        mode_table(linear.modes(), full),
    ]


def mode_table(modes: Sequence[Mode], full: bool) -> Table:
    """Tabulate modes by rising frequency: eigenvalue, period, damping, time constant, states.

    Eigenvalues that are zero to rounding are shown as zero, before the others.
    """
    zero = _ALMOST_ZERO * max((abs(mode.eigenvalue) for mode in modes), default=0.0)
    at_rest = [mode for mode in modes if abs(mode.eigenvalue) <= zero]
    moving = [mode for mode in modes if abs(mode.eigenvalue) > zero]
    rows = [_mode_row(mode, zero) for mode in (*at_rest, *moving)]
    header = (
        "eigenvalue 1/s", "period s", "natural period s", "damping", "time constant s", "states",
    )  # fmt: skip
    return Table("modes", header, elided(rows, len(rows) if full else _MODES))


def write_modes(modes: Sequence[Mode], path: Path) -> None:
    """Write a line for each mode, in full precision, with the participation of each state."""
    states = sorted({name for mode in modes for name, _ in mode.shares})
    header = ("real", "imag", "period", "natural_period", "damping", *states)
    write_rows(path, header, (_mode_figures(mode, states) for mode in modes))


def _mode_figures(mode: Mode, states: Sequence[str]) -> tuple[float, ...]:
    value, shares = mode.eigenvalue, dict(mode.shares)
    parts = (shares.get(name, 0.0) for name in states)
    return (value.real, value.imag, mode.period, mode.natural_period, mode.damping, *parts)


def _mode_row(mode: Mode, zero: float) -> tuple[str, ...]:
    value = mode.eigenvalue
    named = [(name, share) for name, share in mode.shares[:_NAMED] if share >= _SHARE]
    states = ", ".join(f"{name} {100 * share:.0f}%" for name, share in named)
    if abs(value) <= zero:
        return "0", "", "", "", "", states
    real = value.real if abs(value.real) > zero else 0.0
    if value.imag == 0:
        return _short(real), "", "", "", _short(mode.time_constant), states
    return (
        f"{_short(real)} +- {_short(value.imag)}i",
        _short(mode.period),
        _short(mode.natural_period),
        _short(mode.damping if real else 0.0),
        _short(mode.time_constant) if real else "",
        states,
    )


def _point_table(linear: Linearisation, full: bool) -> Table:
    rows = [
        (name, _short(linear.shown_in(name).number(value)), linear.shown_in(name).unit)
        for name, value in zip(linear.states, linear.point.tolist(), strict=True)
    ]
    title = f"operating point, at {linear.time:g} s"
    return Table(title, ("state", "value", "unit"), elided(rows, len(rows) if full else _ROWS))


def _matrix_table(
    title: str, matrix: Array, rows: Sequence[str], columns: Sequence[str], full: bool
) -> Table:
    cells = [
        (name, *(_short(value) for value in row))
        for name, row in zip(rows, matrix.tolist(), strict=True)
    ]
    header: tuple[str, ...] = ("", *columns)
    note = ""
    if not full and (len(columns) > _COLUMNS or len(rows) > _ROWS):
        half = _COLUMNS // 2
        if len(columns) > _COLUMNS:
            header = (*header[: half + 1], "...", *header[-half:])
            cells = [(*row[: half + 1], "...", *row[-half:]) for row in cells]
        note = f"{len(rows)} x {len(columns)}; --full prints all, --out writes them"
    return Table(title, header, elided(cells, len(cells) if full else _ROWS), note)


def _short(value: float) -> str:
    """Write six digits; nothing for infinity."""
    return f"{value:.6g}" if math.isfinite(value) else ""


def write_csv(linear: Linearisation, path: Path) -> None:
    """Write `[A B; C D]` with the names of rows and columns, in full precision.

    If E is not the identity, its columns come before those of A, named after the rates.
    """
    blocks = [np.hstack((linear.A, linear.B)), np.hstack((linear.C, linear.D))]
    names = [*linear.states, *linear.inputs]
    if not linear.is_explicit:
        blocks[0] = np.hstack((linear.E, blocks[0]))
        blocks[1] = np.hstack((np.zeros_like(linear.C), blocks[1]))
        names = [*(f"{name}'" for name in linear.states), *names]
    labels = [*(f"{name}'" for name in linear.states), *linear.outputs]
    rows = zip(labels, np.vstack(blocks).tolist(), strict=True)
    write_rows(path, ("", *names), ((label, *row) for label, row in rows))


def write_npz(linear: Linearisation, path: Path) -> None:
    """Write A, B, C, D, E, the operating point and the names as a NumPy archive."""
    arrays = {
        **{name: getattr(linear, name) for name in ("A", "B", "C", "D", "E", "point")},
        **{name: np.array(getattr(linear, name)) for name in ("states", "inputs", "outputs")},
        "time": np.array(linear.time),
    }
    with written_whole(path) as aside, aside.open("wb") as file:
        np.savez(file, **arrays)
