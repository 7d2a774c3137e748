"""Initial values of storage joined by free motions: given values hold, the rest has least energy.

The power balance on each motion always holds. Without given values nothing is stored. Where a law
is not linear, the elements are noted in `Variables.starting`, and `start/` solves for their start.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from bgc.algebra.dag import Dag
from bgc.algebra.linalg import identity
from bgc.algebra.symbolic_systems import solve_definite
from bgc.equations.inertias.initial_momenta import reduced_mass
from bgc.equations.storage.conditions import (
    Condition,
    Row,
    independent_conditions,
    solve_conditions,
    unusable,
)
from bgc.equations.storage.initial_values import given_values
from bgc.equations.storage.kinds import IntegratedState, StorageElement, StoragePort
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import Role
from bgc.ir.graph import Initial, Matrix, Node


@dataclass(frozen=True, slots=True)
class Momenta:
    """Momenta that are states: of an inertia alone, or of dependent ones merged.

    `flows` are the independent flows of merged ones, None where each is a port's own.
    """

    elements: tuple[StorageElement, ...]
    states: tuple[IntegratedState, ...]
    flows: tuple[int, ...] | None


@dataclass(frozen=True, slots=True)
class Stored:
    """The storage that free motions join: compliances with their states, and momenta."""

    compliances: tuple[StorageElement, ...]
    charges: tuple[IntegratedState, ...]  # of all their ports
    momenta: tuple[Momenta, ...]

    @property
    def states(self) -> tuple[IntegratedState, ...]:
        """All states, charges first."""
        return (*self.charges, *(state for block in self.momenta for state in block.states))

    @property
    def elements(self) -> tuple[StorageElement, ...]:
        """All elements, compliances first."""
        return (*self.compliances, *(e for block in self.momenta for e in block.elements))


@dataclass(frozen=True, slots=True)
class _Quadratic:
    """The stored energy as a quadratic form: `response` times the quantities minus `offset`."""

    response: list[Row]
    capacity: list[Row]
    offset: list[Node]


def initial_quantities(
    variables: Variables,
    stored: Stored,
    motions: Sequence[Mapping[Node, Node]],
    driven: Sequence[Node],
) -> dict[Node, Node]:
    """The initial quantities that free motions join: symbol of the state -> node.

    `motions` are B, one column each, and `driven` the share of sources in the balances on them:
    `B' K x + driven = 0`. Values that are given hold; with none given all are zero. What they
    leave open is settled by the least energy: `K x = K B l + G' w` for conditions `G x = g`.

    Raises
    ------
    BgError
        A value contradicts others or a balance, or cannot be used.
    """
    together = {e.ports[0].port.element for e in stored.elements}
    energy = None
    if not any(element.storage.initial for element in stored.elements):
        return {state.symbol: state.initial for state in stored.states}
    if variables.starting.isdisjoint(together):
        place = {state.symbol: i for i, state in enumerate(stored.states)}
        energy = _energy(variables, stored, place)
    values = None
    if energy is not None:
        values = _linear_quantities(variables, stored, energy, motions, driven)
    if values is None:
        variables.starting |= together
        return {state.symbol: state.initial for state in stored.states}
    return values


def _linear_quantities(
    variables: Variables,
    stored: Stored,
    energy: _Quadratic,
    motions: Sequence[Mapping[Node, Node]],
    driven: Sequence[Node],
) -> dict[Node, Node] | None:
    """The initial quantities of linear laws; None where they are not certain to be solvable."""
    dag, states = variables.dag, stored.states
    place = {state.symbol: i for i, state in enumerate(states)}
    moved = {symbol for column in motions for symbol in column}
    conditions = [
        condition
        for element in stored.compliances
        for condition in _conditions_on_charges(variables, element, place)
    ] + [c for block in stored.momenta for c in _conditions_on_momenta(dag, block, place)]
    if not conditions:
        return {state.symbol: state.initial for state in states}
    conditioned = {i for c in conditions for i in c.row}
    for state in states:
        if state.symbol not in moved and place[state.symbol] not in conditioned:
            row = {place[state.symbol]: dag.one}
            conditions.append(Condition(row, state.initial, conditions[0].name, None))
    columns = [[column.get(symbol, dag.zero) for symbol in place] for column in motions]
    values = _least_energy(variables, energy, conditions, columns, driven)
    return None if values is None else dict(zip(place, values, strict=True))


def _conditions_on_charges(
    variables: Variables, element: StorageElement, place: Mapping[Node, int]
) -> list[Condition]:
    dag = variables.dag
    found = []
    for (position, variable), initial in given_values(element).items():
        port = element.ports[position]
        beside = variable == ("q" if port.has_momentum else "p")
        if port.port.role is not Role.COMPLIANCE or (beside and _is_beside(dag, port, initial)):
            continue
        if variable == ("p" if port.has_momentum else "q"):
            row = {place[port.state]: dag.one}
        elif element.law.response is not None:
            line = element.law.response[position]
            row = {
                place[other.state]: entry
                for other, entry in zip(element.ports, line, strict=True)
                if entry != dag.zero
            }
        else:
            raise unusable(Condition({}, dag.zero, element.storage.name, initial))
        found.append(Condition(row, initial.value, element.storage.name, initial))
    return found


def _is_beside(dag: Dag, port: StoragePort, initial: Initial) -> bool:
    """Return whether a value belongs to an IC's other state, or is a zero that imposes nothing."""
    return port.has_momentum or initial.value == dag.zero


