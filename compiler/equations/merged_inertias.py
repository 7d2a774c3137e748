"""Dependent inertias merged: one momentum for each flow that rigid connections make one.

Inertias on flows `N u` are merged into the generalised momentum `pi = N' p` (Karnopp's IC
field): `u` follows from `pi` by the reduced mass `N' M N`, and

    pi' = -(the other efforts on u) + (dN/dt)' p,

in which no rate of an effort or of a source occurs. The reduced mass is symmetric positive
definite; with a law that is not linear its equations are solved by iteration.
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Kind, Level
from bgc.algebra.solving import SingularSystemError, solve_definite
from bgc.causality.causal import BasisKind, Role
from bgc.equations.integrating import charge_state
from bgc.equations.merged_groups import Group, cannot_merge, find_groups, shortened
from bgc.equations.merged_initial import initial_momenta
from bgc.equations.storage import IntegratedState, StorageElement, state_unit
from bgc.equations.variables import Explicit, Unknown, Variables
from bgc.graph import Node


def merge_inertias(
    variables: Variables, elements: Sequence[StorageElement]
) -> list[IntegratedState]:
    """Define momenta and independent flows of dependent inertias; their states."""
    groups = find_groups(variables, elements, Role.INERTIA, BasisKind.INERTIA)
    return [state for group in groups for state in _merge_inertia_group(variables, group)]


def _merge_inertia_group(variables: Variables, group: Group) -> list[IntegratedState]:
    dag, causal = variables.dag, variables.causal
    if any(port.port.role is not Role.INERTIA for port in group.ports):
        raise cannot_merge(group, "its energy mixes charges and momenta")
    merged = {k: variables.new_state(Kind.MOMENTUM) for k in group.flows}
    linear = all(element.law.capacity is not None for element in group.elements)
    for element in group.elements:
        _define_momenta(variables, element)
    flows = _reduced_flows(variables, group, merged) if linear else None
    for k, state in merged.items():
        number = causal.basis[k].bond_class
        if flows is not None:
            variables.set_flow(number, Explicit(flows[k]))
        else:
            held = dag.sum(dag.mul(p.flow[k], p.state) for p in group.ports if k in p.flow)
            variables.set_flow(number, Unknown())
            variables.add_equation(dag.sub(state, held), variables.symbols.of_class(number))
    states = [
        charge_state(variables, element, position)
        for element in group.elements
        for position, port in enumerate(element.ports)
        if port.charge is not None
    ]
    names = _merged_names(group, merged, "p")
    start = initial_momenta(variables, group.elements, list(merged))
    for k, state in merged.items():
        first = next(p for p in group.ports if k in p.flow)
        states.append(
            IntegratedState(
                state,
                names[k],
                state_unit(variables, first.port, momentum=not first.port.dual),
                "displacement" if first.port.dual else "momentum",
                _momentum_rate(variables, group, k),
                start[k],
                None,
            )
        )
    return states


def _define_momenta(variables: Variables, element: StorageElement) -> None:
    """A merged inertia's momenta follow from its flows; its efforts are their rates."""
    dag = variables.dag
    flows = [variables.symbols.port_through(port.port) for port in element.ports]
    for position, port in enumerate(element.ports):
        if element.law.capacity is not None:
            node = dag.dot(element.law.capacity[position], flows)
            variables.set_definition(port.state, Explicit(node), port.port.element)
        else:
            variables.set_definition(port.state, Unknown(), port.port.element)
            variables.add_equation(dag.sub(flows[position], port.answer), port.state)
        variables.set_rate_of(port.index, port.state, port.bias)


def _reduced_flows(variables: Variables, group: Group, merged: dict[int, Node]) -> dict[int, Node]:
    """`u = (N' M N)^-1 (pi - N' M N_s s)` over the independent flows of a group."""
    dag = variables.dag
    order = {k: i for i, k in enumerate(merged)}
    matrix: list[dict[int, Node]] = [{} for _ in order]
    right = list(merged.values())
    for element in group.elements:
        capacity = element.law.capacity
        assert capacity is not None
        for port, line in zip(element.ports, capacity, strict=True):
            momentum: dict[int, Node] = {}  # of this port, over the basis
            for other, entry in zip(element.ports, line, strict=True):
                if entry != dag.zero:
                    for k, node in other.flow.items():
                        term = dag.mul(entry, node)
                        momentum[k] = dag.add(momentum.get(k, dag.zero), term)
            for k, node in port.flow.items():
                if k not in order:
                    continue
                row = matrix[order[k]]
                for other_k, held in momentum.items():
                    term = dag.mul(node, held)
                    if other_k in order:
                        column = order[other_k]
                        row[column] = dag.add(row.get(column, dag.zero), term)
                    else:
                        source = variables.independent(other_k)
                        right[order[k]] = dag.sub(right[order[k]], dag.mul(term, source))
    try:
        (solution,) = solve_definite(dag, variables.causal.fingerprints, matrix, [right])
    except SingularSystemError:
        raise cannot_merge(group, "their common inertia is singular") from None
    return {k: solution[i] for k, i in order.items()}


def _momentum_rate(variables: Variables, group: Group, k: int) -> Node:
    """`pi' = -(efforts of the rest) - N' bias + (dN/dt)' p`."""
    dag = variables.dag
    rate = variables.balances.balance(variables.causal.basis[k].bond_class, -1)
    for port in group.ports:
        entry = port.flow.get(k)
        if entry is None:
            continue
        rate = dag.sub(rate, dag.mul(entry, port.bias))
        if dag.level[entry] > Level.PARAM:
            turning = variables.rate_of(entry, port.port.element)
            rate = dag.add(rate, dag.mul(turning, port.state))
    return rate


def _merged_names(group: Group, merged: dict[int, Node], letter: str) -> dict[int, str]:
    """A name for each merged momentum: the elements on its flow."""
    names: dict[int, str] = {}
    for k in merged:
        on_flow = [e.storage.name for e in group.elements if any(k in p.flow for p in e.ports)]
        name = f"merged({shortened(on_flow)}).{letter}"
        again = sum(1 for other in names.values() if other.split("#")[0] == name)
        names[k] = f"{name}#{again + 1}" if again else name
    return names
