"""Find the signals that modulate the elements of a graph: a ratio, a law or a source's value."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bgc.algebra.dag import Kind, Symbol
from bgc.ir.fields import nodes_of
from bgc.ir.graph import (
    Element,
    FlatGraph,
    Junction,
    Node,
    Resistor,
    Source,
    Storage,
    port_ends,
)
from bgc.record_class import dataclass

_OWN = {Kind.EFFORT, Kind.FLOW}


@dataclass(frozen=True, slots=True)
class Modulation:
    """The signals and elements that modulate one element.

    `elements` are those whose effort, flow or storage its law reads, `signals` the names of
    declared states and unknowns and of devices. `varies` is True for any of these, and for a
    transformer, gyrator or resistor that depends on time.
    """

    elements: tuple[int, ...]
    signals: tuple[str, ...]
    varies: bool


def modulations(graph: FlatGraph) -> list[Modulation]:
    """Find the modulation of each element, in order."""
    storage = {
        element.first_state + k: index
        for index, element in enumerate(graph.elements)
        if isinstance(element, Storage)
        for k in range(len(element.ports))
    }
    at = {(bond, sign): element for bond, sign, element in port_ends(graph)}
    return [_of(graph, element, storage, at) for element in graph.elements]


def _of(
    graph: FlatGraph, element: Element, storage: dict[int, int], at: dict[tuple[int, int], int]
) -> Modulation:
    # The law of a resistor relates the variables of its own bonds.
    own = {port.bond for port in element.ports} if isinstance(element, Resistor) else set()
    elements: dict[int, None] = {}
    signals: dict[str, None] = {}
    timed = False
    for symbol in _symbols(graph, _modulated(element)):
        match symbol.kind:
            case Kind.TIME:
                timed = not isinstance(element, Source)
            case Kind.STATE:
                signals[graph.states[symbol.index].name] = None
            case Kind.UNKNOWN:
                signals[graph.unknowns[symbol.index].name] = None
            case Kind.INPUT:
                signals[_device(graph, symbol.index)] = None
            case Kind.EFFORT | Kind.FLOW if symbol.index not in own:
                elements[_carrier(graph, symbol, at)] = None
            case Kind.DISPLACEMENT | Kind.MOMENTUM:
                elements[storage[symbol.index]] = None
            case _:
                pass
    return Modulation(tuple(elements), tuple(signals), bool(elements or signals or timed))


def _modulated(element: Element) -> Sequence[Node]:
    """The nodes of an element that a signal may modulate."""
    return [] if isinstance(element, Storage | Junction) else nodes_of(element)


def _symbols(graph: FlatGraph, nodes: Sequence[Node]) -> Iterator[Symbol]:
    dag = graph.dag
    for node in dag.reachable(list(nodes)):
        symbol = dag.symbol_of(node)
        if symbol is not None:
            yield symbol


def _device(graph: FlatGraph, index: int) -> str:
    """The name of the held value of an INPUT symbol, or of the device with that channel."""
    held = next((held.name for held in graph.held if held.index == index), None)
    if held is not None:
        return held
    return next((use.name for use in reversed(graph.devices) if use.first_input <= index), "device")


def _carrier(graph: FlatGraph, symbol: Symbol, at: dict[tuple[int, int], int]) -> int:
    """The junction that shares an effort or flow, else the element at the tail of its bond."""
    wanted = "J0" if symbol.kind is Kind.EFFORT else "J1"
    ends = [at[symbol.index, sign] for sign in (-1, 1)]
    return next((end for end in ends if graph.elements[end].kind == wanted), ends[0])
