"""Uniform bars with pins in the plane, in maximal coordinates with constraint forces.

An independent answer for linkages: no joints, momenta or bond graphs, but the coordinates of every
bar's centre and its angle, and pins as equations between accelerations, integrated by SciPy to
1e-12.
"""

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.81


def direction(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def across(angle):
    return np.array([-np.sin(angle), np.cos(angle)])


class Bars:
    """Uniform bars with pins, in the plane: coordinates (x, y, angle) of each centre."""

    def __init__(self, *bars):  # (mass, length, side)
        self.mass = np.array([m for m, _, _ in bars])
        self.inertia = np.array([m * (length**2 + s**2) / 12 for m, length, s in bars])
        self.half = np.array([length / 2 for _, length, _ in bars])
        self.rows = []  # functions of q: row of J, and the part of the acceleration without q''
        self.torques = np.zeros(3 * len(bars))

    def at(self, bar, along):
        """A point of a bar, `along` from its centre: its position, J, and -J' v as functions."""

        def point(q):
            return q[3 * bar : 3 * bar + 2] + along * direction(q[3 * bar + 2])

        def jacobian(q):
            j = np.zeros((2, len(q)))
            j[:, 3 * bar : 3 * bar + 2] = np.eye(2)
            j[:, 3 * bar + 2] = along * across(q[3 * bar + 2])
            return j

        def turning(q, v):
            return -along * v[3 * bar + 2] ** 2 * direction(q[3 * bar + 2])

        return point, jacobian, turning

    def pin(self, one, other=None):
        """Two points coincide, or one stays where it is."""
        self.rows.append(
            lambda q, v: (
                one[1](q) - (other[1](q) if other else 0),
                -one[2](q, v) + (other[2](q, v) if other else 0),
            )
        )

    def fix(self, coordinates):
        """A linear combination of coordinates is constant."""
        self.rows.append(lambda q, v: (np.atleast_2d(coordinates), np.zeros(1)))

    def slide(self, one, other, bar):
        """The vector between two points stays along a bar."""

        def row(q, v):
            gap = one[0](q) - other[0](q)
            rate = (one[1](q) - other[1](q)) @ v
            n, t, w = across(q[3 * bar + 2]), direction(q[3 * bar + 2]), v[3 * bar + 2]
            j = n @ (one[1](q) - other[1](q))
            j[3 * bar + 2] -= t @ gap
            rest = n @ (one[2](q, v) - other[2](q, v)) - 2 * w * t @ rate - w**2 * n @ gap
            return np.atleast_2d(j), np.array([-rest])

        self.rows.append(row)

    def motion(self, q0, times, force=None):
        size = len(q0)
        weight = np.repeat(np.stack([self.mass, self.mass, self.inertia], 1), 1, 0).ravel()
        load = self.torques.copy()
        load[1::3] -= self.mass * GRAVITY

        def slope(_, state):
            q, v = state[:size], state[size:]
            parts = [row(q, v) for row in self.rows]
            j, right = np.vstack([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
            applied = load + (force(q) if force else 0)
            matrix = np.block([[np.diag(weight), j.T], [j, np.zeros((len(j), len(j)))]])
            return np.concatenate([v, np.linalg.solve(matrix, np.append(applied, right))[:size]])

        start = np.append(q0, np.zeros(size))
        exact = solve_ivp(
            slope, (0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-12, max_step=0.01
        )
        assert exact.success
        return exact.y[:size].T


def bar_from(at, length, angle):
    return [*(at + length / 2 * direction(angle)), angle]


def four_bar(times, q, crank=1):
    """Angles of the bars to the ground, from the angles at the start."""
    bars = Bars((3, crank, 0.1), (8, 2.5, 0.1), (5, 1.7, 0.1))
    lengths, at, start = (crank, 2.5, 1.7), np.zeros(2), []
    for length, angle in zip(lengths, q, strict=True):
        start += bar_from(at, length, angle)
        at = at + length * direction(angle)
    bars.pin(bars.at(0, -crank / 2))
    bars.pin(bars.at(0, crank / 2), bars.at(1, -1.25))
    bars.pin(bars.at(1, 1.25), bars.at(2, -0.85))
    bars.pin(bars.at(2, 0.85))
    bars.torques[2] = 60
    return bars.motion(np.array(start), times)[:, 2::3]
