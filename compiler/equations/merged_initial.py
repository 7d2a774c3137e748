"""Initial values of merged storage: what is given decides, the rest is least energy.

Every given value is one linear condition. They are inserted one at a time: one that already
follows from those before must agree with them, or it is named as the culprit. What the
conditions leave open is settled by the least stored energy, so that nothing given means nothing
stored.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from bgc.algebra.dag import Dag
from bgc.algebra.linalg import identity
from bgc.algebra.solving import SingularSystemError, solve_definite, solve_general
from bgc.causality.causal import Role
from bgc.equations.initial import given_values
from bgc.equations.merged_flows import momenta_of
from bgc.equations.storage import IntegratedState, StorageElement
from bgc.equations.variables import Variables
from bgc.grammar.catalogue import causality as catalogue
from bgc.grammar.diagnostics import BgError
from bgc.graph import Initial, Matrix, Node

_Row = dict[int, Node]
_NEGLIGIBLE = 1e-9  # of a condition's coefficients, or of its value


@dataclass(frozen=True, slots=True)
class _Condition:
    """`sum row * unknown = value`, from an initial value of an element."""

    row: _Row
    value: Node
    element: StorageElement
    initial: Initial | None  # None of a value that nothing was said about


def initial_momenta(
    variables: Variables, elements: Sequence[StorageElement], flows: Sequence[int]
) -> dict[int, Node]:
    """The initial merged momenta of inertias on the given independent flows.

    Conditions are on the flows u: `N_k u = f0`, `M_k N u = p0`. Least energy means
    `pi = G' l` for the conditions `G u = g`.
    """
    dag = variables.dag
    order = {k: i for i, k in enumerate(flows)}
    conditions = [
        condition
        for element in elements
        for condition in _conditions_on_flows(variables, element, order)
    ]
    chosen = _independent(variables, conditions)
    if not chosen:
        return dict.fromkeys(flows, dag.zero)
    if len(chosen) == len(flows) and all(e.law.capacity is not None for e in elements):
        right = [condition.value for condition in chosen]
        if any(value != dag.zero for value in right):
            right = _solve(variables, [condition.row for condition in chosen], right)
        return momenta_of(variables, elements, {k: right[i] for k, i in order.items()})
    mass, driven = _reduced_mass(variables, elements, order)
    columns = [[c.row.get(i, dag.zero) for i in range(len(order))] for c in chosen]
    *answers, response = solve_definite(
        dag, variables.causal.fingerprints, mass, [*columns, driven]
    )
    matrix = [
        {j: dag.dot(column, answer) for j, answer in enumerate(answers)} for column in columns
    ]
    right = [
        dag.add(c.value, dag.dot(column, response))
        for c, column in zip(chosen, columns, strict=True)
    ]
    weights = _solve(variables, matrix, right)
    return {k: dag.dot(weights, (column[i] for column in columns)) for k, i in order.items()}


def _conditions_on_flows(
    variables: Variables, element: StorageElement, order: Mapping[int, int]
) -> list[_Condition]:
    dag = variables.dag
    found = []
    for (position, variable), initial in given_values(element).items():
        port = element.ports[position]
        if (port.port.role is Role.COMPLIANCE and variable in "qp") or (
            port.charge is not None and variable == "q"
        ):
            continue  # an IC's own state beside its merged momenta
        if variable == ("f" if port.has_momentum else "e"):
            weights = {position: dag.one}
        elif variable == ("p" if port.has_momentum else "q") and element.law.capacity is not None:
            weights = dict(enumerate(element.law.capacity[position]))
        else:
            raise _unusable(_Condition({}, dag.zero, element, initial))
        row: _Row = {}
        value = initial.value
        for other, weight in weights.items():
            for k, entry in element.ports[other].flow.items():
                term = dag.mul(weight, entry)
                if k in order:
                    row[order[k]] = dag.add(row.get(order[k], dag.zero), term)
                else:
                    value = dag.sub(value, dag.mul(term, variables.independent(k)))
        found.append(_Condition(row, value, element, initial))
    return found


def _reduced_mass(
    variables: Variables, elements: Sequence[StorageElement], order: Mapping[int, int]
) -> tuple[list[_Row], list[Node]]:
    """`N' M N`, and `N' M N_s s` of the sources that drive the elements."""
    dag = variables.dag
    mass: list[_Row] = [{} for _ in order]
    driven = [dag.zero] * len(order)
    for element in elements:
        if element.law.capacity is None:
            continue
        for port, line in zip(element.ports, element.law.capacity, strict=True):
            for other, entry in zip(element.ports, line, strict=True):
                if entry == dag.zero:
                    continue
                for k, left in port.flow.items():
                    if k not in order:
                        continue
                    i = order[k]
                    for m, right in other.flow.items():
                        term = dag.mul(left, dag.mul(entry, right))
                        if m in order:
                            j = order[m]
                            mass[i][j] = dag.add(mass[i].get(j, dag.zero), term)
                        else:
                            source = variables.independent(m)
                            driven[i] = dag.add(driven[i], dag.mul(term, source))
    return mass, driven


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
    """What free motions join: compliances, their states, and momenta."""

    compliances: tuple[StorageElement, ...]
    charges: tuple[IntegratedState, ...]  # of all their ports
    momenta: tuple[Momenta, ...]


@dataclass(frozen=True, slots=True)
class _Quadratic:
    """The energy of what is stored: `response` times the quantities, less what `offset` is."""

    response: list[_Row]
    capacity: list[_Row]
    offset: list[Node]


def initial_quantities(
    variables: Variables,
    stored: Stored,
    motions: Sequence[Mapping[Node, Node]],
    driven: Sequence[Node],
) -> dict[Node, Node]:
    """The initial quantities that free motions join: symbol of the state -> node.

    `motions` are B, one column each, and `driven` what sources add to the balance on each:
    `B' K x + driven = 0`. Values that are given hold; with none given all are zero. What they
    leave open is settled by the least energy: `K x = K B l + G' w` for conditions `G x = g`.
    """
    dag = variables.dag
    states = [*stored.charges, *(state for block in stored.momenta for state in block.states)]
    place = {state.symbol: i for i, state in enumerate(states)}
    moved = {symbol for column in motions for symbol in column}
    conditions = [
        condition
        for element in stored.compliances
        for condition in _conditions_on_charges(variables, element, place)
    ] + [c for block in stored.momenta for c in _conditions_on_momenta(dag, block, place)]
    if not conditions:
        return {state.symbol: state.initial for state in states}
    told = {i for c in conditions for i in c.row}
    for state in states:
        if state.symbol not in moved and place[state.symbol] not in told:
            row = {place[state.symbol]: dag.one}
            conditions.append(_Condition(row, state.initial, conditions[0].element, None))
    energy = _energy(variables, stored, place)
    if energy is None:
        raise _unusable(conditions[0])
    columns = [[column.get(symbol, dag.zero) for symbol in place] for column in motions]
    values = _least_energy(variables, energy, conditions, columns, driven)
    return dict(zip(place, values, strict=True))


def _conditions_on_charges(
    variables: Variables, element: StorageElement, place: Mapping[Node, int]
) -> list[_Condition]:
    dag = variables.dag
    found = []
    for (position, variable), initial in given_values(element).items():
        port = element.ports[position]
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
            raise _unusable(_Condition({}, dag.zero, element, initial))
        found.append(_Condition(row, initial.value, element, initial))
    return found


def _conditions_on_momenta(dag: Dag, block: Momenta, place: Mapping[Node, int]) -> list[_Condition]:
    """Momenta of which an initial value is given stay as they were found from it."""
    given = [(e, initial) for e in block.elements for initial in e.storage.initial]
    if not given:
        return []
    element, initial = given[0]
    return [
        _Condition({place[state.symbol]: dag.one}, state.initial, element, initial)
        for state in block.states
    ]


def _energy(variables: Variables, stored: Stored, place: Mapping[Node, int]) -> _Quadratic | None:
    """The energy as a quadratic form; None where a law is not linear."""
    dag = variables.dag
    energy = _Quadratic([{} for _ in place], [{} for _ in place], [dag.zero] * len(place))

    def enter(symbols: Sequence[Node], response: Matrix | None, capacity: Matrix | None) -> bool:
        if response is None or capacity is None:
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
        mass, offset = _reduced_mass(variables, block.elements, order)
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
    conditions: Sequence[_Condition],
    columns: Sequence[Sequence[Node]],
    driven: Sequence[Node],
) -> list[Node]:
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
    for condition in _independent(variables, shifted, balances):
        row = [condition.row.get(i, dag.zero) for i in range(size)]
        spans.append(_times(dag, energy.capacity, row))
        tests.append(row)
        right.append(condition.value)
    matrix = [{j: dag.dot(test, column) for j, column in enumerate(spans)} for test in tests]
    weights = _solve(variables, matrix, right)
    return [
        dag.add(energy.offset[i], dag.dot(weights, (column[i] for column in spans)))
        for i in range(size)
    ]


def _times(dag: Dag, rows: Sequence[_Row], vector: Sequence[Node]) -> list[Node]:
    return [dag.sum(dag.mul(entry, vector[j]) for j, entry in row.items()) for row in rows]


def _independent(
    variables: Variables,
    conditions: Sequence[_Condition],
    balances: Sequence[tuple[_Row, Node]] = (),
) -> list[_Condition]:
    """Insert conditions one at a time; one that follows from others has to agree.

    Both are judged in numbers, at the start and the parameters' default values. The balances,
    as rows and right-hand sides, hold in any case and come first.
    """
    if not conditions:
        return []
    equations = [*balances, *((c.row, c.value) for c in conditions)]
    columns = sorted({j for row, _ in equations for j in row})
    width = len(columns) + 1
    nodes = [
        node
        for row, value in equations
        for node in (*(row.get(j, variables.dag.zero) for j in columns), value)
    ]
    values = variables.at_start(nodes)
    if values is None or not all(map(math.isfinite, values)):
        raise _unusable(conditions[0])
    reduced: list[tuple[int, list[float]]] = []  # pivot, row with its value
    chosen: list[_Condition] = []
    for k in range(len(equations)):
        condition = conditions[k - len(balances)] if k >= len(balances) else None
        row = values[k * width : (k + 1) * width]
        size = max(map(abs, row[:-1]), default=0.0)
        for pivot, other in reduced:
            factor = row[pivot] / other[pivot]
            row = [x - factor * y for x, y in zip(row, other, strict=True)]
        pivot = max(range(width - 1), key=lambda j: abs(row[j]), default=-1)
        if pivot >= 0 and abs(row[pivot]) > _NEGLIGIBLE * size:
            reduced.append((pivot, row))
            if condition is not None:
                chosen.append(condition)
        elif condition is not None and abs(row[-1]) > _NEGLIGIBLE * max(
            1.0, abs(values[(k + 1) * width - 1])
        ):
            raise _contradiction(condition, chosen)
    return chosen


def _contradiction(condition: _Condition, others: Sequence[_Condition]) -> BgError:
    names = list(dict.fromkeys(other.element.storage.name for other in others))
    assert condition.initial is not None, "what nothing was said about contradicts nothing"
    variable, span = f"{condition.initial.variable}0", condition.initial.span
    name = condition.element.storage.name
    return BgError([catalogue.initial_conflict(span, name, variable, names)])


def _solve(variables: Variables, matrix: Sequence[_Row], right: Sequence[Node]) -> list[Node]:
    dag = variables.dag
    try:
        return solve_general(
            dag, variables.causal.fingerprints, matrix, right, lambda node: dag.level[node]
        )
    except SingularSystemError:
        raise AssertionError("conditions that were inserted one by one are dependent") from None


def _unusable(condition: _Condition) -> BgError:
    initial, name = condition.initial, condition.element.storage.name
    assert initial is not None, "values that are given come first"
    return BgError([catalogue.initial_unusable(initial.span, name, f"{initial.variable}0")])
