"""Poses that Python hands to a device, as C has them (`bgc_pose` of bgc_device.h)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bgc.runtime.results.arrays import Array

FED: Final = ("pointer", "gamepad")
"""Drivers whose pose is handed over by a program."""

_WORDS: Final = 27
_UNKNOWN: Final = (np.nan, 0.0, 0.0)  # C computes such a velocity; it knows such a held force


def pose_words(
    position: Sequence[float] | Array = (0.0, 0.0, 0.0),
    orientation: Sequence[float] | Array = (1.0, 0.0, 0.0, 0.0),
    rates: tuple[Sequence[float] | Array | None, Sequence[float] | Array | None] = (None, None),
    gripper: float = 0.0,
    buttons: Sequence[float] = (),
    stamp: float = 0.0,
    age: float = 0.0,
) -> Array:
    """Arrange a pose as the numbers of `bgc_pose`, (27,).

    Parameters
    ----------
    position, orientation
        m, and a unit quaternion, scalar first.
    rates
        Velocity, m/s, and angular velocity, rad/s; None where they follow from the positions.
    gripper, buttons
        m, and 0 or 1 for up to eight buttons.
    stamp
        The time of the measurement, s; 0 where it is not known.
    age
        From the pose that the held force answers to this one, s; 0 where it is not known.

    Raises
    ------
    ValueError
        Where a part has another size, or position and orientation are not finite.
    """
    pressed = [*buttons, *[0.0] * (8 - len(buttons))]
    velocity, angular = (_UNKNOWN if rate is None else rate for rate in rates)
    parts = (position, orientation, velocity, angular, [gripper], pressed, [stamp], _UNKNOWN, [age])
    words = np.concatenate([np.asarray(part, dtype=float) for part in parts])
    if len(words) != _WORDS or not np.isfinite(words[:7]).all():
        raise ValueError("a pose has 3 positions, a quaternion and up to 8 buttons")
    return words
