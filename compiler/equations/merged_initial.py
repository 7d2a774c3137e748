"""Initial values of merged storage: what is given decides, the rest is least energy.

Every given value is one linear condition. They are inserted one at a time: one that already
follows from those before must agree with them, or it is named as the culprit. What the
conditions leave open is settled by the least stored energy, so that nothing given means nothing
stored.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bgc.algebra.dag import Dag
from bgc.algebra.solving import SingularSystemError, solve_definite, solve_general
from bgc.equations.initial import given_values
from bgc.equations.storage import StorageElement, StoragePort
from bgc.equations.variables import Variables
from bgc.grammar.catalogue import causality as catalogue
from bgc.grammar.diagnostics import BgError
from bgc.graph import Initial, Node

_Row = dict[int, Node]
_NEGLIGIBLE = 1e-9  # of a condition's coefficients, or of its value


@dataclass(frozen=True, slots=True)
class _Condition:
    """`sum row * unknown = value`, from an initial value of an element."""

    row: _Row
    value: Node
    element: StorageElement
    initial: Initial


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
        if variable == ("f" if port.has_momentum else "e"):
            weights = {position: dag.one}
        elif variable == ("p" if port.has_momentum else "q") and element.law.capacity is not None:
            weights = dict(enumerate(element.law.capacity[position]))
        elif port.charge is not None and variable == "q":
            continue  # the charge of an IC port is a state of its own
        else:
            raise _unusable(element, initial)
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


def initial_differences(
    variables: Variables,
    elements: Sequence[StorageElement],
    designated: Mapping[int, StoragePort],
    follow: Mapping[int, Mapping[int, Node]],
    driven: Mapping[int, Node],
) -> dict[int, Node]:
    """The initial `Q = q - B q_d` of merged compliances: element port -> node.

    Charges that are given hold; with none given all are zero. Charges not given are those of
    least energy that balance the efforts, and those of the sources that drive the group:
    `K q = K B l + G' w` for conditions `G q = g`.
    """
    dag = variables.dag
    ports = [port for element in elements for port in element.ports]
    place = {port.index: i for i, port in enumerate(ports)}
    conditions = [
        condition
        for element in elements
        for condition in _conditions_on_charges(variables, element, place)
    ]
    charges = [dag.zero] * len(ports)
    if conditions:
        columns = [[dag.zero] * len(ports) for _ in designated]  # of B
        for index, entries in follow.items():
            for column, k in zip(columns, designated, strict=True):
                column[place[index]] = entries.get(k, dag.zero)
        forces = [driven[k] for k in designated]
        charges = _least_energy(variables, elements, conditions, columns, forces, place)
    return {
        port.index: dag.sub(
            charges[place[port.index]],
            dag.sum(
                dag.mul(b, charges[place[designated[k].index]])
                for k, b in follow[port.index].items()
            ),
        )
        for port in ports
    }


def _conditions_on_charges(
    variables: Variables, element: StorageElement, place: Mapping[int, int]
) -> list[_Condition]:
    dag = variables.dag
    found = []
    for (position, variable), initial in given_values(element).items():
        port = element.ports[position]
        if variable == ("p" if port.has_momentum else "q"):
            row = {place[port.index]: dag.one}
        elif element.law.response is not None:
            line = element.law.response[position]
            row = {
                place[other.index]: entry
                for other, entry in zip(element.ports, line, strict=True)
                if entry != dag.zero
            }
        else:
            raise _unusable(element, initial)
        found.append(_Condition(row, initial.value, element, initial))
    return found


def _least_energy(
    variables: Variables,
    elements: Sequence[StorageElement],
    conditions: Sequence[_Condition],
    columns: Sequence[Sequence[Node]],
    forces: Sequence[Node],
    place: Mapping[int, int],
) -> list[Node]:
    """`q = B l + C G' w` with `B' K q = -forces` and `G q = g` (C the inverse of K)."""
    dag = variables.dag
    size = len(place)
    capacity = _whole(variables, elements, place, capacity=True)
    response = _whole(variables, elements, place, capacity=False)
    if capacity is None or response is None:
        raise _unusable(conditions[0].element, conditions[0].initial)
    tests = [_times(dag, response, column) for column in columns]
    right = [dag.neg(force) for force in forces]
    balances = [
        ({i: node for i, node in enumerate(test) if node != dag.zero}, value)
        for test, value in zip(tests, right, strict=True)
    ]
    spans = list(columns)
    for condition in _independent(variables, conditions, balances):
        row = [condition.row.get(i, dag.zero) for i in range(size)]
        spans.append(_times(dag, capacity, row))
        tests.append(row)
        right.append(condition.value)
    matrix = [{j: dag.dot(test, column) for j, column in enumerate(spans)} for test in tests]
    weights = _solve(variables, matrix, right)
    return [dag.dot(weights, (column[i] for column in spans)) for i in range(size)]


def _whole(
    variables: Variables,
    elements: Sequence[StorageElement],
    place: Mapping[int, int],
    *,
    capacity: bool,
) -> list[_Row] | None:
    """The laws of all elements as one matrix."""
    rows: list[_Row] = [{} for _ in place]
    for element in elements:
        law = element.law.capacity if capacity else element.law.response
        if law is None:
            return None
        for port, line in zip(element.ports, law, strict=True):
            for other, entry in zip(element.ports, line, strict=True):
                if entry != variables.dag.zero:
                    rows[place[port.index]][place[other.index]] = entry
    return rows


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
        raise _unusable(conditions[0].element, conditions[0].initial)
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


def _unusable(element: StorageElement, initial: Initial) -> BgError:
    return BgError(
        [catalogue.initial_unusable(initial.span, element.storage.name, f"{initial.variable}0")]
    )
