"""Split wide bonds into scalar ones that join elements directly, without ports and Muxes."""

from __future__ import annotations

from bgc.diagnostics.catalogue import graph
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.faces import Face, Joint, WideBond
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.tree import Element, PortEntry
from bgc.elaboration.instances.world import World
from bgc.ir.graph import Port
from bgc.language.elements import Family
from bgc.record_class import dataclass, field


@dataclass(frozen=True, slots=True)
class ScalarBond:
    """A scalar bond: component `component` (from 1) of a wide bond of `width` at its tail.

    `name` names the elements at its tail and head; `span` is that of the wide bond.
    """

    name: str
    component: int
    width: int
    span: Span


@dataclass(slots=True)
class Scalars:
    """The scalar bonds in source order.

    `of` maps each component (from 0) of each wide bond to the index of its scalar bond.
    """

    bonds: list[ScalarBond] = field(default_factory=list)
    of: dict[tuple[WideBond, int], int] = field(default_factory=dict)

    def at(self, joint: Joint) -> list[int]:
        """The indices of the scalar bonds at one end of a wide bond."""
        return [self.of[joint.bond, k] for k in range(len(joint.at))]

    def ports(self, face: Face) -> list[list[Port]]:
        """The ports at each component of a face: one each, or any number at a junction."""
        width = face.net.root().width
        assert width is not None
        found: list[list[Port]] = [[] for _ in range(width.size)]
        for joint in face.joints:
            sign = 1 if joint.is_head else -1
            for place, bond in zip(joint.at, self.at(joint), strict=True):
                found[place].append(Port(bond, sign))
        return found


def scalarise(world: World, wiring: Wiring) -> Scalars:
    """Number the scalar bonds, and report half arrows that meet head to head or tail to tail."""
    scalars = Scalars()
    opposite = _opposite_faces(wiring)
    met: set[Face] = set()
    for bond in wiring.bonds:
        if bond.tail.face in opposite:
            continue
        for k in range(len(bond.tail.at)):
            passed, end = _follow(world, wiring, opposite, bond, k, met)
            name = f"{bond.tail.face.name} -> {end.name}"
            index = len(scalars.bonds)
            scalars.bonds.append(ScalarBond(name, k + 1, len(bond.tail.at), bond.span))
            scalars.of.update(dict.fromkeys(passed, index))
    _report_parting(world, wiring, opposite)
    if not world.report.errors:
        for bond in wiring.bonds:
            if (bond, 0) not in scalars.of:
                world.report.add(graph.no_element_on_bond(bond.span, bond.name))
                break
    world.report.raise_new_errors()
    return scalars


def _report_parting(world: World, wiring: Wiring, opposite: dict[Face, Face]) -> None:
    """Report ports and Muxes that the bonds on both sides leave."""
    seen: set[Face] = set()
    for bond in wiring.bonds:
        face = bond.tail.face
        beyond = opposite.get(face)
        if beyond is None or face in seen:
            continue
        for joint in beyond.joints:
            if not joint.is_head and set(joint.at) & set(bond.tail.at):
                seen |= {face, beyond}
                parting = graph.arrows_meet(bond.span, face.name, joint.bond.span, leave=True)
                world.report.add(parting, note=note(wiring.owners[beyond].env))
                break


def _opposite_faces(wiring: Wiring) -> dict[Face, Face]:
    """Map each face of a port or Mux to the face on its other side."""
    found: dict[Face, Face] = {}
    for port in wiring.ports:
        found[port.outer], found[port.inner] = port.inner, port.outer
    for element in wiring.elements:
        if element.row.family is Family.BUNDLE:
            one, two = element.faces["in"], element.faces["out"]
            found[one], found[two] = two, one
    return found


def _follow(
    world: World,
    wiring: Wiring,
    opposite: dict[Face, Face],
    bond: WideBond,
    k: int,
    met: set[Face],
) -> tuple[list[tuple[WideBond, int]], Face]:
    """Follow one scalar bond from its tail through ports and Muxes.

    Returns the components of the wide bonds along it, and the face at its head. `met` collects the
    faces at which two half arrows meet, which are reported once for both.
    """
    passed = [(bond, k)]
    while True:
        bond, k = passed[-1]
        head = bond.head
        beyond = opposite.get(head.face)
        if beyond is None:
            return passed, head.face
        place = head.at[k]
        joint = next(j for j in beyond.joints if place in j.at)
        if joint.is_head:
            owner: Element | PortEntry = wiring.owners[beyond]
            if head.face in met:
                return passed, head.face
            met |= {head.face, beyond}
            world.report.add(
                graph.arrows_meet(head.bond.span, head.face.name, joint.bond.span, leave=False),
                note=note(owner.env),
            )
            return passed, head.face
        passed.append((joint.bond, joint.at.index(place)))
