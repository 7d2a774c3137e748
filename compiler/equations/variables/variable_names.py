"""Names of raw symbols for messages and tables, and the errors that name symbols."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.algebra.dag import Kind, Symbol
from bgc.causality.paths import connections, gyrators_around
from bgc.diagnostics.catalogue import causality as catalogue
from bgc.diagnostics.catalogue import ports
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError, Label
from bgc.diagnostics.source import Span
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.graph import Gyrator, Node, Storage


class Places:
    """Names, units and places of raw symbols."""

    def __init__(self, causal: CausalGraph) -> None:
        self._causal = causal
        self._elements: dict[Node, int] = {}  # symbols that are not of bonds -> element
        self._called: dict[Node, Node] = {}  # parts of variables -> the variable
        self._moved: dict[Node, Node] = {}  # speeds of free motions -> the quantity moved
        self._resistances: dict[int, int] = {}  # bond -> its first port of a resistance
        for k, port in enumerate(causal.ports):
            if port.role is Role.RESISTANCE:
                self._resistances.setdefault(port.bond, k)

    def note(self, symbol: Node, element: int) -> None:
        """Note the element of a symbol that does not belong to a bond."""
        self._elements[symbol] = element

    def call(self, symbol: Node, variable: Node) -> None:
        """Name a symbol after the variable that it is a part of."""
        self._called[symbol] = variable

    def move(self, speed: Node, quantity: Node) -> None:
        """Name the speed of a free motion after the quantity that it moves."""
        self._moved[speed] = quantity

    def name_of(self, symbol: Node) -> str:
        """The name of a variable that becomes an algebraic state: `diode.e`."""
        if symbol in self._moved:
            return f"{self.name_of(self._moved[symbol])}.speed"
        leaf = self._leaf(symbol)
        letter = {Kind.EFFORT: "e", Kind.FLOW: "f", Kind.DISPLACEMENT: "q"}.get(leaf.kind, "p")
        if leaf.kind not in {Kind.EFFORT, Kind.FLOW}:
            element = self._causal.graph.elements[self._elements[symbol]]
            if leaf.kind is Kind.RATE:
                letter = self._rate_name(symbol)
            elif isinstance(element, Storage) and len(element.ports) > 1:
                letter += f"[{leaf.index - element.first_state + 1}]"
            return f"{element.name}.{letter}"
        bonds: tuple[int, ...] = (leaf.index,)
        if (leaf.kind is Kind.EFFORT) == self._causal.dual[leaf.index]:
            bonds = self._causal.classes[self._causal.class_of[leaf.index]].bonds
        known = [self._resistances[bond] for bond in bonds if bond in self._resistances]
        if known:
            port = self._causal.ports[min(known)]
            suffix = f"[{port.position + 1}]" if port.position else ""
            return f"{self._causal.graph.elements[port.element].name}.{letter}{suffix}"
        return f"({self._place(symbol)[0]}).{letter}"

    def _rate_name(self, symbol: Node) -> str:
        """`rate`, or `rate2` for the second rate that belongs to an element."""
        own = (node for node, k in self._elements.items() if k == self._elements[symbol])
        rates = [node for node in own if self._leaf(node).kind is Kind.RATE]
        place = rates.index(symbol) + 1
        return f"rate{place}" if place > 1 else "rate"

    def unit_of(self, symbol: Node) -> str:
        """The unit of an effort or flow that becomes an algebraic state."""
        leaf = self._leaf(symbol)
        if leaf.kind not in {Kind.EFFORT, Kind.FLOW}:
            return ""
        bond = self._causal.graph.bonds[leaf.index]
        return bond.effort_unit if leaf.kind is Kind.EFFORT else bond.flow_unit

    def element_of(self, symbol: Node) -> int:
        """The element of a symbol that does not belong to a bond."""
        return self._elements[symbol]

    def span_of(self, symbol: Node) -> Span:
        """The place of a symbol's bond or element in the source."""
        return self._place(symbol)[1]

    def bonds_of(self, symbols: Iterable[Node], ports: Iterable[int]) -> tuple[str, ...]:
        """The bonds of effort and flow symbols and of ports, in the order of the graph."""
        leaves = (self._leaf(symbol) for symbol in symbols)
        found = {leaf.index for leaf in leaves if leaf.kind in {Kind.EFFORT, Kind.FLOW}}
        found |= {self._causal.ports[k].bond for k in ports}
        return tuple(self._causal.graph.bonds[bond].name for bond in sorted(found))

    def elements_of(self, ports: Iterable[int]) -> tuple[str, ...]:
        """The elements of ports, in the order of the graph."""
        found = sorted({self._causal.ports[k].element for k in ports})
        return tuple(self._causal.graph.elements[k].name for k in found)

    def _leaf(self, symbol: Node) -> Symbol:
        return self._causal.graph.dag.leaf(self._called.get(symbol, symbol))

    def _place(self, symbol: Node) -> tuple[str, Span]:
        graph = self._causal.graph
        leaf = self._leaf(symbol)
        if leaf.kind in {Kind.EFFORT, Kind.FLOW}:
            return graph.bonds[leaf.index].name, graph.bonds[leaf.index].span
        element = graph.elements[self._elements[self._moved.get(symbol, symbol)]]
        return element.name, element.span

    def _around(self, names: Sequence[str]) -> list[tuple[str, Span]]:
        """Bonds by their names, with their places, in the order of the graph."""
        wanted = set(names)
        bonds = (bond for bond in self._causal.graph.bonds if bond.name in wanted)
        return [(bond.name, bond.span) for bond in bonds]

    # --- errors -----------------------------------------------------------------------------

    def unsolvable(
        self,
        symbols: Sequence[Node],
        solutions: str = "unclear",
        bonds: Sequence[str] = (),
        elements: Sequence[str] = (),
    ) -> BgError:
        """Equations have no single solution for these unknowns.

        `solutions` is `none`, `many` or `unclear`; `bonds` and `elements` are those of the loop
        where it is known.
        """
        places = [self._place(symbol) for symbol in symbols]
        names = list(dict.fromkeys(name for name, _ in places))
        graph = self._causal.graph
        ports = {port.element for port in self._causal.ports}
        gyrators = [
            k
            for k in sorted(ports)
            if isinstance(graph.elements[k], Gyrator)
            and (not elements or graph.elements[k].name in elements)
        ]
        if gyrators:
            return self.odd_loop(gyrators, names)
        named = bonds or names
        marked = [Label(span, f"`{name}` is in the loop") for name, span in self._around(named)]
        marked += [
            Label(element.span, f"its law takes part: `{element.name}`")
            for element in graph.elements
            if element.name in elements
        ]
        span = places[0][1]
        return BgError([catalogue.singular_loop(span, named, elements, solutions, marked)])

    def odd_loop(self, gyrators: Iterable[int], bonds: Sequence[str]) -> BgError:
        """The odd loops that some gyrators close leave bonds undetermined."""
        graph = self._causal.graph
        around = connections(graph, gyrators_around(graph, gyrators))
        return BgError([catalogue.gyrator_loop(around, bonds)])

    def not_invertible(self, symbol: Node, elements: Sequence[str], why: str) -> BgError:
        """A law gives no single value of the variable that is asked for."""
        name, span = self.name_of(symbol), self.span_of(symbol)
        return BgError([catalogue.not_invertible(span, name, elements, why)])

    def rate_in_loop(self, symbols: Sequence[Node]) -> BgError:
        """A loop runs through the rate of a merged variable."""
        places = [self._place(symbol) for symbol in symbols]
        names = list(dict.fromkeys(name for name, _ in places))
        return BgError([catalogue.derivative_loop(places[0][1], names)])

    def no_rate(self, symbol: Node, of: Symbol | None = None) -> BgError:
        """A rate would need the rate of an input (`of`) or of a loop's unknown."""
        name, span = self._place(symbol)
        graph = self._causal.graph
        if of is not None and of.kind is Kind.INPUT:
            held = next((held.name for held in graph.held if held.index == of.index), "")
            for port in graph.ports:
                if held.startswith(f"{port.name}.effort"):
                    why = f"`{name}` would follow it at once: nothing with a mass is between"
                    return BgError([ports.nothing_behind(port.span, port.name, why)])
        return BgError([catalogue.rate_unknown(span, name)])

    def no_momentum(self, index: int) -> BgError:
        """A port of an IC is asked for a momentum that its energy does not hold."""
        storage = next(
            e
            for e in self._causal.graph.elements
            if isinstance(e, Storage) and 0 <= index - e.first_state < len(e.ports)
        )
        name = f"{storage.name}.p[{index - storage.first_state + 1}]"
        return BgError([storage_messages.no_momentum(storage.span, name)])

    def undetermined(self, bond: int, *, through: bool) -> BgError:
        """Nothing determines a bond's through or across variable."""
        what = "flow" if through != self._causal.dual[bond] else "effort"
        facts = self._causal.graph.bonds[bond]
        return BgError([catalogue.nothing_determines(facts.span, facts.name, what)])
