"""`Hull`: hydrodynamic data of one rigid hull, in one convention for all programs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bgc.record_class import dataclass, replace

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass(frozen=True, slots=True, kw_only=True)
class Hull:
    """Hydrodynamic data of one rigid hull at zero speed.

    SI units. Axes are x forward, y to port, z up from still water; matrices, forces and motions
    are about `origin`, a point in the axes of the program. A quantity is the real part of its
    complex amplitude times exp(+i w t). A heading is the direction into which the waves travel,
    from x towards y. Forces and motions are those on a wave of amplitude 1 m whose crest passes
    the place `crest` at t = 0.

    Attributes
    ----------
    frequency, added_mass, damping
        n ascending frequencies (rad/s), and (n, 6, 6) matrices of the radiated waves.
    added_mass_zero, added_mass_infinite
        Added mass (6, 6) at the frequencies zero and infinity.
    heading, force
        m ascending headings in [0, 2 pi) (rad), and exciting forces (n, m, 6).
    haskind, motion
        Exciting forces by the relation of Haskind, and motions (m, rad) of the program.
    stiffness, mass, drag
        (6, 6): hydrostatic stiffness with the weight, mass of the rigid body, and damping of
        other causes than waves.
    volume, centre_of_gravity, centre_of_buoyancy
        Displaced volume (m^3), and points in the axes of the program (m).
    """

    name: str
    program: str
    density: float
    gravity: float
    frequency: Real
    added_mass: Real
    damping: Real
    heading: Real
    force: Complex
    origin: Real
    depth: float = np.inf
    crest: tuple[float, float] = (0.0, 0.0)
    added_mass_zero: Real | None = None
    added_mass_infinite: Real | None = None
    haskind: Complex | None = None
    motion: Complex | None = None
    stiffness: Real | None = None
    mass: Real | None = None
    drag: Real | None = None
    volume: float | None = None
    centre_of_gravity: Real | None = None
    centre_of_buoyancy: Real | None = None

    @property
    def wave_number(self) -> Real:
        """Wave numbers of the frequencies, 1/m."""
        return wave_numbers(self.frequency, self.depth, self.gravity)


def wave_numbers(frequency: Real, depth: float, gravity: float) -> Real:
    """Solve w^2 = g k tanh(k h) for k by Newton's method from above."""
    deep = frequency**2 / gravity
    if not np.isfinite(depth):
        return deep
    y = deep * depth
    x = np.maximum(y, np.sqrt(y))  # above the root of x tanh(x) = y
    for _ in range(50):
        t = np.tanh(x)
        x = x - (x * t - y) / (t + x * (1 - t * t))
    return np.asarray(x / depth)


def rigid_transfer(offset: Real) -> Real:
    """Return the (6, 6) matrix from the twist at a point to that at `offset` from it."""
    x, y, z = offset
    transfer = np.eye(6)
    transfer[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    return transfer


def moved(hull: Hull, origin: Real) -> Hull:
    """Refer a hull to another origin, and its waves to a crest there."""
    t = rigid_transfer(hull.origin - origin)
    inverse = rigid_transfer(origin - hull.origin)
    along = np.cos(hull.heading) * (origin[0] - hull.crest[0])
    along = along + np.sin(hull.heading) * (origin[1] - hull.crest[1])
    phase = np.exp(1j * np.outer(hull.wave_number, along))[:, :, None]

    def matrix(m: Any) -> Any:
        return None if m is None else t.T @ m @ t

    return replace(
        hull,
        origin=origin,
        crest=(float(origin[0]), float(origin[1])),
        added_mass=matrix(hull.added_mass),
        damping=matrix(hull.damping),
        added_mass_zero=matrix(hull.added_mass_zero),
        added_mass_infinite=matrix(hull.added_mass_infinite),
        stiffness=matrix(hull.stiffness),
        mass=matrix(hull.mass),
        drag=matrix(hull.drag),
        force=(hull.force * phase) @ t,
        haskind=None if hull.haskind is None else (hull.haskind * phase) @ t,
        motion=None if hull.motion is None else (hull.motion * phase) @ inverse.T,
    )


def symmetrised(hull: Hull) -> Hull:
    """Replace each matrix by its symmetric part."""

    def half(m: Any) -> Any:
        return None if m is None else (m + m.swapaxes(-1, -2)) / 2

    return replace(
        hull,
        added_mass=half(hull.added_mass),
        damping=half(hull.damping),
        added_mass_zero=half(hull.added_mass_zero),
        added_mass_infinite=half(hull.added_mass_infinite),
        stiffness=half(hull.stiffness),
        mass=half(hull.mass),
        drag=half(hull.drag),
    )


def motions(hull: Hull, mass: Real, stiffness: Real) -> Complex:
    """Return the (n, m, 6) motions that the forces and matrices give, per metre of wave."""
    w = hull.frequency[:, None, None]
    drag = 0.0 if hull.drag is None else hull.drag
    impedance = -(w**2) * (mass + hull.added_mass) + 1j * w * (hull.damping + drag) + stiffness
    found = np.linalg.solve(impedance, hull.force.swapaxes(1, 2))
    return np.asarray(found.swapaxes(1, 2))
