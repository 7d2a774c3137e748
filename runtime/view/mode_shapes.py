"""Mode shapes for the page: each mode of the linear form swings the shapes of the scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from bgc.diagnostics.catalogue.view import no_mode_moves
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.record_class import dataclass
from bgc.runtime.linear.state_space import Mode
from bgc.runtime.linearising.operating_point import OpenedModel
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.running.failures import require
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.view.history import as_rows
from bgc.runtime.view.recording import Recording
from bgc.runtime.view.scene_description import Description, describe_model, meshes_of

_ROWS = 49  # of a cycle, the first row again at its end
_CYCLE = 2.0  # s in which a cycle is shown
_APART = 1.0  # s between the rows of two modes
_DRAWN_DISPLACEMENT = 0.08  # displacement of the point that moves most, of the size of the scene
_TURN = 0.3  # rad at most
_DIFFERENCE_STEP = 1e-4  # change of the states, in their scales, for the differences
_STILL = 1e-11  # change of the shapes with it, of the scene's size, that may be rounding
_ROUNDING = 1e-12  # of a damping ratio
_CONSTANT = 1e-12  # of the largest eigenvalue: rounding, the mode of a body that is free
_PLACES = ("r", "from", "to", "position", "points")
_SHARES = 3  # states that are named


@dataclass(frozen=True, slots=True)
class Swing:
    """A mode, and the complex amplitudes of the columns that it moves, scaled for the page."""

    mode: Mode
    columns: Complex


def record_modes(
    model: LoadedModel,
    path: Path,
    options: Options,
    at: float | Literal["steady"] | None,
) -> Recording:
    """Linearise a scene, and show each mode that moves a shape as a cycle of rows.

    Modes stand one after another in time. Displacements are linear in the eigenvector, so that
    phases and ratios between the parts are those of the mode; rotations stay rotations.

    Raises BgError: BG659 if no mode moves a shape.
    """
    opened = OpenedModel(path, options, values=model.parameters.given({}))
    point = opened.operating_point(at)
    modes, vectors = opened.mode_shapes(point)
    names = [variable.name for variable in opened.opened.program.states]
    places = [k for k, s in enumerate(model.states) if s.name in names]
    taken = [names.index(model.states[k].name) for k in places]
    start = model.instance_at(None, point.time).state.copy()
    start[places] = point.state[taken]
    rest = _columns(model, start, point.time)
    description = describe_model(model, path.name)
    shapes = [shape for shape in description["shapes"] if shape["kind"] != "handle"]
    description["shapes"] = shapes
    size = _size(description, rest)
    swings = []
    constant = _CONSTANT * max((abs(mode.eigenvalue) for mode in modes), default=0.0)
    for mode, vector in zip(modes, vectors.T, strict=True):
        if abs(mode.eigenvalue) <= constant:
            continue
        step = _DIFFERENCE_STEP / float((np.abs(vector) / opened.scale).max())
        moved = np.zeros(len(start), dtype=np.complex128)
        moved[places] = step * vector[taken]
        scaled = _scaled(description, _change(model, start, moved, point.time), size)
        if scaled is not None:
            swings.append(Swing(mode, scaled))
    if not swings:
        raise BgError([no_mode_moves(model.facts.name, len(modes))])
    swings.sort(key=lambda swing: swing.mode.frequency == 0)  # those that oscillate first
    phase = np.linspace(0, 2 * math.pi, _ROWS)
    rows = [
        _rotations(description, rest + (np.exp(1j * phase)[:, None] * swing.columns).real)
        for swing in swings
    ]
    begins = np.arange(len(swings)) * (_CYCLE + _APART)
    times = (begins[:, None] + np.linspace(0, _CYCLE, _ROWS)).ravel()
    accounts = model.row_width - rest.size
    values = np.pad(np.concatenate(rows), ((0, 0), (0, accounts)))
    description |= {
        "parameters": [], "folded": [], "devices": [], "observed": [], "panels": [],
        "duration": float(times[-1]),
        "modes": [
            _described(swing.mode, begin) for swing, begin in zip(swings, begins, strict=True)
        ],
        "still": len(modes) - len(swings),
    }  # fmt: skip
    return Recording(description, as_rows(times, values), meshes_of(description, model.folder))


def _columns(model: LoadedModel, state: Array, time: float) -> Array:
    """The measured columns at a state, (columns,)."""
    instance = model.instance_at(state, time)
    status, found = instance.outputs()
    require(instance, status)
    return np.array(found)


def _change(model: LoadedModel, start: Array, moved: Complex, time: float) -> Complex:
    """The change of the columns with a small complex change of the states: central differences."""
    parts = []
    for part in (moved.real, moved.imag):
        ahead, behind = (_columns(model, start + way * part, time) for way in (1, -1))
        parts.append((ahead - behind) / 2)
    return np.asarray(parts[0] + 1j * parts[1])


def _places(description: Description) -> Iterator[tuple[str, list[int]]]:
    """The columns of positions (`place`) and of rotations (`turn`) of the shapes."""
    for shape in description["shapes"]:
        for name, value in shape["values"].items():
            columns = value.get("columns")
            if columns and name in _PLACES:
                yield "place", columns
            elif columns and name == "A":
                yield "turn", columns


def _size(description: Description, rest: Array) -> float:
    """The diagonal of the box around all positions, with the lengths of the shapes, m."""
    points, longest = [np.zeros(3)], 0.0
    for shape in description["shapes"]:
        for name, value in shape["values"].items():
            numbers = _numbers(value, rest)
            if name in _PLACES and numbers.size % 3 == 0:
                points += list(numbers.reshape(-1, 3))
            elif value["shape"] == [] and shape["kind"] not in ("sea", "handle"):
                longest = max(longest, float(numbers[0]))
    spread = np.ptp(np.array(points[1:] or points), axis=0)
    return float(np.linalg.norm(spread)) + longest or 1.0


def _numbers(value: Mapping[str, Any], rest: Array) -> Array:
    columns = value.get("columns")
    return np.array(value["numbers"]) if columns is None else rest[columns]


def _scaled(description: Description, swing: Complex, size: float) -> Complex | None:
    """Scale amplitudes to a part of the scene's size; None for a mode that moves no shape."""
    farthest, turn = 0.0, 0.0
    for kind, columns in _places(description):
        amount = np.abs(swing[columns])
        if kind == "place":
            farthest = max(farthest, float(np.linalg.norm(amount.reshape(-1, 3), axis=1).max()))
        else:
            turn = max(turn, float(amount.max()))
    if not max(farthest / size, turn) > _STILL:
        return None
    factors = [_DRAWN_DISPLACEMENT * size / farthest] if farthest > 0 else []
    factors += [_TURN / turn] if turn > 0 else []
    return np.asarray(swing * min(factors))


def _rotations(description: Description, rows: Array) -> Array:
    """Replace each changed rotation matrix by the nearest rotation."""
    for kind, columns in _places(description):
        if kind == "turn":
            left, _, right = np.linalg.svd(rows[:, columns].reshape(-1, 3, 3))
            rows[:, columns] = (left @ right).reshape(-1, 9)
    return rows


def _described(mode: Mode, begin: float) -> dict[str, Any]:
    """A mode for the page; infinite times are null."""
    numbers = {
        "frequency": mode.frequency,
        "natural": 1 / mode.natural_period,
        "damping": mode.damping if abs(mode.damping) > _ROUNDING else 0.0,
        "constant": mode.time_constant,
        "first": float(begin),
        "last": float(begin) + _CYCLE,
    }
    finite = {name: x if math.isfinite(x) else None for name, x in numbers.items()}
    return {**finite, "states": [name for name, _ in mode.shares[:_SHARES]]}
