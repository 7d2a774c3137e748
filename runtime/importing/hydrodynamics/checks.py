"""Checks of hydrodynamic data against each other: conventions read wrongly do not pass them.

Equations as in Newman, Marine Hydrodynamics (1977), 6.15-6.18, and Falnes, Ocean Waves and
Oscillating Systems (2002), 5.4-5.6.
"""

from __future__ import annotations

import numpy as np

from bgc.diagnostics.catalogue.imported import wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.importing.hydrodynamics.account import Account
from bgc.runtime.importing.hydrodynamics.record import MODES, Hull, Real, motions

LONG = 0.5  # wave number times size of the hull below which a wave counts as long
_WIDEST = 1.1  # rad between headings over which the energy of radiated waves is integrated
_PATTERN = 0.25  # wave number times size of the hull for each heading around it, at most


def check(hull: Hull, account: Account) -> None:
    """Check data as they were read, before they are made symmetric.

    Raises
    ------
    BgError
        BG138 where the damping supplies energy at most frequencies, or mass and added mass have no
        positive kinetic energy.
    """
    scale = scales(hull)
    _check_symmetry(hull, scale, account)
    _check_damping(hull, scale, account)
    _check_inertia(hull)
    _check_long_waves(hull, account)
    _check_energy(hull, scale, account)
    if hull.haskind is not None:
        largest = np.abs(hull.force).max(axis=(0, 1)) + 1e-3 * _force_scale(hull)
        off = np.abs(hull.haskind - hull.force).max(axis=(0, 1)) / largest
        cause = "the forces by diffraction are taken: refine the mesh where they differ much"
        account.checked(
            f"exciting forces by Haskind and by diffraction, {_of(off)}", off.max(), 0.1, cause
        )
    _check_motion(hull, account)


def size(hull: Hull) -> float:
    """Return a length of the hull: the root of its water plane, or of the added mass."""
    plane = 0.0
    if hull.stiffness is not None:
        plane = float(hull.stiffness[2, 2] / (hull.density * hull.gravity))
    if plane > 0:
        return float(np.sqrt(plane))
    return float(np.cbrt(np.abs(hull.added_mass[:, 2, 2]).max() / hull.density))


def scales(hull: Hull) -> Real:
    """Return roots of masses and moments that make the modes comparable."""
    sway = np.abs(hull.added_mass[:, [0, 1, 2], [0, 1, 2]]).max()
    least = 0.1 * np.sqrt(sway) * np.array([1, 1, 1, *[0.3 * size(hull)] * 3])
    diagonal = np.abs(np.diagonal(hull.added_mass, axis1=1, axis2=2)).max(axis=0)
    return np.asarray(np.maximum(np.sqrt(diagonal), least))


def _force_scale(hull: Hull) -> Real:
    length = size(hull)
    force = hull.density * hull.gravity * length**2
    return force * np.array([1, 1, 1, *[length] * 3])


def _of(off: Real) -> str:
    return MODES[int(np.argmax(off))]


def _check_symmetry(hull: Hull, scale: Real, account: Account) -> None:
    for name, m in (("added mass", hull.added_mass), ("damping", hull.damping)):
        scaled = m / np.outer(scale, scale)
        largest = np.abs(scaled).max()
        off = np.abs(scaled - scaled.swapaxes(1, 2)).max() / (largest or 1.0)
        cause = "their symmetric part is taken: refine the mesh, or check the degrees of freedom"
        account.checked(f"{name} and its transpose", off, 0.05, cause)


def _check_damping(hull: Hull, scale: Real, account: Account) -> None:
    scaled = hull.damping / np.outer(scale, scale)
    roots = np.linalg.eigvalsh((scaled + scaled.swapaxes(1, 2)) / 2)
    if np.median(roots.sum(axis=1)) < 0:
        what = "the radiated waves supply energy: the damping has the wrong sign"
        help = "check the sign convention of the program that wrote the file"
        raise BgError([wrong_value(None, what, help)])
    off = float(abs(min(roots.min(), 0.0)) / (np.abs(roots).max() or 1.0))
    worst = hull.frequency[int(np.argmin(roots.min(axis=1)))]
    cause = (
        f"negative damping, at {worst:.3g} rad/s: an irregular frequency or a coarse mesh; "
        "remove that frequency"
    )
    account.checked("damping and a passive one", off, 0.03, cause)


