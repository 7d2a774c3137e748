"""The equations of `NearRigid`, written out by hand in NumPy over all bodies and joints at once.

Independent of the compiler: the benchmark first compares this f with the compiled one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_MASS = np.array([1e5, 5e3, 3e3, 1.5e3])
_INERTIA = np.array(
    [[7e5, 3.6e6, 4.1e6], [7.5e3, 7.5e3, 1.5e3], [4e2, 1.65e4, 1.65e4], [1.2e2, 4.6e3, 4.6e3]]
)
_AT_A = np.array([[2, 0, 1.5], [0, 0, 2], [4, 0, 0]])
_AT_B = np.array([[0, 0, -2], [-4, 0, 0], [-3, 0, 0]])
_AXIS = np.array([[0, 0, 1], [0, 1, 0], [0, 1, 0]])
_PULL_BACK = np.array([4e4, 4e4, 1.5e6])
_TURN_BACK = np.array([2e6, 2e7, 1e6])
_WASH = np.array([2e4, 2e4, 2e5, 3e5, 3e6, 5e5])
_HOLD = np.array([2e6, 3e6, 1e6])
_FRICTION = np.array([1e5, 1e5, 2e4])
_SWING = np.array([0.3, 0.15, 0.2])
_RATE = np.array([0.5, 0.7, 0.9])
_WEIGHT = 9.81 * _MASS[1:]
_PARTS = ("body.body.p", "pose.attitude.h", "pose.r", "spring.q")


def order(names: Sequence[str]) -> NDArray[np.intp]:
    """Places of the states, which this module lays out by kind, then by body or joint."""
    bodies, joints = ("vessel", "column", "boom", "jib"), ("slew", "luff", "fold")
    wanted = [
        f"{owner}.{part}[{k}]"
        for part, size in zip(_PARTS, (6, 4, 3, 6), strict=True)
        for owner in (joints if part == "spring.q" else bodies)
        for k in range(1, size + 1)
    ]
    return np.array([names.index(name) for name in wanted])


def _cross(a: Array, b: Array) -> Array:
    """Products of vectors, row by row: np.cross takes five times as long."""
    x, y, z = a.T
    u, v, w = b.T
    return np.stack((y * w - z * v, z * u - x * w, x * v - y * u), axis=1)


def _turned(A: Array, v: Array) -> Array:
    return (A @ v[:, :, None])[:, :, 0]


class NumPyCrane:
    """f(t, y) in the layout of `order`."""

    def __init__(self, stiffness: float = 1e8, damping_ratio: float = 1.0) -> None:
        held = 1.0 - _AXIS
        ones = np.ones((3, 3))
        k = stiffness
        self._stiffness = np.hstack((k * ones, 10 * k * held + _HOLD[:, None] * _AXIS))
        linear = 2 * damping_ratio * np.sqrt(k * 5e3)
        angular = 2 * damping_ratio * np.sqrt(10 * k * 5e4)
        self._damping = np.hstack((linear * ones, angular * held + _FRICTION[:, None] * _AXIS))

    def __call__(self, t: float, state: Array) -> Array:
        """Derivatives of momenta, quaternions, places and deflections."""
        p, h = state[:24].reshape(4, 6), state[24:40].reshape(4, 4)
        r, q = state[40:52].reshape(4, 3), state[52:].reshape(3, 6)
        v, w = p[:, :3] / _MASS[:, None], p[:, 3:] / _INERTIA

        # Orientations, of quaternions of any length.
        s = 2.0 / (h * h).sum(axis=1)
        a, b, c, d = h.T
        A = np.empty((4, 3, 3))
        A[:, 0, 0] = 1 - s * (c * c + d * d)
        A[:, 0, 1] = s * (b * c - a * d)
        A[:, 0, 2] = s * (b * d + a * c)
        A[:, 1, 0] = s * (b * c + a * d)
        A[:, 1, 1] = 1 - s * (b * b + d * d)
        A[:, 1, 2] = s * (c * d - a * b)
        A[:, 2, 0] = s * (b * d - a * c)
        A[:, 2, 1] = s * (c * d + a * b)
        A[:, 2, 2] = 1 - s * (b * b + c * c)
        At = A.transpose(0, 2, 1)

        # Joints: the motion of b less that of a in the axes of a, and the efforts of the springs.
        R = At[:-1] @ A[1:]
        arm = _AT_A + q[:, :3]
        rates = np.empty((3, 6))
        rates[:, :3] = _turned(R, v[1:] + _cross(w[1:], _AT_B)) - v[:-1] - _cross(w[:-1], arm)
        rates[:, 3:] = _turned(R, w[1:]) - w[:-1]
        effort = self._stiffness * q + self._damping * rates
        effort[:, 3:] -= (_HOLD * _SWING * np.sin(_RATE * t))[:, None] * _AXIS

        # Momenta: gyroscopic efforts, weight, water, and what the joints put on both sides.
        change = np.empty((4, 6))
        change[:, :3] = _cross(p[:, :3], w)
        change[:, 3:] = _cross(p[:, 3:], w) + _cross(p[:, :3], v)
        change[1:, :3] -= _WEIGHT[:, None] * A[1:, 2, :]
        hull = A[0]
        change[0, :3] -= hull.T @ (_PULL_BACK * r[0])
        sines = np.array(
            [hull[2, 1] - hull[1, 2], hull[0, 2] - hull[2, 0], hull[1, 0] - hull[0, 1]]
        )
        change[0, 3:] -= 0.5 * _TURN_BACK * sines
        change[0] -= _WASH * np.concatenate((v[0], w[0]))
        change[:-1, :3] += effort[:, :3]
        change[:-1, 3:] += effort[:, 3:] + _cross(arm, effort[:, :3])
        Rt = R.transpose(0, 2, 1)
        force, moment = _turned(Rt, effort[:, :3]), _turned(Rt, effort[:, 3:])
        change[1:, :3] -= force
        change[1:, 3:] -= moment + _cross(_AT_B, force)

        turning = np.empty((4, 4))
        turning[:, 0] = -0.5 * (h[:, 1:] * w).sum(axis=1)
        turning[:, 1:] = 0.5 * (h[:, :1] * w + _cross(h[:, 1:], w))
        moving = _turned(A, v)
        return np.concatenate((change.ravel(), turning.ravel(), moving.ravel(), rates.ravel()))
