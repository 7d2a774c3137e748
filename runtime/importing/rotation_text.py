"""Rotations as they are written in a `.bg` file, with the matrix that they mean."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from bgc.record_class import dataclass

Vector = tuple[float, float, float]
Matrix = npt.NDArray[np.float64]

_SNAP = 1e-11  # rad; a quarter turn in eleven digits is a quarter turn
_QUARTERS = {0: (1.0, 0.0), 1: (0.0, 1.0), 2: (-1.0, 0.0), 3: (0.0, -1.0)}


@dataclass(frozen=True, slots=True)
class Rotation:
    """A rotation matrix by rows, child's axes -> parent's, and its text; empty for none."""

    rows: tuple[Vector, Vector, Vector]
    text: str = ""

    @property
    def matrix(self) -> Matrix:
        """The matrix as an array."""
        return np.array(self.rows)


UNTURNED = Rotation(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


def rows_of(matrix: Matrix) -> tuple[Vector, Vector, Vector]:
    """Return a 3x3 array as tuples, without negative zeros."""
    a, b, c = ((float(x) + 0.0, float(y) + 0.0, float(z) + 0.0) for x, y, z in matrix)
    return a, b, c


def number(value: float) -> str:
    """Write a number with as few digits as give the same double."""
    if value == 0:
        return "0"
    text = repr(float(value))
    return text.removesuffix(".0")


def angle(value: float) -> str:
    """Write an angle: quarter turns in degrees, other angles in radians as they are given."""
    quarters = _quarters(value)
    if quarters is None:
        return number(value)
    return f"{90 * quarters} deg" if quarters else "0"


def by_roll_pitch_yaw(angles: Sequence[float]) -> Rotation:
    """Make Rz(yaw) Ry(pitch) Rx(roll)."""
    turns = [_turn(axis, value) for axis, value in enumerate(angles)]
    matrix = turns[2] @ turns[1] @ turns[0]
    turned = [k for k, value in enumerate(angles) if _quarters(value) != 0]
    if not turned:
        return UNTURNED
    if len(turned) == 1:
        text = f"rot_{'xyz'[turned[0]]}({angle(angles[turned[0]])})"
    else:
        text = f"euler_matrix([{', '.join(map(angle, angles))}])"
    return Rotation(rows_of(matrix), text)


def by_quaternion(h: Sequence[float]) -> Rotation:
    """Make the rotation of a quaternion [scalar, vector] of any length."""
    w, *v = (float(x) for x in np.array(h) / np.linalg.norm(h))
    turned = [k for k in range(3) if abs(v[k]) > _SNAP / 2]
    if len(turned) <= 1:
        axis = turned[0] if turned else 0
        full = math.remainder(2 * math.atan2(v[axis], w), 2 * math.pi)
        if _quarters(full) is not None:
            angles = [0.0, 0.0, 0.0]
            angles[axis] = full
            return by_roll_pitch_yaw(angles)
    x, y, z = v
    matrix = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    nearest = np.rint(matrix)
    if np.abs(matrix - nearest).max() < _SNAP:  # quarter turns about several axes
        rows = rows_of(nearest)
        return Rotation(rows, f"[{', '.join('[' + ', '.join(map(number, r)) + ']' for r in rows)}]")
    return Rotation(rows_of(matrix), f"quaternion_matrix([{', '.join(map(number, (w, *v)))}])")


def _quarters(value: float) -> int | None:
    """Count the quarter turns in an angle; None for any other angle."""
    count = round(value / (math.pi / 2))
    return count if abs(count) <= 8 and abs(value - count * math.pi / 2) < _SNAP else None


def _turn(axis: int, value: float) -> Matrix:
    """Rotation by an angle about x, y or z; exact for quarter turns."""
    quarters = _quarters(value)
    c, s = (math.cos(value), math.sin(value)) if quarters is None else _QUARTERS[quarters % 4]
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i] = matrix[j, j] = c
    matrix[j, i], matrix[i, j] = s, -s
    return matrix
