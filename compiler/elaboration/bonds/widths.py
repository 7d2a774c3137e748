"""Infer the widths and domains of all bonds.

A width is known from brackets, from a domain, or from the shape of an element's arguments or law.
It propagates along bonds and through junctions and ports; a width that remains unknown is 1.
"""

from __future__ import annotations

from bgc.diagnostics.catalogue import graph
from bgc.diagnostics.catalogue import widths as width_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.domains import Domains
from bgc.elaboration.bonds.shape_probe import Probe, WidthUnknown, probe
from bgc.elaboration.bonds.wiring import Wiring, check_single
from bgc.elaboration.instances.faces import DomainUse, Face, Net, Width
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.limits import MAX_WIDTH
from bgc.elaboration.instances.tree import Element, PortEntry
from bgc.elaboration.instances.world import World
from bgc.language.elements import Family
from bgc.record_class import dataclass, field


@dataclass(slots=True)
class Nets:
    """The nets of all bonds, and the constraints that are not settled by joining nets.

    Attributes
    ----------
    equal
        Pairs of nets with equal widths, at a Mux or an element with both sides of one width.
    divided
        Faces that several bonds or slices divide; without slices their widths add up.
    sized
        Faces whose width is known from brackets, arguments or a law: several bonds may share it.
    """

    world: World
    wiring: Wiring
    domains: Domains
    equal: list[tuple[Net, Net, Span]] = field(default_factory=list)
    divided: list[Face] = field(default_factory=list)
    sized: set[Face] = field(default_factory=set)


def join_nets(world: World, wiring: Wiring, domains: Domains) -> Nets:
    """Join nets of common width and domain, and set the widths of ports and brackets."""
    nets = Nets(world, wiring, domains)
    for port in wiring.ports:
        with world.report.collecting(note(port.env)):
            _declare_port(nets, port)
    for element in wiring.elements:
        with world.report.collecting(note(element.env)):
            _declare_element(nets, element)
    _join(nets)
    return nets


def settle_widths(nets: Nets) -> None:
    """Give every net a width, and every end of a bond its components of the face there."""
    world = nets.world
    _propagate(nets)
    _probe_all(nets)
    check_single(world, nets.wiring, nets.sized)
    world.report.raise_new_errors()
    _default_to_one(nets)
    _assign_components(nets)
    world.report.raise_new_errors()


# --- declared widths --------------------------------------------------------------------


def _declare_port(work: Nets, port: PortEntry) -> None:
    declaration = port.declaration
    net = port.outer.net
    _merge(work, net, port.inner.net, declaration.name_span)
    if declaration.domain is not None:
        declared = port.env.module.domains[declaration.domain]
        facts = work.domains.facts(declared)
        _set_domain(work, net, DomainUse(declared, declaration.span))
        _set_width(work, net, Width(facts.width, declaration.span, facts.width > 1))
    if declaration.dims:
        size = 1
        for dim in declaration.dims:
            size *= work.world.whole(dim, port.env, "a width", 1, MAX_WIDTH)
        _set_width(work, net, Width(size, declaration.span, True))


def _declare_element(work: Nets, element: Element) -> None:
    dims, span = element.dims, element.use.span
    if element.row.family is Family.BUNDLE:
        into, out = element.faces["in"], element.faces["out"]
        work.equal.append((into.net, out.net, element.span))
        if dims:
            total = Width(sum(dims), span, True)
            _set_width(work, into.net, total)
            _set_width(work, out.net, total)
            many = into if len(into.joints) >= len(out.joints) else out
            if len(dims) > 1 or len(many.joints) == 1:
                if len(many.joints) != len(dims):
                    sizes = [1] * len(many.joints)
                    raise BgError(
                        [graph.mux_count(element.span, element.path, len(dims), len(sizes))]
                    )
                for joint, size in zip(many.joints, dims, strict=True):
                    _set_width(work, joint.bond.net, Width(size, span, False))
        return
    if not dims:
        return
    work.sized.update(element.faces.values())
    if len(dims) == 2:
        for side, size in zip(("in", "out"), dims, strict=True):
            _set_width(work, element.faces[side].net, Width(size, span, size > 1))
    else:
        for face in element.faces.values():
            _set_width(work, face.net, Width(dims[0], span, True))


