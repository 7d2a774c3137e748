"""Read efforts, flows, displacements, momenta and powers of elements and ports."""

from __future__ import annotations

from bgc.algebra.dag import Kind
from bgc.diagnostics.catalogue import graph, values, with_article
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.bond_units import BondUnits
from bgc.elaboration.bonds.domains import DomainFacts, Domains
from bgc.elaboration.bonds.port_signals import Carried
from bgc.elaboration.bonds.scalarise import Scalars
from bgc.elaboration.bonds.shape_probe import shape_of, width_of
from bgc.elaboration.instances.faces import Face
from bgc.elaboration.instances.tree import Element, PortEntry
from bgc.elaboration.instances.world import World
from bgc.ir.graph import Port
from bgc.language.elements import Family
from bgc.values.scope import Namespace
from bgc.values.units import Dimension, multiply, times_seconds
from bgc.values.value import Shape, Value

_PLACEHOLDER_BASE = 1 << 40  # index of the first placeholder symbol, beyond all real ones

_UNIT_OF = {"q": "flow", "p": "effort"}


class BondValues:
    """Reads variables of bonds; before the bonds are numbered, as placeholders of their shape."""

    def __init__(self, world: World, domains: Domains, carried: Carried) -> None:
        self.world = world
        self.domains = domains
        self.carried = carried
        self.scalars: Scalars | None = None
        self.units: BondUnits | None = None
        self._provisional: dict[tuple[int, str, int], int] = {}

    # --- elements -------------------------------------------------------------------

    def of_element(self, element: Element, name: str, span: Span) -> Value | Namespace:
        """A variable of an element by name."""
        self._require_bonds(span)
        row = element.row
        if row.family is Family.JUNCTION:
            return self._of_junction(element, name, span)
        face = element.faces.get("all") or element.faces["in"]
        have = ("e", "f", "power") if element.is_gyristor else row.observed
        if name not in have:
            raise self._no_such_variable(
                f"`{element.path}`, {with_article(element.kind)},", name, span, have
            )
        if name == "power":
            return self._power(face, -1 if row.family is Family.SOURCE else 1)
        if name in row.stored:
            return self.storage(element, name)
        if len(name) == 2:  # of port 1 or 2
            face = element.faces["in" if name[1] == "1" else "out"]
        return self.variable(face, name[0])

    def _of_junction(self, element: Element, name: str, span: Span) -> Value | Namespace:
        face = element.faces["all"]
        variable = "e" if element.basic == "J0" else "f"
        if name == variable:
            return self.variable(face, variable)
        facts = self._facts(face)
        have = [variable]
        if facts is not None:
            table = facts.efforts if variable == "e" else facts.flows
            if name in table:
                return self._slice(self.variable(face, variable), table[name])
            have += table
            if element.basic == "J1":
                have += facts.signals
                if name in facts.signals:
                    return self.carried.at_junction(element, name, facts, span)
        raise self._no_such_variable(
            f"`{element.path}`, {with_article(element.kind)},", name, span, have
        )

    def of_port(self, port: PortEntry, name: str, span: Span) -> Value | Namespace:
        """A variable of the bond at a port, or a signal carried by that bond."""
        self._require_bonds(span)
        face = port.inner if port.inner.joints else port.outer
        facts = self._facts(face)
        if name in {"e", "f"}:
            return self.variable(face, name)
        if name == "power":
            return self._power(face, 0)
        have = ["e", "f", "power"]
        if facts is not None:
            for variable, table in (("e", facts.efforts), ("f", facts.flows)):
                if name in table:
                    return self._slice(self.variable(face, variable), table[name])
            if name in facts.signals:
                return self.carried.at_port(port, name, facts, span)
            have += [*facts.efforts, *facts.flows, *facts.signals]
        raise self._no_such_variable(f"the port `{port.path}`", name, span, have)

    def _require_bonds(self, span: Span) -> None:
        """Raise BgError while the tree is being built, when only constants can be read."""
        if self.scalars is None and not self.world.provisional:
            raise BgError([values.not_constant(span, "what decides the parts of a model")])

    def _no_such_variable(
        self, owner: str, name: str, span: Span, have: list[str] | tuple[str, ...]
    ) -> BgError:
        return BgError([graph.unknown_port_member(span, owner, name, have)])

    def _facts(self, face: Face) -> DomainFacts | None:
        domain = face.net.root().domain
        return self.domains.facts(domain.declared) if domain is not None else None

    def has_pose(self, place: PortEntry | Element) -> bool:
        """Return whether a port or 1-junction is a frame, with signals `r[3]` and `A[3, 3]`."""
        if isinstance(place, PortEntry):
            face = place.inner if place.inner.joints else place.outer
        elif place.basic == "J1":
            face = place.faces["all"]
        else:
            return False
        facts = self._facts(face)
        shapes = {} if facts is None else {n: shape for n, (shape, _) in facts.signals.items()}
        return shapes.get("r") == (3,) and shapes.get("A") == (3, 3)

    def is_power(self, bond: int) -> bool:
        """Return whether effort times flow of a scalar bond is a power."""
        return self.units is not None and self.units.is_power(bond)

    # --- variables of faces ---------------------------------------------------------

    def variable(self, face: Face, name: str) -> Value:
        """The efforts (`e`) or flows (`f`) of a face, one symbol per component."""
        shape = shape_of(face)
        if self.scalars is None or self.units is None:
            return self._placeholder(face, name, shape)
        kind = Kind.EFFORT if name == "e" else Kind.FLOW
        bonds = [port.bond for port in self._bonded(self.scalars, face)]
        nodes = tuple(self.world.dag.symbol(kind, b) for b in bonds)
        long = "effort" if name == "e" else "flow"
        return Value(shape, nodes, tuple(self.units.dimension(long, b) for b in bonds))

    def _bonded(self, scalars: Scalars, face: Face) -> list[Port]:
        """The first port of each component, which a wide junction need not have."""
        found = scalars.ports(face)
        for k, ports in enumerate(found, 1):
            if not ports:
                name = f"{face.name}[{k}]"
                raise BgError([graph.not_bonded(face.span, name, "the component")])
        return [ports[0] for ports in found]

    def storage(self, element: Element, name: str) -> Value:
        """The displacements (`q`) or momenta (`p`) of a storage element."""
        face = element.faces["all"]
        shape = shape_of(face)
        if self.scalars is None or self.units is None:
            return self._placeholder(face, name, shape)
        kind = Kind.DISPLACEMENT if name == "q" else Kind.MOMENTUM
        nodes, units = [], []
        for k, ports in enumerate(self.scalars.ports(face)):
            nodes.append(self.world.dag.symbol(kind, element.first_state + k))
            units.append(self.storage_unit(ports[0], name))
        return Value(shape, tuple(nodes), tuple(units))

    def storage_unit(self, port: Port, name: str) -> Dimension | None:
        """The unit of a displacement (flow times time) or momentum (effort times time)."""
        assert self.units is not None
        rate = self.units.dimension(_UNIT_OF[name], port.bond)
        return times_seconds(rate, 1) if rate is not None else None

    def _power(self, face: Face, sense: int) -> Value:
        """Power along the half arrow (sense 0), into the element (1) or out of it (-1)."""
        effort, flow = self.variable(face, "e"), self.variable(face, "f")
        dag = self.world.dag
        signs = [1] * len(effort.nodes)
        unit: Dimension | None = None
        if self.scalars is not None and self.units is not None:
            ports = self._bonded(self.scalars, face)
            if sense:
                signs = [sense * port.sign for port in ports]
            known = [self._power_unit(port.bond) for port in ports]
            unit = known[0] if all(k == known[0] for k in known) else None
        terms = (
            dag.mul(dag.const(s), dag.mul(e, f))
            for s, e, f in zip(signs, effort.nodes, flow.nodes, strict=True)
        )
        return Value.scalar(dag.sum(terms), unit)

    def _power_unit(self, bond: int) -> Dimension | None:
        assert self.units is not None
        effort, flow = self.units.dimension("effort", bond), self.units.dimension("flow", bond)
        return multiply(effort, flow) if effort is not None and flow is not None else None

    def _slice(self, value: Value, place: tuple[int, Shape]) -> Value:
        first, shape = place
        count = 1
        for size in shape:
            count *= size
        return Value(shape, value.nodes[first : first + count], value.units[first : first + count])

    def _placeholder(self, face: Face, name: str, shape: Shape) -> Value:
        """Distinct placeholder symbols of the right number, so that nothing cancels."""
        kind = Kind.EFFORT if name in {"e", "p"} else Kind.FLOW
        nodes = []
        for k in range(width_of(face)):
            key = (id(face), name, k)
            place = self._provisional.setdefault(key, len(self._provisional))
            nodes.append(self.world.dag.symbol(kind, _PLACEHOLDER_BASE + place))
        return Value(shape, tuple(nodes), (None,) * len(nodes))