def _conditions_on_momenta(dag: Dag, block: Momenta, place: Mapping[Node, int]) -> list[Condition]:
    """Conditions that keep momenta with a given initial value at that value."""
    given = [(e, initial) for e in block.elements for initial in e.storage.initial]
    if not given:
        return []
    element, initial = min(given, key=lambda pair: pair[1].is_default)
    return [
        Condition({place[state.symbol]: dag.one}, state.initial, element.storage.name, initial)
        for state in block.states
    ]


def _energy(variables: Variables, stored: Stored, place: Mapping[Node, int]) -> _Quadratic | None:
    """The energy as a quadratic form; None where a law is not linear."""
    dag = variables.dag
    energy = _Quadratic([{} for _ in place], [{} for _ in place], [dag.zero] * len(place))

    def enter(symbols: Sequence[Node], response: Matrix | None, capacity: Matrix | None) -> bool:
        if response is None or capacity is None or not set(symbols) <= place.keys():
            return False
        places = [place[symbol] for symbol in symbols]
        for rows, matrix in ((energy.response, response), (energy.capacity, capacity)):
            for i, line in zip(places, matrix, strict=True):
                rows[i] = {j: x for j, x in zip(places, line, strict=True) if x != dag.zero}
        return True

    for element in stored.compliances:
        symbols = [port.state for port in element.ports]
        if not enter(symbols, element.law.response, element.law.capacity):
            return None
    for block in stored.momenta:
        symbols = [state.symbol for state in block.states]
        if block.flows is None:
            law = block.elements[0].law
            if not enter(symbols, law.response, law.capacity):
                return None
            continue
        if any(element.law.capacity is None for element in block.elements):
            return None
        order = {k: i for i, k in enumerate(block.flows)}
        mass, offset = reduced_mass(variables, block.elements, order)
        units = identity(dag, len(order))
        inverse = solve_definite(dag, variables.causal.fingerprints, mass, units)
        whole = tuple(tuple(row.get(j, dag.zero) for j in range(len(order))) for row in mass)
        enter(symbols, tuple(tuple(line) for line in inverse), whole)
        for symbol, node in zip(symbols, offset, strict=True):
            energy.offset[place[symbol]] = node
    return energy


def _least_energy(
    variables: Variables,
    energy: _Quadratic,
    conditions: Sequence[Condition],
    columns: Sequence[Sequence[Node]],
    driven: Sequence[Node],
) -> list[Node] | None:
    """`x - d = B l + C G' w` with `B' K (x - d) = -driven` and `G x = g` (C the inverse of K)."""
    dag = variables.dag
    size = len(energy.offset)
    tests = [_times(dag, energy.response, column) for column in columns]
    right = [dag.neg(node) for node in driven]
    balances = [
        ({i: node for i, node in enumerate(test) if node != dag.zero}, value)
        for test, value in zip(tests, right, strict=True)
    ]
    spans = list(columns)
    shifted = [
        replace(
            c,
            value=dag.sub(c.value, dag.sum(dag.mul(x, energy.offset[i]) for i, x in c.row.items())),
        )
        for c in conditions
    ]
    chosen = independent_conditions(variables, shifted, balances)
    if chosen is None:
        return None
    for condition in chosen:
        row = [condition.row.get(i, dag.zero) for i in range(size)]
        spans.append(_times(dag, energy.capacity, row))
        tests.append(row)
        right.append(condition.value)
    matrix = [{j: dag.dot(test, column) for j, column in enumerate(spans)} for test in tests]
    weights = solve_conditions(variables, matrix, right)
    if weights is None:
        return None
    return [
        dag.add(energy.offset[i], dag.dot(weights, (column[i] for column in spans)))
        for i in range(size)
    ]


def _times(dag: Dag, rows: Sequence[Row], vector: Sequence[Node]) -> list[Node]:
    return [dag.sum(dag.mul(entry, vector[j]) for j, entry in row.items()) for row in rows]
