"""Find the source that sets the effort or flow of an element whose start contradicts it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from bgc.algebra.dag import Dag, Kind
from bgc.ir.graph import (
    Element,
    FlatGraph,
    Gyrator,
    Initial,
    Junction,
    Node,
    Source,
    Transformer,
    ports_of,
)

_Place = tuple[int, str]  # a bond, and "e" or "f"


def opposing_source(graph: FlatGraph, name: str, variable: str) -> Source | None:
    """The nearest source that gives the effort (of `q` and `e`) or flow of an element, or None.

    The effort is shared at a J0 and the flow at a J1; one-port transformers and gyrators pass them
    on. Sums at other junctions are not followed.
    """
    shared = "e" if variable in "qe" else "f"
    on_bond: dict[int, list[Element]] = {}
    for element in graph.elements:
        for port in ports_of(element):
            on_bond.setdefault(port.bond, []).append(element)
    starts = (each for each in graph.elements if each.name == name)
    places = deque((port.bond, shared) for each in starts for port in ports_of(each))
    seen = set(places)
    while places:
        place = places.popleft()
        for element in on_bond[place[0]]:
            if isinstance(element, Source) and element.kind == f"S{place[1]}":
                return element
            new = [found for found in _beyond(element, place) if found not in seen]
            seen.update(new)
            places.extend(new)
    return None


def _beyond(element: Element, place: _Place) -> Iterator[_Place]:
    """The places to which an element passes an effort or flow on."""
    bond, shared = place
    match element:
        case Junction(kind="J0" | "J1"):
            if shared == ("e" if element.kind == "J0" else "f"):
                yield from ((port.bond, shared) for port in element.ports if port.bond != bond)
        case Transformer() | Gyrator() if len(element.ports1) == len(element.ports2) == 1:
            (one,), (other,) = element.ports1, element.ports2
            turned = {"e": "f", "f": "e"}[shared] if isinstance(element, Gyrator) else shared
            yield (other.bond if bond == one.bond else one.bond), turned
        case _:
            return


def parameters_behind(graph: FlatGraph, initial: Initial, source: Source) -> tuple[str, ...]:
    """The parameters that give an initial value and a source, for the way out of a message.

    Of the initial value they are those with a unit of the source's parameters.
    """
    behind = [graph.parameters[k] for k in _parameters(graph.dag, source.value)]
    units = {parameter.unit for parameter in behind}
    own = [graph.parameters[k] for k in _parameters(graph.dag, initial.value)]
    chosen = [p for p in own if not units or p.unit in units]
    return tuple(dict.fromkeys(p.name for p in (*chosen, *behind)))


def _parameters(dag: Dag, node: Node) -> list[int]:
    return sorted(symbol.index for symbol in dag.symbols_in([node], Kind.PARAM).values())