def _join(work: Nets) -> None:
    """Join the net of each bond with that of a face which it takes whole."""
    for face in work.wiring.owners:
        for joint in face.joints:
            if joint.slice is not None:
                size = Width(len(joint.slice), joint.span, len(joint.slice) > 1)
                _set_width(work, joint.bond.net, size)
            elif face.junction or len(face.joints) == 1:
                _merge(work, joint.bond.net, face.net, joint.bond.span)
        if not face.junction and (len(face.joints) > 1 or any(j.slice for j in face.joints)):
            work.divided.append(face)


# --- joining ----------------------------------------------------------------------------


def _set_width(work: Nets, net: Net, width: Width) -> bool:
    """Set the width of a net, or report a contradiction; True if it was unknown."""
    net = net.root()
    if net.width is None:
        net.width = width
        return True
    if net.width.size != width.size:
        work.world.report.add(
            width_messages.widths_differ(
                width.span, net.width.size, net.width.span, width.size, width.span
            )
        )
    elif width.explicit and not net.width.explicit:
        net.width = width
    return False


def _set_domain(work: Nets, net: Net, use: DomainUse) -> None:
    net = net.root()
    if net.domain is None:
        net.domain = use
    elif net.domain.declared.syntax is not use.declared.syntax:
        one, two = net.domain, use
        work.world.report.add(
            width_messages.domains_differ(
                use.span, one.declared.syntax.name, one.span, two.declared.syntax.name, two.span
            )
        )


def _merge(work: Nets, one: Net, two: Net, span: Span) -> None:
    """Join two nets, or report their contradicting widths or domains at `span`."""
    one, two = one.root(), two.root()
    if one is two:
        return
    if one.width is not None and two.width is not None and one.width.size != two.width.size:
        work.world.report.add(
            width_messages.widths_differ(
                span, one.width.size, one.width.span, two.width.size, two.width.span
            )
        )
        return
    if (
        one.domain is not None
        and two.domain is not None
        and one.domain.declared.syntax is not two.domain.declared.syntax
    ):
        work.world.report.add(
            width_messages.domains_differ(
                span,
                one.domain.declared.syntax.name,
                one.domain.span,
                two.domain.declared.syntax.name,
                two.domain.span,
            )
        )
        return
    one.absorb(two)
    if one.width is None or (two.width is not None and two.width.explicit):
        one.width = two.width or one.width
    one.domain = one.domain or two.domain


# --- propagation ------------------------------------------------------------------------


def _propagate(work: Nets) -> None:
    """Apply equal widths and sums of widths until nothing changes."""
    changed = True
    while changed:
        changed = False
        for one, two, span in work.equal:
            a, b = one.root().width, two.root().width
            if a is not None and b is None:
                changed |= _set_width(work, two, Width(a.size, a.span, False))
            elif b is not None and a is None:
                changed |= _set_width(work, one, Width(b.size, b.span, False))
            elif a is not None and b is not None and a.size != b.size:
                work.world.report.add(
                    width_messages.widths_differ(span, a.size, a.span, b.size, b.span)
                )
        work.equal = [
            s for s in work.equal if s[0].root().width is None or s[1].root().width is None
        ]
        for face in work.divided:
            changed |= _settle_divided(work, face)


