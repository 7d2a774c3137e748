"""The initial values that a model gives: their variables, and those that each start has to check.

A value holds by construction where the initial states are formulas that satisfy it, which is proven
here. Others are found by a solver, with a loop or a closed chain among their equations, or give way
as defaults: the runtime compares them with the start that it has found.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence

from bgc.algebra.dag import Kind
from bgc.algebra.derivatives import gradient
from bgc.equations.loops.substitution import Resolver
from bgc.equations.storage.initial_values import GivenVariable, given_of_element
from bgc.equations.storage.kinds import StorageElement, state_name
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import FlatGraph, Junction, Node, Storage
from bgc.ir.program import GivenValue, ProgramState
from bgc.language.elements import INITIAL_VALUE


def given_of_junctions(variables: Variables, indices: Collection[int]) -> Iterator[GivenVariable]:
    """The common variables of those of some elements that are junctions with an initial value."""
    for index in sorted(indices):
        junction = variables.causal.graph.elements[index]
        if isinstance(junction, Junction) and junction.initial is not None and junction.ports:
            kind = Kind.EFFORT if junction.kind == "J0" else Kind.FLOW
            symbol = variables.dag.symbol(kind, junction.ports[0].bond)
            yield GivenVariable(junction.name, junction.initial, symbol)


def stiffness_at_start(
    variables: Variables, elements: Sequence[StorageElement]
) -> dict[Node, float]:
    """The derivative of the effort of each charge by itself, at the start with all defaults."""
    ports = [port for element in elements for port in element.ports if not port.has_momentum]
    slopes = [gradient(variables.dag, port.answer, [port.state])[0] for port in ports]
    values = variables.at_start(slopes) or []
    pairs = zip(ports, values, strict=False)
    return {port.state: value for port, value in pairs if math.isfinite(value)}


def resolve_given(
    variables: Variables, resolver: Resolver, elements: Sequence[StorageElement]
) -> list[GivenValue]:
    """The given values of storage and of the junctions that it determines, in final nodes.

    Constant zeros by default, which give way without a word, are left out.
    """
    found = [one for element in elements for one in given_of_element(variables.dag, element)]
    found += given_of_junctions(variables, variables.given_junctions | variables.starting)
    values: list[GivenValue] = []
    for one in found:
        initial = one.initial
        if not initial.is_default or initial.value != variables.dag.zero:
            node, value = resolver.resolve_all([one.node, initial.value])
            values.append(
                GivenValue(
                    node,
                    value,
                    f"{initial.variable}0",
                    one.name,
                    initial.span,
                    is_default=initial.is_default,
                )
            )
    return values


def given_of_states(graph: FlatGraph, states: Sequence[ProgramState]) -> list[GivenValue]:
    """The initial values of declared states that are projected, in final nodes."""
    numbers = {state.name: k for k, state in enumerate(states)}
    symbols = ((s, graph.dag.symbol(Kind.STATE, numbers[s.name])) for s in graph.states)
    return [
        GivenValue(
            symbol,
            states[numbers[state.name]].initial,
            INITIAL_VALUE,
            state.name,
            state.span,
            is_rounded=True,
        )
        for state, symbol in symbols
        if state.projection is not None
    ]


def values_to_check(
    variables: Variables,
    given: Sequence[GivenValue],
    states: Sequence[ProgramState],
    free: Collection[int],
) -> tuple[GivenValue, ...]:
    """The given values that are not proven to hold where the states have their initial values.

    A solver moves the states that are numbered `free`, and those in closed chains.
    """
    dag, fingerprints = variables.dag, variables.causal.fingerprints
    moved = set(range(len(states))) if variables.causal.closures else set(free)
    moved |= {k for k, s in enumerate(states) if s.projection is not None or s.kind == "algebraic"}
    start = {dag.symbol(Kind.STATE, k): s.initial for k, s in enumerate(states) if k not in moved}
    differences = dag.substitute([dag.sub(g.node, g.value) for g in given], start)
    pairs = zip(given, differences, strict=True)
    return tuple(g for g, difference in pairs if not fingerprints.is_zero(difference))


def given_names(graph: FlatGraph, states: Sequence[str]) -> tuple[str, ...]:
    """Name the given value of each state that belongs to one port, or is declared.

    The name is that of the parameter that gives the value, else of the value itself; empty for
    zeros and for other states.
    """
    dag = graph.dag
    found = {state.name: (state.name, state.initial) for state in graph.states}
    storage = [element for element in graph.elements if isinstance(element, Storage)]
    for element, initial in ((e, i) for e in storage for i in e.initial if not i.is_default):
        for letter in "qp":
            name = state_name(element, letter, initial.port)
            found[name] = f"{initial.variable}0 of {element.name}", initial.value

    def given(name: str) -> str:
        own, value = found.get(name, ("", dag.zero))
        symbol = dag.symbol_of(value)
        if symbol is not None and symbol.kind is Kind.PARAM:
            return graph.parameters[symbol.index].name
        return own if value != dag.zero else ""

    return tuple(map(given, states))
