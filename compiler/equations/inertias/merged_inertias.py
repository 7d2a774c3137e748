"""Merge dependent inertias: one generalised momentum for each independent flow.

Inertias on flows `N u` are merged into the generalised momentum `pi = N' p` (Karnopp's IC
field): `u` follows from `pi` by the reduced mass `N' M N`, and

    pi' = -(the other efforts on u) + (dN/dt)' p,

in which no rate of an effort or of a source occurs. The reduced mass is symmetric positive
definite; with a law that is not linear its equations are solved by iteration.
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Kind
from bgc.algebra.quadratic import SingularFormError
from bgc.equations.inertias.flows import reduced_flows, turning_forces
from bgc.equations.inertias.groups import Group, cannot_merge, find_groups
from bgc.equations.inertias.inertia_audit import MergedAudit
from bgc.equations.storage.accounts import is_symmetric
from bgc.equations.storage.coordinates import element_coordinate, flow_coordinate
from bgc.equations.storage.independent_states import charge_state, integrate_compliances
from bgc.equations.storage.kinds import (
    IntegratedState,
    StorageElement,
    state_name,
    state_unit,
)
from bgc.equations.variables.definitions import Explicit, Unknown, Variables
from bgc.ir.causal import Role
from bgc.ir.graph import LinearLaw, Node


def merge_inertias(
    variables: Variables, elements: Sequence[StorageElement]
) -> list[IntegratedState]:
    """Define momenta and independent flows of dependent inertias; their states."""
    groups = find_groups(variables, elements)
    together = [element for group in groups for element in group.elements]
    variables.balances.turning = turning_forces(variables, together)
    states = [s for element in together for s in integrate_compliances(variables, element)]
    audit = MergedAudit(variables, groups)
    taken: set[str] = set()
    for group in groups:
        _refuse_without_energy(variables, group)
        states += _merge_inertia_group(variables, group, audit, taken)
    audit.assert_powerless()
    return states


def _merge_inertia_group(
    variables: Variables, group: Group, audit: MergedAudit, taken: set[str]
) -> list[IntegratedState]:
    """The states of a group. `taken` collects their names.

    The flows of a group whose laws are not linear, or whose eliminated flows fail the check, are
    unknowns of `pi = N' p`.
    """
    dag, causal = variables.dag, variables.causal
    merged = {k: variables.new_state(Kind.MOMENTUM) for k in group.flows}
    for element in group.elements:
        _define_momenta(variables, element)
    flows = None
    audit.require_moved(group)
    if group.is_linear:
        flows = _reduced_flows(variables, group, merged)
        if not audit.is_solved(group, merged, flows):
            flows = None
    for k, state in merged.items():
        number = causal.basis[k].bond_class
        if flows is not None:
            variables.set_flow(number, Explicit(flows[k]))
        else:
            moved = dag.sum(dag.mul(p.flow[k], p.state) for p in group.ports if k in p.flow)
            variables.set_flow(number, Unknown())
            variables.add_equation(dag.sub(state, moved), variables.symbols.of_class(number))
    states = [
        charge_state(variables, element, position)
        for element in group.elements
        for position, port in enumerate(element.ports)
        if port.charge is not None and port.port.role is Role.INERTIA
    ]
    held = {k: _held(group, k) for k in merged}
    names = _merged_names(variables, group, taken)
    for k, state in merged.items():
        first = next(p for p in group.ports if k in p.flow)
        states.append(
            IntegratedState(
                state,
                names[k],
                state_unit(variables, first.port, momentum=not first.port.dual),
                "displacement" if first.port.dual else "momentum",
                variables.balances.merged_balance(causal.basis[k].bond_class),
                dag.zero,  # `start_inertias` gives the value
                None,
                held[k],
                flow=k,
            )
        )
    return states


def _refuse_without_energy(variables: Variables, group: Group) -> None:
    """Refuse an inertia without a kinetic energy (not symmetric), which cannot be merged."""
    for element in group.elements:
        law = element.storage.law
        if isinstance(law, LinearLaw) and not is_symmetric(variables, law.matrix):
            raise cannot_merge(group, f"the inertia of `{element.storage.name}` is not symmetric")


def _define_momenta(variables: Variables, element: StorageElement) -> None:
    """A merged inertia's momenta follow from its flows; its efforts are their rates."""
    dag = variables.dag
    flows = [variables.symbols.port_through(port.port) for port in element.ports]
    for position, port in enumerate(element.ports):
        if port.port.role is not Role.INERTIA:
            continue
        if element.law.capacity is not None:
            node = dag.dot(element.law.capacity[position], flows)
            variables.set_definition(port.state, Explicit(node), port.port.element)
        else:
            variables.set_definition(port.state, Unknown(), port.port.element)
            variables.add_equation(dag.sub(flows[position], port.answer), port.state)
        variables.set_rate_of(port.index, port.state, port.bias)


def _reduced_flows(variables: Variables, group: Group, merged: dict[int, Node]) -> dict[int, Node]:
    try:
        return reduced_flows(variables, group, merged)
    except SingularFormError:
        raise cannot_merge(group, "their common inertia is singular") from None


def _held(group: Group, k: int) -> tuple[str, ...]:
    """The elements that a merged momentum belongs to."""
    return tuple(e.storage.name for e in group.elements if any(k in p.flow for p in e.ports))


def _merged_names(variables: Variables, group: Group, taken: set[str]) -> dict[int, str]:
    """The name of each merged momentum, after its flow; names given are added to `taken`."""
    causal = variables.causal
    names: dict[int, str] = {}
    for k in group.flows:
        name = flow_coordinate(variables, causal.basis[k].bond_class, taken)
        if name is None:
            element, port = next((e, p) for e in group.elements for p in e.ports if k in p.flow)
            letter = "q" if port.port.dual else "p"
            own = state_name(element.storage, letter, port.port.position)
            name = element_coordinate(own, taken)
        names[k] = name
        taken.add(name)
    return names