def _settle_divided(work: Nets, face: Face) -> bool:
    if any(joint.slice is not None for joint in face.joints):
        if face.net.root().width is not None:
            return False
        size = 1 + max(max(j.slice) for j in face.joints if j.slice)
        return _set_width(work, face.net, Width(size, face.joints[0].span, False))
    widths = [joint.bond.net.root().width for joint in face.joints]
    total = face.net.root().width
    known = [w.size for w in widths if w is not None]
    if len(known) == len(widths):
        if total is not None:
            return False  # checked when components are assigned
        return _set_width(work, face.net, Width(sum(known), face.joints[0].span, False))
    if total is not None and len(known) == len(widths) - 1 and total.size > sum(known):
        missing = widths.index(None)
        left = Width(total.size - sum(known), total.span, False)
        return _set_width(work, face.joints[missing].bond.net, left)
    return False


def _probe_all(work: Nets) -> None:
    """Infer widths from the arguments and laws of all elements."""
    waiting = list(work.wiring.elements)
    while waiting:
        later: list[Element] = []
        for element in waiting:
            if element.row.family in (Family.JUNCTION, Family.BUNDLE):
                continue
            try:
                found = probe(work.world, element)
            except WidthUnknown:
                later.append(element)
            except BgError:
                continue  # reported when the law is read
            else:
                _apply_probe(work, element, found)
        _propagate(work)
        if len(later) < len(waiting):
            waiting = later
            continue
        # The remaining elements need widths that are not implied anywhere: first set the nets of
        # all other elements to 1, and if there are none, their own.
        held = {id(f.net.root()) for e in later for f in e.faces.values()}
        nets = [n for n in _unsized_nets(work) if id(n) not in held] or _unsized_nets(work)
        if not nets:
            break
        for net in nets:
            _set_width(work, net, Width(1, later[0].span, False))
        _propagate(work)


def _apply_probe(work: Nets, element: Element, found: Probe) -> None:
    for side, size in found.sizes.items():
        face = element.faces.get(side) or element.faces["in"]
        work.sized.add(face)
        if face.net.root().width is None:  # else a mismatch is reported when the law is read
            _set_width(work, face.net, Width(size, found.span, size > 1))
    if found.same and not element.is_gyristor:
        work.equal.append((element.faces["in"].net, element.faces["out"].net, element.span))


def _unsized_nets(work: Nets) -> list[Net]:
    """The nets without a width, except those of divided faces, whose width follows from others."""
    totals = {id(f.net.root()) for f in work.divided}
    found: dict[int, Net] = {}
    for bond in work.wiring.bonds:
        net = bond.net.root()
        if net.width is None and id(net) not in totals:
            found[id(net)] = net
    for face in work.wiring.owners:
        net = face.net.root()
        if net.width is None and id(net) not in totals:
            found[id(net)] = net
    return list(found.values())


def _default_to_one(work: Nets) -> None:
    """Set every width that remains unknown to 1."""
    while True:
        nets = _unsized_nets(work)
        for net in nets:
            net.width = Width(1, work.wiring.bonds[0].span, False)
        _propagate(work)
        if not nets:
            break


# --- components -------------------------------------------------------------------------


def _assign_components(work: Nets) -> None:
    """Give each joint its components of the face; each component must be taken exactly once."""
    for face, owner in work.wiring.owners.items():
        width = face.net.root().width
        if not face.joints or width is None:
            continue
        offset = 0
        taken: list[int] = []
        outside = False
        for joint in face.joints:
            bond_width = joint.bond.net.root().width
            assert bond_width is not None
            if joint.slice is not None:
                joint.at = joint.slice
                if max(joint.at) >= width.size:
                    outside = True
                    work.world.report.add(
                        width_messages.slice_outside(
                            joint.span, face.name, max(joint.at) + 1, width.size
                        ),
                        note=note(owner.env),
                    )
            elif face.junction:
                joint.at = tuple(range(width.size))
            else:
                joint.at = tuple(range(offset, offset + bond_width.size))
                offset += bond_width.size
            taken.extend(joint.at)
        complete = face.junction or sorted(taken) == list(range(width.size))
        if not complete and not outside:
            parts = [len(joint.at) for joint in face.joints]
            work.world.report.add(
                width_messages.widths_do_not_add_up(face.span, face.name, width.size, parts),
                note=note(owner.env),
            )
