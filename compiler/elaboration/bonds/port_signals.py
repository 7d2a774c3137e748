"""Signals that a domain carries along its bonds, from the port that writes to the readers.

Signals run with the half arrow, from tail to head, and pass through ports and 1-junctions.
"""

from __future__ import annotations

from fractions import Fraction

from bgc.diagnostics.catalogue import graph, names
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.domains import DomainFacts
from bgc.elaboration.instances.faces import Face, WideBond
from bgc.elaboration.instances.tree import Element, Environment, PortEntry, Quantity
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.values.units import si_symbol
from bgc.values.value import Value


class Carried:
    """Finds and evaluates the signals of ports and 1-junctions."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.owners: dict[Face, Element | PortEntry] = {}
        self.written: dict[tuple[PortEntry, str], Quantity] = {}
        self._sources: dict[tuple[object, str], tuple[PortEntry, ...]] = {}

    def write(
        self,
        port: PortEntry,
        signal: str,
        facts: DomainFacts,
        statement: syntax.Assign,
        env: Environment,
    ) -> None:
        """Record an assignment to a signal of a port, `tip.r = ..;`."""
        shape, unit = facts.signals[signal]
        span = statement.target.span
        present = self.written.get((port, signal))
        name = f"{port.declaration.name}.{signal}"
        if present is not None:
            raise BgError([names.given_twice(span, name, present.declaration.name_span)])
        declaration = syntax.Value(
            kind="signal",
            name=name,
            dims=tuple(syntax.Number(Fraction(n), None, span) for n in shape),
            unit=si_symbol(unit) if unit is not None else None,
            value=statement.value,
            range=None,
            doc="",
            span=statement.span,
            name_span=span,
        )
        self.written[port, signal] = Quantity(f"{port.path}.{signal}", declaration, env, None)

    def at_port(self, port: PortEntry, signal: str, facts: DomainFacts, span: Span) -> Value:
        """The signal at a port."""
        return self._value(port, signal, f"`{port.path}`", span)

    def at_junction(self, element: Element, signal: str, facts: DomainFacts, span: Span) -> Value:
        """The signal at a 1-junction."""
        return self._value(element, signal, f"`{element.path}`", span)

    def _value(self, place: PortEntry | Element, signal: str, where: str, span: Span) -> Value:
        key = (place, signal)
        sources = self._sources.get(key)
        if sources is None:
            sources = self._sources[key] = self._writers(place, signal)
        name = where.strip("`")
        if not sources:
            raise BgError([graph.nobody_writes(span, name, signal)])
        if len(sources) > 1:
            places = [self.written[s, signal].declaration.name_span for s in sources]
            raise BgError([graph.written_twice_over(span, name, signal, places)])
        return self.world.quantities.value(self.written[sources[0], signal], span)

    def _writers(self, place: PortEntry | Element, signal: str) -> tuple[PortEntry, ...]:
        """The nearest ports upstream, along the incoming bonds, that write the signal."""
        found: dict[PortEntry, None] = {}
        seen: set[PortEntry | Element] = {place}
        stack = [place]
        while stack:
            here = stack.pop()
            if isinstance(here, PortEntry) and (here, signal) in self.written:
                found[here] = None
                continue
            for bond in _incoming(here):
                upstream = self.owners[bond.tail.face]
                passes = isinstance(upstream, PortEntry) or upstream.basic == "J1"
                if passes and upstream not in seen:
                    seen.add(upstream)
                    stack.append(upstream)
        return tuple(found)


def _incoming(place: PortEntry | Element) -> list[WideBond]:
    """The whole bonds, without slices, whose head is at a port (either side) or a junction."""
    if isinstance(place, PortEntry):
        faces = [place.outer, place.inner]
    else:
        faces = list(place.faces.values())
    return [j.bond for face in faces for j in face.joints if j.is_head and j.slice is None]