def _check_inertia(hull: Hull) -> None:
    if hull.mass is None:
        return
    whole = hull.mass + hull.added_mass
    if np.linalg.eigvalsh((whole + whole.swapaxes(1, 2)) / 2).min() <= 0:
        what = "mass and added mass have a negative kinetic energy"
        help = "check the mass matrix, its units and the point it refers to"
        raise BgError([wrong_value(None, what, help)])


def _check_long_waves(hull: Hull, account: Account) -> None:
    """Compare with a long wave, which lifts the hull as still water does and drags it along."""
    k, length = hull.wave_number[0], size(hull)
    name = "forces of long waves"
    if k * length > LONG:
        account.unchecked(name, f"the lowest frequency is {hull.frequency[0]:.3g} rad/s")
        return
    cause = "check density, gravity, length scale, and the time dependence and axes of the forces"
    force = hull.force[0]
    if hull.stiffness is not None:
        off = np.abs(force[:, 2] / hull.stiffness[2, 2] - 1).max()
        account.checked(
            "heave force on long waves and stiffness", float(off), 0.1 + k * length, cause
        )
    ahead, aside = np.cos(hull.heading), np.sin(hull.heading)
    along = force[:, 0] * ahead + force[:, 1] * aside  # leads the crest by a quarter
    mass = displaced(hull)
    if mass is None:
        off = float((along.imag < 0).any() or (np.abs(along.real) > np.abs(along.imag)).any())
        account.checked(
            "phase of horizontal forces on long waves and a quarter period", off, 0.5, cause
        )
        return
    a = hull.added_mass[0]
    whole = mass + a[0, 0] * ahead**2 + a[1, 1] * aside**2 + 2 * a[0, 1] * ahead * aside
    off = float(np.abs(along / (1j * k * hull.gravity * whole) - 1).max())
    account.checked("horizontal forces on long waves and inertia", off, 0.1 + k * length, cause)


def displaced(hull: Hull) -> float | None:
    """Return the mass of the displaced water, or that of the hull."""
    if hull.volume:
        return hull.density * hull.volume
    return None if hull.mass is None else float(hull.mass[0, 0])


def _check_energy(hull: Hull, scale: Real, account: Account) -> None:
    """Compare the damping with the waves that the exciting forces say the hull radiates."""
    name = "damping and exciting forces by Haskind's relation"
    k = hull.wave_number
    some = k * size(hull) < _PATTERN * len(hull.heading)
    steps = np.diff(np.append(hull.heading, hull.heading[0] + 2 * np.pi))
    if steps.max() > _WIDEST or not some.any():
        account.unchecked(name, "for want of headings around the hull")
        return
    deep = np.ones_like(k)
    if np.isfinite(hull.depth):
        deep = 1 + 2 * k * hull.depth / np.sinh(np.minimum(2 * k * hull.depth, 500.0))
    speed = hull.frequency / (2 * k) * deep
    weight = (steps + np.roll(steps, 1)) / 2
    radiated = np.einsum("h,nhi->ni", weight, np.abs(hull.force) ** 2)
    found = (k / (8 * np.pi * hull.density * hull.gravity * speed))[:, None] * radiated
    damping = np.diagonal(hull.damping, axis1=1, axis2=2)
    largest = np.maximum(np.abs(damping).max(axis=0), 0.01 * scale**2 * hull.frequency.mean())
    off = (np.abs(found - damping)[some] / largest).max(axis=0)
    cause = "check density, units, and the point that moments refer to; or refine the mesh"
    account.checked(f"{name}, {_of(off)}", float(off.max()), 0.15, cause)


def _check_motion(hull: Hull, account: Account) -> None:
    name = "motions and those of forces and matrices"
    if hull.motion is None:
        return
    if hull.mass is None or hull.stiffness is None:
        account.unchecked(name, "for want of mass or stiffness")
        return
    found = motions(hull, hull.mass, hull.stiffness)
    length = size(hull)
    largest = np.maximum(np.abs(hull.motion).max(axis=(0, 1)), [0.01] * 3 + [0.01 / length] * 3)
    off = (np.abs(found - hull.motion) / largest).max(axis=(0, 1))
    cause = "the program used another mass, stiffness or damping than its files hold"
    account.checked(f"{name}, {_of(off)}", float(off.max()), 0.05, cause)
