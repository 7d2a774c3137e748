"""The values that are given for the start of jointly starting elements, as final nodes.

The elements are those that the storage passes noted in `Variables.starting`: nonlinear laws merged
with others, or moduli that may vanish. Each given value becomes a condition on the states, whatever
the variable is: a charge, a momentum, an effort, a flow, or the common variable of a junction.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

from bgc.algebra.dag import Dag, Kind
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.loops.substitution import Resolver
from bgc.equations.start.given import given_of_junctions
from bgc.equations.storage.conditions import Condition
from bgc.equations.storage.initial_values import GivenVariable, given_of_element
from bgc.equations.storage.kinds import IntegratedState, StorageElement
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Given:
    """A value that has to hold at the start: `node = condition.value`, both final nodes."""

    node: Node
    condition: Condition


@dataclass(frozen=True, slots=True)
class Problem:
    """The conditions of a start, and the storage that may move to satisfy them.

    `stored` pairs each stored quantity with its answer (the effort of a charge, the flow of a
    momentum), both final nodes: the gradient of the energy. `free` are the numbers of the states.
    """

    given: tuple[Given, ...]
    stored: tuple[tuple[Node, Node], ...]
    free: tuple[int, ...]


def start_problem(
    variables: Variables,
    resolver: Resolver,
    elements: Sequence[StorageElement],
    states: Sequence[IntegratedState],
) -> Problem | None:
    """Resolve the conditions of the elements that start jointly; None without any.

    `states` are the storage states of the program, in its order.
    """
    if not variables.starting:
        return None
    chosen = [e for e in elements if e.ports[0].port.element in variables.starting]

    def of_junctions(indices: Collection[int]) -> list[Given]:
        found = given_of_junctions(variables, indices)
        return [_given(variables, resolver, one) for one in found]

    common = of_junctions(variables.starting)
    chosen += _moved_by(variables, resolver, elements, states, chosen, common)
    others = variables.given_junctions - variables.starting
    for one in of_junctions(others):
        moved = _moved_by(variables, resolver, elements, states, (), [one])
        if any(element in chosen for element in moved):
            common.append(one)
            chosen += [element for element in moved if element not in chosen]
    chosen += _sharing(elements, states, chosen)
    given = [
        _given(variables, resolver, one)
        for element in chosen
        for one in given_of_element(variables.dag, element)
    ]
    default = [one for one in given if one.condition.is_default]
    given = [*(one for one in given if not one.condition.is_default), *common, *default]
    if not given:
        return None
    ports = [port for element in chosen for port in element.ports]
    names = {element.storage.name for element in chosen}
    beside = {port.charge for port in ports}
    return Problem(
        tuple(given),
        tuple((resolver.resolve(p.state), resolver.resolve(p.answer)) for p in ports),
        tuple(
            k
            for k, state in enumerate(states)
            if not names.isdisjoint(state.stores) and state.symbol not in beside
        ),
    )


def _given(variables: Variables, resolver: Resolver, one: GivenVariable) -> Given:
    name, initial = one.name, one.initial
    final, value = resolver.resolve_all([one.node, initial.value])
    found = Given(final, Condition({}, value, name, initial))
    held = set(variables.dag.reachable([final]))
    if held & variables.speeds.keys() or held & set(variables.multipliers):
        # The speed of a free motion follows from rates, and so does a force that closes a chain.
        variable = f"{initial.variable}0"
        raise BgError(
            [storage_messages.initial_unusable(initial.span, name, variable, of_junction=True)]
        )
    return found


def _moved_by(
    variables: Variables,
    resolver: Resolver,
    elements: Sequence[StorageElement],
    states: Sequence[IntegratedState],
    chosen: Sequence[StorageElement],
    given: Sequence[Given],
) -> list[StorageElement]:
    """Further elements whose states the conditions of junctions contain."""
    known = {element.storage.name for element in chosen}
    names = set[str]()
    for number in states_in(variables.dag, [g.node for g in given], resolver.residuals):
        if number < len(states):
            names.update(states[number].stores)
    return [e for e in elements if e.storage.name in names - known]


def _sharing(
    elements: Sequence[StorageElement],
    states: Sequence[IntegratedState],
    chosen: Sequence[StorageElement],
) -> list[StorageElement]:
    """Further elements that share a state with those that are chosen, directly or through others.

    Their given values would otherwise be lost: the states that they share are free to move.
    """
    own = {element.storage.name for element in chosen}
    names = set(own)
    while more := {
        name
        for state in states
        if not names.isdisjoint(state.stores)
        for name in state.stores
        if name not in names
    }:
        names |= more
    return [e for e in elements if e.storage.name in names - own]


def states_in(dag: Dag, nodes: Iterable[Node], residuals: Mapping[Node, Node]) -> dict[int, Node]:
    """The states that nodes depend on, by number, through `residuals` of algebraic ones."""
    found: dict[int, Node] = {}
    waiting = list(nodes)
    while waiting:
        for node, symbol in dag.symbols_in([waiting.pop()], Kind.STATE).items():
            if symbol.index not in found:
                found[symbol.index] = node
                waiting += [residuals[node]] if node in residuals else []
    return found
