"""A hull in heave, roll and pitch, free in surge, sway and yaw, from its kinetic energy."""

from __future__ import annotations

import numpy as np

UPRIGHT = [2, 3, 4]
HORIZONTAL = [0, 1, 5]


def free_horizontally(M: np.ndarray) -> np.ndarray:
    """The six motions for each of heave, roll and pitch that give no horizontal momentum."""
    follow = np.zeros((6, 3))
    follow[UPRIGHT] = np.eye(3)
    follow[HORIZONTAL] = -np.linalg.solve(
        M[np.ix_(HORIZONTAL, HORIZONTAL)], M[np.ix_(HORIZONTAL, UPRIGHT)]
    )
    return follow


def through_water(motion: np.ndarray, rates: np.ndarray, speed: float) -> np.ndarray:
    """Twist in body axes (NED) under way along x; the six motions are about the mean heading."""
    roll, pitch, yaw = motion[3:]
    (a, b, c), (s, t, u) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    turned = (
        np.array([[c, -u, 0], [u, c, 0], [0, 0, 1]])
        @ [[b, 0, t], [0, 1, 0], [-t, 0, b]]
        @ [[1, 0, 0], [0, a, -s], [0, s, a]]
    )
    spin = np.array([[1, 0, -t], [0, a, s * b], [0, -s, a * b]]) @ rates[3:]
    return np.concatenate([turned.T @ np.add(rates[:3], [speed, 0, 0]), spin])


def speed_terms(
    A: np.ndarray, D: np.ndarray, follow: np.ndarray, speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Rates' and displacements' matrices of Lagrange's equations of the added mass A, and of D.

    Second differences of the kinetic energy, first ones of the generalised forces of damping,
    whose steady part the thrust along the hull takes.
    """
    steps = 1e-3 * np.eye(6)

    def twist(x: np.ndarray, ahead: float) -> np.ndarray:
        return through_water(follow @ x[:3], follow @ x[3:], ahead)

    def energy(x: np.ndarray) -> float:
        v = twist(x, speed)
        return 0.5 * v @ A @ v

    def force(x: np.ndarray) -> np.ndarray:
        arms = [twist(np.concatenate([x[:3], e]), 0) for e in np.eye(3)]
        v = twist(x, speed) - twist(np.zeros(6), speed)
        return np.array(arms) @ D @ v

    T = np.array([
        [
            sum(i * j * energy(i * h + j * k) for i in (1, -1) for j in (1, -1)) / 4e-6
            for k in steps
        ]
        for h in steps
    ])  # fmt: skip
    F = np.array([(force(h) - force(-h)) / 2e-3 for h in steps]).T
    return T[3:, :3] - T[:3, 3:] + F[:, 3:], F[:, :3] - T[:3, :3]
