"""Inertia tensors: turned, checked, and added up over a tree."""

from __future__ import annotations

import math

import numpy as np

from bgc.diagnostics.catalogue.imported import odd_inertia, wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass
from bgc.runtime.importing.notes import Notes
from bgc.runtime.importing.robot import Body, Kind, Pose, Robot
from bgc.runtime.importing.rotation_text import Matrix, rows_of

_ROUNDING = 1e-9  # of the largest moment
_POINT = 1e-6  # m: radius of gyration below which moments are rounding of zero
_BALANCE = 1e-3  # of the largest moment, by which published numbers of flat parts are off


def body_of(
    mass: float, centre: Pose, tensor: Matrix, name: str, span: Span | None, notes: Notes
) -> Body | None:
    """Make a body of its inertial frame; None without mass and inertia.

    Raises BG138 for a negative mass; warns (BG549) of an inertia that no body has.
    """
    if mass < 0:
        help = "give a positive mass; a link without mass has no `<inertial>`"
        raise BgError([wrong_value(span, f"the mass of `{name}` is negative: {mass:g} kg", help)])
    if np.abs(tensor).max() <= mass * _POINT**2:
        tensor = np.zeros((3, 3))
    if mass == 0 and not tensor.any():
        return None
    if mass == 0:
        notes.add(odd_inertia(span, f"`{name}` has moments of inertia, but no mass"))
    moments = np.linalg.eigvalsh(tensor)
    if moments[0] < -_ROUNDING * abs(moments).max():
        notes.add(odd_inertia(span, f"`{name}` has the moment of inertia {moments[0]:.4g} kg m^2"))
    elif moments[2] > (moments[0] + moments[1]) * (1 + _BALANCE):
        what = (
            f"`{name}` has the moments of inertia {moments[0]:.4g}, {moments[1]:.4g} and "
            f"{moments[2]:.4g} kg m^2: the last exceeds the sum of the others"
        )
        notes.add(odd_inertia(span, what))
    turn = centre.axes.matrix
    turned = turn @ tensor @ turn.T if centre.axes.text else tensor
    turned = (turned + turned.T) / 2
    turned[np.abs(turned) < 1e-16 * np.abs(turned).max()] = 0
    return Body(mass, centre.origin, rows_of(turned), span)


def principal(body: Body) -> tuple[tuple[float, ...], Matrix] | None:
    """Return the positive principal moments and their axes (columns) of a singular body.

    None for a body with mass and moments about all axes, which is a `HeavyBody`.
    """
    moments, axes = np.linalg.eigh(np.array(body.inertia))
    largest = abs(moments).max()
    positive = moments > 1e-12 * largest
    if body.mass and (positive.all() or moments[0] < -_ROUNDING * largest):
        return None
    nearest = np.rint(axes)
    axes = np.where(np.abs(axes - nearest) < 1e-12, nearest, axes)[:, positive]
    return tuple(float(m) for m in moments[positive]), axes


@dataclass(frozen=True, slots=True)
class Carried:
    """Mass and inertia that a joint moves, where all coordinates are zero."""

    mass: float
    along_axis: float  # kg for a slide, kg m^2 about the axis of a hinge


def carried_by_joints(robot: Robot) -> dict[str, Carried]:
    """Return what each joint moves, by its child link."""
    places: dict[str, tuple[Matrix, Matrix]] = {robot.root: (np.zeros(3), np.eye(3))}
    for name, joint in robot.joints.items():
        r, axes = places[joint.parent]
        r, axes = r + axes @ joint.place.origin, axes @ joint.place.axes.matrix
        places[name] = r + axes @ joint.after, axes
    # Sums over each subtree, about the origin of the world: mass, first and second moments.
    masses = dict.fromkeys(robot.links, 0.0)
    firsts = {name: np.zeros(3) for name in robot.links}
    seconds = {name: np.zeros((3, 3)) for name in robot.links}
    for name in reversed(robot.links):
        body = robot.links[name].body
        if body is not None:
            r, axes = places[name]
            c = r + axes @ body.com
            masses[name] += body.mass
            firsts[name] += body.mass * c
            seconds[name] += axes @ np.array(body.inertia) @ axes.T + _about(body.mass, c)
        if name in robot.joints:
            parent = robot.joints[name].parent
            masses[parent] += masses[name]
            firsts[parent] += firsts[name]
            seconds[parent] += seconds[name]
    found = {}
    for name, joint in robot.joints.items():
        r, axes = places[joint.parent]
        pivot, direction = (
            r + axes @ joint.place.origin,
            axes @ joint.place.axes.matrix @ joint.axis,
        )
        mass = masses[name]
        along = mass
        if joint.kind is not Kind.SLIDES:
            # I about the pivot = I about the origin - terms of the shift
            shifted = seconds[name] - _cross_terms(firsts[name], pivot) + _about(mass, pivot)
            along = float(direction @ shifted @ direction)
        found[name] = Carried(mass, along + joint.rotor)
    return found


def _about(mass: float, c: Matrix) -> Matrix:
    """Inertia about the origin of a point mass at c."""
    return mass * (c @ c * np.eye(3) - np.outer(c, c))


def _cross_terms(first: Matrix, pivot: Matrix) -> Matrix:
    return 2 * (first @ pivot) * np.eye(3) - np.outer(first, pivot) - np.outer(pivot, first)


def rounded(value: float, digits: int = 2) -> float:
    """Round to significant digits."""
    if value == 0 or not math.isfinite(value):
        return value
    return float(f"{value:.{digits}g}")
