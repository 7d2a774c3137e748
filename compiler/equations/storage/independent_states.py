"""Independent storage: every port keeps its own charge or momentum as a state."""

from __future__ import annotations

from bgc.equations.storage.initial_values import given_values, own_initial_states
from bgc.equations.storage.kinds import IntegratedState, StorageElement, state_name, state_unit
from bgc.equations.variables.definitions import Explicit, Variables
from bgc.ir.causal import Role
from bgc.ir.graph import Node


def integrate_alone(variables: Variables, element: StorageElement) -> list[IntegratedState]:
    """Define the bond variables of an independent element by its own states."""
    causal, dag = variables.causal, variables.dag
    initial = own_initial_states(variables, element)
    for port in element.ports:
        if port.port.role is Role.COMPLIANCE:
            variables.set_answer(port.index, port.answer)
        else:
            answer = port.answer if port.port.through_sign > 0 else dag.neg(port.answer)
            variables.set_flow(causal.class_of[port.port.bond], Explicit(answer))
    return [
        state
        for position, port in enumerate(element.ports)
        for state in _states_of_port(variables, element, position, initial[position])
    ]


def integrate_compliances(variables: Variables, element: StorageElement) -> list[IntegratedState]:
    """The compliances of an IC whose inertias are merged keep their own charges."""
    given, states = given_values(element), []
    for position, port in enumerate(element.ports):
        if port.port.role is Role.COMPLIANCE:
            variables.set_answer(port.index, port.answer)
            start = given.get((position, "p" if port.has_momentum else "q"))
            initial = variables.dag.zero if start is None else start.value
            states += _states_of_port(variables, element, position, initial)
    return states


def _states_of_port(
    variables: Variables, element: StorageElement, position: int, initial: Node
) -> list[IntegratedState]:
    dag, port = variables.dag, element.ports[position]
    given = (
        variables.symbols.port_through(port.port)
        if port.port.role is Role.COMPLIANCE
        else variables.symbols.port_across(port.port)
    )
    momentum = port.has_momentum
    states = [
        IntegratedState(
            port.state,
            state_name(element.storage, "p" if momentum else "q", position),
            state_unit(variables, port.port, momentum=momentum),
            "momentum" if momentum else "displacement",
            dag.sub(given, port.bias),
            initial,
            port.index,
            (element.storage.name,),
        )
    ]
    if port.charge is not None:
        states.append(charge_state(variables, element, position))
    return states


def charge_state(variables: Variables, element: StorageElement, position: int) -> IntegratedState:
    """The charge of an IC port beside its momentum: it integrates the port's flow."""
    port = element.ports[position]
    assert port.charge is not None
    dual = port.port.dual
    flow = (
        variables.symbols.port_across(port.port)
        if dual
        else variables.symbols.port_through(port.port)
    )
    start = given_values(element).get((position, "q"))
    return IntegratedState(
        port.charge,
        state_name(element.storage, "q", position),
        state_unit(variables, port.port, momentum=False),
        "displacement",
        flow,
        start.value if start is not None else variables.dag.zero,
        None,
        (element.storage.name,),
    )
