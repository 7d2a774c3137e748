"""A hull under way in heave, roll and pitch, from the kinetic energy of its added mass."""

from __future__ import annotations

import numpy as np


def through_water(q: np.ndarray, rates: np.ndarray, speed: float) -> np.ndarray:
    """Twist in body axes (NED) at heave, roll and pitch q, under way along x."""
    roll, pitch = q[1:]
    (a, b), (s, t) = np.cos([roll, pitch]), np.sin([roll, pitch])
    turned = np.array([[b, 0, t], [0, 1, 0], [-t, 0, b]]) @ [[1, 0, 0], [0, a, -s], [0, s, a]]
    spin = [rates[1], rates[2] * a, -rates[2] * s]
    return np.concatenate([turned.T @ [speed, 0, rates[0]], spin])


def speed_terms(A: np.ndarray, D: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Rates' and displacements' matrices of Lagrange's equations of the added mass A, and of D.

    Second differences of the kinetic energy, first ones of the generalised forces of damping,
    whose steady part the thrust along the hull takes.
    """
    steps = 1e-3 * np.eye(6)

    def energy(x: np.ndarray) -> float:
        v = through_water(x[:3], x[3:], speed)
        return 0.5 * v @ A @ v

    def force(x: np.ndarray) -> np.ndarray:
        arms = [through_water(x[:3], e, 0) for e in np.eye(3)]
        v = through_water(x[:3], x[3:], speed) - through_water(np.zeros(3), np.zeros(3), speed)
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
