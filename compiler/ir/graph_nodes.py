"""List the nodes of a flat graph, and map them to others.

Only this module lists the fields of a `FlatGraph` that contain nodes; `program_nodes` does so for
a `Program`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar, assert_never

from bgc.algebra.dag import Dag
from bgc.ir.graph import (
    Element,
    EnergyLaw,
    ExplicitLaw,
    FlatGraph,
    Gyrator,
    Gyristor,
    Held,
    Jump,
    Junction,
    Law,
    LinearLaw,
    Matrix,
    Node,
    Resistor,
    SampledPort,
    SampleRate,
    Source,
    State,
    Storage,
    Transformer,
)

_AnyLaw = TypeVar("_AnyLaw", bound=Law)
_New = Callable[[Node], Node]


def graph_roots(graph: FlatGraph) -> list[Node]:
    """All nodes of a graph, in a fixed order, possibly repeated."""
    roots: list[Node] = []

    def note(node: Node) -> Node:
        roots.append(node)
        return node

    map_graph(graph, graph.dag, note)
    return roots


def map_graph(graph: FlatGraph, dag: Dag, new: _New) -> FlatGraph:
    """Replace every node `n` of a graph by `new(n)`, a node of `dag`."""
    return replace(
        graph,
        dag=dag,
        elements=tuple(_element(element, new) for element in graph.elements),
        parameters=tuple(replace(p, value=new(p.value)) for p in graph.parameters),
        states=tuple(_state(state, new) for state in graph.states),
        unknowns=tuple(replace(u, start=new(u.start)) for u in graph.unknowns),
        equations=tuple(replace(e, residual=new(e.residual)) for e in graph.equations),
        guards=tuple(replace(g, condition=new(g.condition)) for g in graph.guards),
        observations=tuple(replace(o, node=new(o.node)) for o in graph.observations),
        requirements=tuple(replace(r, node=new(r.node)) for r in graph.requirements),
        devices=tuple(replace(d, values=tuple(map(new, d.values))) for d in graph.devices),
        conditions=tuple(replace(c, residual=new(c.residual)) for c in graph.conditions),
        jumps=tuple(_jump(jump, new) for jump in graph.jumps),
        held=map_held(graph.held, new),
        rates=map_rates(graph.rates, new),
        ports=map_ports(graph.ports, new),
    )


def law_nodes(law: Law) -> tuple[Node, ...]:
    """The nodes of a law, in order."""
    nodes: list[Node] = []

    def note(node: Node) -> Node:
        nodes.append(node)
        return node

    _law(law, note)
    return tuple(nodes)


def map_held(held: tuple[Held, ...], new: _New) -> tuple[Held, ...]:
    """Replace the nodes of held values."""
    return tuple(replace(h, initial=new(h.initial), update=new(h.update)) for h in held)


def map_rates(rates: tuple[SampleRate, ...], new: _New) -> tuple[SampleRate, ...]:
    """Replace the nodes of sampling rates."""
    return tuple(replace(r, period=new(r.period), offset=new(r.offset)) for r in rates)


def map_ports(ports: tuple[SampledPort, ...], new: _New) -> tuple[SampledPort, ...]:
    """Replace the nodes of sampled ports."""
    return tuple(
        replace(
            port,
            balance=new(port.balance),
            stiffness=new(port.stiffness),
            damping=new(port.damping),
            mass=new(port.mass),
            resolution=new(port.resolution),
            lag=new(port.lag),
            period=new(port.period),
        )
        for port in ports
    )


def _jump(jump: Jump, new: _New) -> Jump:
    return replace(
        jump,
        condition=new(jump.condition),
        resets=tuple(replace(r, target=new(r.target), value=new(r.value)) for r in jump.resets),
    )


def _state(state: State, new: _New) -> State:
    return replace(
        state,
        initial=new(state.initial),
        derivative=None if state.derivative is None else new(state.derivative),
        projection=None if state.projection is None else new(state.projection),
        free=tuple(map(new, state.free)),
    )


def _element(element: Element, new: _New) -> Element:
    match element:
        case Junction():
            given = element.initial
            if given is None:
                return element
            return replace(element, initial=replace(given, value=new(given.value)))
        case Source():
            return replace(element, value=new(element.value))
        case Storage():
            initial = tuple(replace(i, value=new(i.value)) for i in element.initial)
            return replace(element, law=_law(element.law, new), initial=initial)
        case Resistor():
            return replace(element, law=_law(element.law, new))
        case Transformer():
            inverse = None if element.inverse is None else _matrix(element.inverse, new)
            return replace(element, matrix=_matrix(element.matrix, new), inverse=inverse)
        case Gyrator() | Gyristor():
            return replace(element, matrix=_matrix(element.matrix, new))
        case _:
            assert_never(element)


def _law(law: _AnyLaw, new: _New) -> _AnyLaw:
    match law:
        case LinearLaw():
            return replace(law, matrix=_matrix(law.matrix, new))
        case ExplicitLaw():
            return replace(law, nodes=tuple(map(new, law.nodes)))
        case EnergyLaw():
            return replace(law, energy=new(law.energy))
        case _:
            assert_never(law)


def _matrix(matrix: Matrix, new: _New) -> Matrix:
    return tuple(tuple(map(new, row)) for row in matrix)
