"""Resolve the chains of all models to wide bonds between faces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

from bgc.diagnostics.catalogue import graph, laws, names, with_article
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Edit
from bgc.elaboration.instances.faces import Face, Joint, Net, WideBond
from bgc.elaboration.instances.instance_notes import note, note_of
from bgc.elaboration.instances.limits import MAX_WIDTH
from bgc.elaboration.instances.scopes import part_at, path_of
from bgc.elaboration.instances.tree import (
    Element,
    Environment,
    Instance,
    PartArray,
    Pending,
    PortEntry,
    Quantity,
)
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.language.elements import Family
from bgc.record_class import dataclass, field, replace

# No port for an arrow in this direction, an arrow against a port, an arrow out of a C, I or R.
_REVERSIBLE = ("BG403", "BG404", "BG405")

Target: TypeAlias = Instance | Element | PartArray | tuple[PortEntry, bool]  # bool: inside


@dataclass(slots=True, eq=False)
class Wiring:
    """All instances, elements, ports and wide bonds, in source order.

    `owners` maps each face to its element or port.
    """

    instances: list[Instance] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)
    ports: list[PortEntry] = field(default_factory=list)
    bonds: list[WideBond] = field(default_factory=list)
    owners: dict[Face, Element | PortEntry] = field(default_factory=dict)


def wire(world: World, root: Instance) -> Wiring:
    """Build every part of the tree and every bond of its chains; errors are reported."""
    wiring = Wiring()
    for instance in _walk(world, root, wiring):
        wiring.instances.append(instance)
    for instance in wiring.instances:
        for chain, env in instance.written(syntax.Chain):
            for tail, head in chain.links:
                with world.report.collecting(note(env)):
                    _bond(world, wiring, env, tail, head)
    _check_bonded(world, root, wiring)
    return wiring


def _walk(world: World, instance: Instance, wiring: Wiring) -> Iterator[Instance]:
    """The instance and all instances below it; their elements and ports enter `wiring`."""
    yield instance
    for member in list(instance.members.values()):
        match member:
            case PortEntry():
                wiring.ports.append(member)
                wiring.owners[member.outer] = wiring.owners[member.inner] = member
            case Pending():
                yield from _walk_part(world, member, wiring)
            case PartArray():
                for pending in member.parts.values():
                    yield from _walk_part(world, pending, wiring)
            case Quantity():
                pass


def _walk_part(world: World, pending: Pending, wiring: Wiring) -> Iterator[Instance]:
    with world.report.collecting(note(pending.env)):
        built = world.builder.build(pending)
        if isinstance(built, Instance):
            yield from _walk(world, built, wiring)
        else:
            wiring.elements.append(built)
            for face in built.faces.values():
                wiring.owners[face] = built


# --- ends of bonds ----------------------------------------------------------------------


def _bond(
    world: World, wiring: Wiring, env: Environment, tail: syntax.Expr, head: syntax.Expr
) -> None:
    ends = []
    failed: list[BgError] = []
    for expr, is_head in ((tail, False), (head, True)):
        try:
            ends.append(_end(world, env, expr, is_head))
        except BgError as err:
            failed.append(err)
    if failed:
        found = [d for err in failed for d in err.diagnostics]
        if any(d.code in _REVERSIBLE for d in found):
            edits = _exchanged(world, env, tail, head)
            found = [replace(d, edits=edits) if d.code in _REVERSIBLE else d for d in found]
        raise BgError(found)
    (tail_face, tail_slice), (head_face, head_slice) = ends
    bond = WideBond(f"{tail_face.name} -> {head_face.name}", tail.span.to(head.span), Net())
    bond.ends = [
        Joint(tail_face, bond, False, tail_slice, tail.span),
        Joint(head_face, bond, True, head_slice, head.span),
    ]
    for joint in bond.ends:
        joint.face.joints.append(joint)
    wiring.bonds.append(bond)


def _exchanged(
    world: World, env: Environment, tail: syntax.Expr, head: syntax.Expr
) -> tuple[Edit, ...]:
    """The bond with its arrow reversed, where it is a statement of its own and is right that way.

    In a longer chain the other bonds would be reversed too.
    """
    text = tail.span.source.text
    between = text[tail.span.end : head.span.start]
    begins = text[: tail.span.start].rstrip()[-1:] in {";", "{", "}"}
    if between.strip() != "->" or not begins or text[head.span.end :].lstrip()[:1] != ";":
        return ()
    try:
        _end(world, env, head, False)
        _end(world, env, tail, True)
    except BgError:
        return ()
    first = text[head.span.start : head.span.end]
    last = text[tail.span.start : tail.span.end]
    return (Edit(tail.span.to(head.span), f"{first}{between}{last}"),)


def _end(
    world: World, env: Environment, expr: syntax.Expr, is_head: bool
) -> tuple[Face, tuple[int, ...] | None]:
    """The face at one end of an arrow, and the slice of its components if there is one."""
    cut = None
    target = _target(world, env, expr)
    if target is None:
        assert isinstance(expr, syntax.Index)
        target = _target(world, env, expr.base)
        cut = _slice(world, env, expr)
        if target is None:
            raise BgError([graph.cannot_be_bonded(expr.span, path_of(expr), "indexed twice")])
    match target:
        case PartArray():
            raise BgError([names.needs_index(expr.span, target.path, target.description)])
        case Element():
            return _element_face(target, expr, is_head), cut
        case Instance():
            return _port_of(target, expr, is_head).outer, cut
        case (port, inside):
            _check_direction(port, inside, expr, is_head)
            return port.inner if inside else port.outer, cut


def _target(world: World, env: Environment, expr: syntax.Expr) -> Target | None:
    """The part or port that a path in a chain names; None where its index is a slice."""
    instance = env.instance
    assert instance is not None
    match expr:
        case syntax.Name():
            member = instance.members.get(expr.name)
            match member:
                case Pending():
                    return world.builder.build(member)
                case PartArray():
                    return member
                case PortEntry():
                    return member, True
                case Quantity():
                    what = f"a value ({member.kind})"
                    raise BgError([graph.cannot_be_bonded(expr.span, expr.name, what)])
                case None:
                    near = [n for n, m in instance.members.items() if not isinstance(m, Quantity)]
                    raise BgError([names.unknown_name(expr.span, expr.name, near)])
        case syntax.Member():
            return _member_target(world, env, expr)
        case syntax.Index():
            base = _target(world, env, expr.base)
            if not isinstance(base, PartArray):
                return None
            index = tuple(
                world.whole(i, env, "an index", -MAX_WIDTH, MAX_WIDTH)
                for i in expr.indices
                if not isinstance(i, syntax.Range)
            )
            return world.builder.build(part_at(base, index, expr.span))
        case _:
            raise BgError([graph.cannot_be_bonded(expr.span, path_of(expr), "not a part or port")])


def _member_target(world: World, env: Environment, expr: syntax.Member) -> Target:
    base = _target(world, env, expr.base)
    path = path_of(expr)
    match base:
        case Instance():
            member = base.members.get(expr.name)
            ports = [n for n, m in base.members.items() if isinstance(m, PortEntry)]
            if member is None:
                raise BgError([names.unknown_member(expr.span, expr.name, f"`{base.path}`", ports)])
            if not isinstance(member, PortEntry) or base.parent is not env.instance:
                owner = path_of(expr.base)
                raise BgError([graph.bond_to_inner_part(expr.span, path, owner, ports)])
            return member, False
        case PartArray():
            raise BgError([names.needs_index(expr.span, base.path, base.description)])
        case Element():
            element = path_of(expr.base)
            what = f"not a port (`{element}` is {with_article(base.kind)})"
            way = f"an element is bonded by its own name: `{element}`"
            raise BgError([graph.cannot_be_bonded(expr.span, path, what, way)])
        case _:
            raise BgError([graph.cannot_be_bonded(expr.span, path, "not a part or port")])


def _slice(world: World, env: Environment, expr: syntax.Index) -> tuple[int, ...]:
    """The components (from 0) of a slice such as `hub[1..3]` or `hub[2]`."""
    if len(expr.indices) != 1:
        raise BgError(
            [graph.cannot_be_bonded(expr.span, path_of(expr), "indexed by more than one number")]
        )
    (index,) = expr.indices
    if isinstance(index, syntax.Range):
        first = world.whole(index.first, env, "an index", 1, MAX_WIDTH)
        last = world.whole(index.last, env, "an index", first, MAX_WIDTH)
        return tuple(range(first - 1, last))
    return (world.whole(index, env, "an index", 1, MAX_WIDTH) - 1,)


def _element_face(element: Element, expr: syntax.Expr, is_head: bool) -> Face:
    if element.row.family in (Family.STORAGE, Family.RESISTOR) and not is_head:
        raise BgError([graph.arrow_out_of_element(expr.span, element.path, element.kind)])
    return element.faces.get("all") or element.faces["in" if is_head else "out"]


def _port_of(instance: Instance, expr: syntax.Expr, is_head: bool) -> PortEntry:
    """The port of a part named without one: the only port in this direction, or the main one."""
    ports = [m for m in instance.members.values() if isinstance(m, PortEntry)]
    wanted = syntax.Direction.IN if is_head else syntax.Direction.OUT
    fitting = [p for p in ports if p.declaration.direction in (wanted, None)]
    main = [p for p in fitting if p.declaration.main]
    if len(fitting) == 1 or len(main) == 1:
        return main[0] if len(main) == 1 else fitting[0]
    direction = "into" if is_head else "out of"
    name = path_of(expr)
    if fitting:
        candidates = [p.declaration.name for p in fitting]
        raise BgError([graph.which_port(expr.span, name, direction, candidates)])
    listing = [
        f"{p.declaration.name} {p.declaration.direction.value}"
        for p in ports
        if p.declaration.direction
    ]
    raise BgError([graph.no_port(expr.span, name, direction, listing)])


def _check_direction(port: PortEntry, inside: bool, expr: syntax.Expr, is_head: bool) -> None:
    direction = port.declaration.direction
    if direction is None:
        return
    points_in = is_head != inside
    if points_in != (direction is syntax.Direction.IN):
        place = port.declaration.name_span
        name = path_of(expr)
        raise BgError([graph.arrow_against_port(expr.span, name, direction.value, inside, place)])


# --- checks -----------------------------------------------------------------------------


def _check_bonded(world: World, root: Instance, wiring: Wiring) -> None:
    """Report elements without bonds, two-ports with bonds on one side only, open ports."""
    if world.report.errors:
        return  # a chain that failed leaves its ends open; its error is reported already
    for element in wiring.elements:
        if not any(face.joints for face in element.faces.values()):
            _report(world, graph.not_bonded(element.span, element.path, element.kind), element.env)
            continue
        one_sided = [side for side, face in element.faces.items() if not face.joints]
        if one_sided and not element.is_gyristor:
            missing = "into" if one_sided == ["in"] else "out of"
            _report(
                world,
                laws.one_sided(element.span, element.path, element.kind, missing),
                element.env,
            )
    for port in wiring.ports:
        sides = [(port.inner, "inside its model, the port")]
        span = port.instance.span
        sides.append((port.outer, "from outside, the port"))
        for face, what in sides:
            at = port.declaration.name_span if face is port.inner else span
            if not face.joints:
                world.report.add(graph.not_bonded(at, port.path, what), note=note_of(port.instance))


def check_single(world: World, wiring: Wiring, sized: set[Face]) -> None:
    """Report a second bond at a face that has room for one.

    Several bonds may share a face of a junction or Mux, a face that slices divide, and a face in
    `sized`, whose width is known from brackets, arguments or a law.
    """
    for face, owner in wiring.owners.items():
        whole = [j for j in face.joints if j.slice is None]
        if face.junction or len(face.joints) < 2 or not whole:
            continue
        if isinstance(owner, Element) and (owner.row.family is Family.BUNDLE or face in sized):
            continue
        first, second = whole[0], face.joints[1]
        is_port = isinstance(owner, PortEntry)
        if first is second:
            second = face.joints[0]
        _report(world, graph.bonded_twice(second.span, face.name, first.span, is_port), owner.env)


def _report(world: World, diagnostic: Diagnostic, env: Environment) -> None:
    world.report.add(diagnostic, note=note(env))
