"""Wide bonds to scalar ones: ports and Muxes dissolve, each scalar bond joins two elements."""

from __future__ import annotations

from dataclasses import dataclass, field

from bgc.diagnostics.catalogue import graph
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.faces import Face, Joint, WideBond
from bgc.elaboration.instances.instantiate import note
from bgc.elaboration.instances.tree import Element, PortEntry
from bgc.elaboration.instances.world import World
from bgc.ir.graph import Port


@dataclass(frozen=True, slots=True)
class ScalarBond:
    """One scalar bond: where it starts and ends, and the wide bond at its tail."""

    name: str
    component: int
    width: int
    span: Span


@dataclass(slots=True)
class Scalars:
    """The scalar bonds in reading order, and for each component of a wide bond its scalar one."""

    bonds: list[ScalarBond] = field(default_factory=list)
    of: dict[tuple[WideBond, int], int] = field(default_factory=dict)

    def at(self, joint: Joint) -> list[int]:
        """The scalar bonds of one end of a wide bond."""
        return [self.of[joint.bond, k] for k in range(len(joint.at))]

    def ports(self, face: Face) -> list[list[Port]]:
        """The ports at each component of a face: one each, at a junction any number."""
        width = face.net.root().width
        assert width is not None
        found: list[list[Port]] = [[] for _ in range(width.size)]
        for joint in face.joints:
            sign = 1 if joint.is_head else -1
            for place, bond in zip(joint.at, self.at(joint), strict=True):
                found[place].append(Port(bond, sign))
        return found


def scalarise(world: World, wiring: Wiring) -> Scalars:
    """Number the scalar bonds; arrows that meet at a port are reported."""
    scalars = Scalars()
    across = _across(wiring)
    for bond in wiring.bonds:
        if bond.tail.face in across:
            continue
        for k in range(len(bond.tail.at)):
            passed, end = _follow(world, wiring, across, bond, k)
            name = f"{bond.tail.face.name} -> {end.name}"
            index = len(scalars.bonds)
            scalars.bonds.append(ScalarBond(name, k + 1, len(bond.tail.at), bond.span))
            scalars.of.update(dict.fromkeys(passed, index))
    if not world.report.errors:
        for bond in wiring.bonds:
            if (bond, 0) not in scalars.of:
                world.report.add(graph.no_element_on_bond(bond.span, bond.name))
                break
    world.report.raise_new_errors()
    return scalars


def _across(wiring: Wiring) -> dict[Face, Face]:
    """For the faces of ports and Muxes, the face on the other side."""
    found: dict[Face, Face] = {}
    for port in wiring.ports:
        found[port.outer], found[port.inner] = port.inner, port.outer
    for element in wiring.elements:
        if element.kind in {"Mux", "Demux"}:
            one, two = element.faces["in"], element.faces["out"]
            found[one], found[two] = two, one
    return found


def _follow(
    world: World, wiring: Wiring, across: dict[Face, Face], bond: WideBond, k: int
) -> tuple[list[tuple[WideBond, int]], Face]:
    """The components of wide bonds that one scalar bond runs through, and where it ends."""
    passed = [(bond, k)]
    while True:
        bond, k = passed[-1]
        head = bond.head
        beyond = across.get(head.face)
        if beyond is None:
            return passed, head.face
        place = head.at[k]
        joint = next(j for j in beyond.joints if place in j.at)
        if joint.is_head:
            owner: Element | PortEntry = wiring.owners[beyond]
            world.report.add(
                graph.arrows_meet(head.bond.span, head.face.name, joint.bond.span),
                note=note(owner.env),
            )
            return passed, head.face
        passed.append((joint.bond, joint.at.index(place)))
