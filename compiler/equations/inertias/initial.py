"""Initial momenta of merged inertias: given values hold, the rest has the least energy.

Among all momenta that satisfy the given values, those with the least stored energy are chosen.
Without given values all momenta are zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.solving import solve_definite
from bgc.equations.inertias.flows import momenta_of
from bgc.equations.storage.conditions import (
    Condition,
    Row,
    independent_conditions,
    solve_conditions,
    unusable,
)
from bgc.equations.storage.initial import given_values
from bgc.equations.storage.kinds import StorageElement
from bgc.equations.variables.variables import Variables
from bgc.ir.causal import Role
from bgc.ir.graph import Node


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
    chosen = independent_conditions(variables, conditions)
    if not chosen:
        return dict.fromkeys(flows, dag.zero)
    if len(chosen) == len(flows) and all(e.law.capacity is not None for e in elements):
        right = [condition.value for condition in chosen]
        if any(value != dag.zero for value in right):
            right = solve_conditions(variables, [condition.row for condition in chosen], right)
        return momenta_of(variables, elements, {k: right[i] for k, i in order.items()})
    mass, driven = reduced_mass(variables, elements, order)
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
    weights = solve_conditions(variables, matrix, right)
    return {k: dag.dot(weights, (column[i] for column in columns)) for k, i in order.items()}


def _conditions_on_flows(
    variables: Variables, element: StorageElement, order: Mapping[int, int]
) -> list[Condition]:
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
            raise unusable(Condition({}, dag.zero, element, initial))
        row: Row = {}
        value = initial.value
        for other, weight in weights.items():
            for k, entry in element.ports[other].flow.items():
                term = dag.mul(weight, entry)
                if k in order:
                    row[order[k]] = dag.add(row.get(order[k], dag.zero), term)
                else:
                    value = dag.sub(value, dag.mul(term, variables.independent(k)))
        found.append(Condition(row, value, element, initial))
    return found


def reduced_mass(
    variables: Variables, elements: Sequence[StorageElement], order: Mapping[int, int]
) -> tuple[list[Row], list[Node]]:
    """`N' M N`, and `N' M N_s s` of the sources that drive the elements."""
    dag = variables.dag
    mass: list[Row] = [{} for _ in order]
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
