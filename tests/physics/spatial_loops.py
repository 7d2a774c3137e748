"""Loops of bars on pins in space with one degree of freedom, by their geometry and energies alone.

An independent answer: no bonds, no constraint forces and no projection. The joint angles follow
from one of them by Newton's method on the closure; the inertia m and the potential V in this
coordinate are interpolated over its range, and `m a'' + m'/2 a'^2 + V' = 0` is integrated by SciPy
to 1e-12.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

GRAVITY = 9.81
SIDE = 0.1
_DEGREE = 120


@dataclass(frozen=True)
class Bar:
    """A pin about `axis`, then a bar of square section along `along`, then a turn of its end.

    `axis` and `along` are in the axes of the bar at angle 0; a bar without mass is a distance.
    """

    axis: tuple[float, float, float]
    along: tuple[float, float, float]
    mass: float = 0.0
    turn: np.ndarray | None = None

    def inertia(self) -> np.ndarray:
        length = np.linalg.norm(self.along)
        unit = np.outer(self.along, self.along) / length**2
        across = self.mass * (length**2 + SIDE**2) / 12
        return across * (np.eye(3) - unit) + self.mass * SIDE**2 / 6 * unit


@dataclass(frozen=True)
class Loop:
    """Bars one after another from the origin; the end of the last has to lie in `closing`."""

    bars: tuple[Bar, ...]
    closing: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def places(self, angles):
        """Origins, axes of pins, orientations and centres of the bars, and the end."""
        at, frame, found = np.zeros(3), np.eye(3), []
        for bar, angle in zip(self.bars, angles, strict=True):
            axis = frame @ bar.axis
            frame = frame @ Rotation.from_rotvec(angle * np.array(bar.axis)).as_matrix()
            reach = frame @ bar.along
            found.append((at, axis, frame, at + reach / 2))
            at = at + reach
            frame = frame if bar.turn is None else frame @ bar.turn
        return found, at, frame

    def gap(self, angles):
        """Six numbers that are zero where the loop is closed, and their derivatives."""
        found, end, frame = self.places(angles)
        turn = np.array([frame[2, 1] - frame[1, 2], frame[0, 2] - frame[2, 0],
                         frame[1, 0] - frame[0, 1]]) / 2  # fmt: skip
        spread = (np.trace(frame) * np.eye(3) - frame) / 2
        columns = [
            np.concatenate([np.cross(axis, end - at), spread.T @ axis]) for at, axis, _, _ in found
        ]
        return np.concatenate([end - self.closing, turn]), np.column_stack(columns)

    def closed(self, first, near):
        """The angles with a given first one, near others."""
        angles = np.array([first, *near[1:]])
        for _ in range(30):
            gap, slopes = self.gap(angles)
            change = np.linalg.lstsq(slopes[:, 1:], -gap, rcond=1e-9)[0]
            angles[1:] += change
            if np.abs(change).max() < 1e-14:
                break
        assert np.abs(self.gap(angles)[0]).max() < 1e-13
        return angles

    def energies(self, angles):
        """The inertia in the first angle and the potential."""
        found, _, _ = self.places(angles)
        _, slopes = self.gap(angles)
        rates = np.concatenate(
            [[1.0], -np.linalg.lstsq(slopes[:, 1:], slopes[:, 0], rcond=1e-9)[0]]
        )
        inertia = potential = 0.0
        for k, (bar, (_, _, frame, centre)) in enumerate(zip(self.bars, found, strict=True)):
            if not bar.mass:
                continue
            axes = [(axis, at) for at, axis, _, _ in found[: k + 1]]
            turning = sum(r * axis for r, (axis, _) in zip(rates, axes, strict=False))
            moving = sum(
                r * np.cross(axis, centre - at) for r, (axis, at) in zip(rates, axes, strict=False)
            )
            own = frame.T @ turning
            inertia += bar.mass * moving @ moving + own @ bar.inertia() @ own
            potential += bar.mass * GRAVITY * centre[2]
        return inertia, potential

    def along_first(self, start, low, high):
        """The inertia and the potential as functions of the first angle, from `low` to `high`."""
        domain = (low, high)
        nodes = np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
        firsts = (low + high) / 2 + (high - low) / 2 * nodes
        values = {}
        for side in (1, -1):  # from the start outwards, each from its neighbour
            near = np.array(start)
            ahead = (a for a in firsts if side * (a - start[0]) >= 0)
            for first in sorted(ahead, key=lambda a: side * a):
                for part in np.linspace(near[0], first, 4)[1:]:
                    near = self.closed(part, near)
                values[first] = self.energies(near)
        table = np.array([values[a] for a in firsts])
        return [Chebyshev.fit(firsts, y, _DEGREE, domain) for y in table.T]

    def motion(self, start, times, low, high):
        """The first angle over time, from rest at the angles `start`, within `low` and `high`."""
        inertia, potential = self.along_first(start, low, high)
        bent, pull = inertia.deriv(), potential.deriv()

        def rates(_, x):
            return [x[1], -(pull(x[0]) + bent(x[0]) * x[1] ** 2 / 2) / inertia(x[0])]

        found = solve_ivp(
            rates, (0, times[-1]), [start[0], 0.0], "DOP853", times, rtol=1e-12, atol=1e-13
        )
        return found.y[0]


def bricard() -> Loop:
    """Bricard's orthogonal linkage with edges of 1 m, as in `spatial_linkages.bg`."""
    x, y, z = np.eye(3)
    pins, edges = (y, z, x, y, z, x), (x, y, z, -x, -y, 0 * x)
    masses = (1, 1, 1, 1, 1, 0)
    return Loop(
        tuple(Bar(tuple(a), tuple(b), m) for a, b, m in zip(pins, edges, masses, strict=True)),
        closing=(0, 0, 1),
    )


def bennett() -> Loop:
    """Bennett's linkage with twists of 60 and 30 degrees, as in `spatial_linkages.bg`."""
    twists = (np.pi / 3, np.pi / 6)
    lengths = (1.0, np.sin(twists[1]) / np.sin(twists[0]))
    turns = [Rotation.from_rotvec([twist, 0, 0]).as_matrix() for twist in twists]
    return Loop(
        tuple(
            Bar((0, 0, 1), (lengths[k % 2], 0, 0), mass, turns[k % 2])
            for k, mass in enumerate((1.0, 2.0, 3.0, 0.0))
        )
    )
