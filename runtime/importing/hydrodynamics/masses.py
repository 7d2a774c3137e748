"""Mass properties and dimensions of a ship: those of the data, and estimates of what they lack."""

from __future__ import annotations

import numpy as np

from bgc.diagnostics.catalogue.imported import wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.importing.hydrodynamics.account import Account
from bgc.runtime.importing.hydrodynamics.checks import LONG, size
from bgc.runtime.importing.hydrodynamics.record import Hull, Real

_GYRATION = (0.35, 0.25, 0.25)  # radii by breadth, length, length: usual for ships
_HELP = "set `mass`, `centre` and `radii` of the ship in its `.bg` file"


@dataclass(frozen=True, slots=True)
class Box:
    """Length, breadth and draught (m) of the box with the hull's water plane and volume."""

    length: float
    breadth: float
    draught: float


@dataclass(frozen=True, slots=True)
class RigidBody:
    """Mass (kg), its centre and radii of gyration about it (m), in the axes of the ship."""

    mass: float
    centre: Real
    radii: Real
    estimated: bool

    @property
    def matrix(self) -> Real:
        """The (6, 6) mass matrix about the origin."""
        x, y, z = self.centre
        skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        inertia = self.mass * (np.diag(self.radii**2) - skew @ skew)
        return np.block([[self.mass * np.eye(3), -self.mass * skew], [self.mass * skew, inertia]])


def box_of(hull: Hull, mass: float) -> Box:
    """Estimate the dimensions from the stiffness and the mass of the displaced water."""
    stiffness = hull.stiffness
    assert stiffness is not None
    plane = stiffness[2, 2] / (hull.density * hull.gravity)
    about = stiffness[2, 4] ** 2 / stiffness[2, 2]  # moved to the centre of the water plane
    length = np.sqrt(12 * max(stiffness[4, 4] - about, 0) / stiffness[2, 2])
    length = min(max(length, np.sqrt(plane)), 10 * np.sqrt(plane))
    draught = mass / (hull.density * plane)
    return Box(float(length), float(plane / length), float(draught))


def displaced_mass(hull: Hull, account: Account) -> float:
    """Return the mass of the displaced water, given or from the force of the longest wave."""
    if hull.volume:
        return hull.density * hull.volume
    if hull.mass is not None:
        return float(hull.mass[0, 0])
    if hull.stiffness is not None and hull.centre_of_buoyancy is None:
        account.missing("displaced volume")
    k, added = hull.wave_number[0], hull.added_mass[0]
    ahead, aside = np.cos(hull.heading), np.sin(hull.heading)
    force = hull.force[0, :, 0] * ahead + hull.force[0, :, 1] * aside
    water = added[0, 0] * ahead**2 + added[1, 1] * aside**2 + 2 * added[0, 1] * ahead * aside
    mass = float(np.median(force.imag / (k * hull.gravity) - water))
    if not mass > 0:
        what = "neither the mass nor the displaced volume can be found in the data"
        help = "add a file that holds one of them, or lower frequencies"
        raise BgError([wrong_value(None, what, help)])
    rough = ", which is short" if k * size(hull) > LONG else ""
    what = f"a mass of {mass:.4g} kg, from the horizontal force of the longest wave{rough}"
    account.assumed(what, _HELP)
    return mass


def rigid_body(hull: Hull, account: Account) -> RigidBody:
    """Return mass, centre and radii of a hull about its origin, given or estimated."""
    displaced = displaced_mass(hull, account)
    found = _given(hull)
    if found is not None:
        off = abs(found.mass / displaced - 1)
        cause = "the mass is taken as it is: with another draught the other data change as well"
        account.checked("mass and displaced water", off, 0.02, cause)
        return found
    box = box_of(hull, displaced)
    mass = displaced if hull.mass is None else float(hull.mass[0, 0])
    centre = np.zeros(3)
    if hull.centre_of_gravity is not None:
        centre = hull.centre_of_gravity - hull.origin
    elif hull.centre_of_buoyancy is not None:
        centre[:2] = (hull.centre_of_buoyancy - hull.origin)[:2]
        account.assumed("the centre of gravity in the surface, above that of buoyancy", _HELP)
    else:
        account.assumed("the centre of gravity at the origin, in the surface", _HELP)
    sides = [box.breadth, box.length, box.length]
    radii = np.array([factor * side for factor, side in zip(_GYRATION, sides, strict=True)])
    shown = ", ".join(f"{radius:.3g}" for radius in radii)
    account.assumed(f"radii of gyration {shown} m: 0.35 breadth, 0.25 length, 0.25 length", _HELP)
    return RigidBody(mass, centre, radii, estimated=True)


def _given(hull: Hull) -> RigidBody | None:
    """Return the rigid body of a mass matrix that has moments of inertia."""
    m = hull.mass
    if m is None or np.diagonal(m).min() <= 1e-9 * m[0, 0]:
        return None
    mass = float(m[0, 0])
    centre = np.array([-m[2, 4], -m[0, 5], m[0, 4]]) / mass
    x, y, z = centre
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    moments = np.diagonal(m[3:, 3:] + mass * skew @ skew)
    if moments.min() <= 0:
        return None
    return RigidBody(mass, centre, np.sqrt(moments / mass), estimated=False)
