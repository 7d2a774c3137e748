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
from bgc.algebra.dense import soft_motion
from bgc.algebra.quadratic import ConstrainedEnergy, SingularFormError
from bgc.causality.assign import may_be_opened
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.inertias.flows import kinetic_energy, watch_pivots
from bgc.equations.inertias.groups import Group, find_groups, inertias_of
from bgc.equations.inertias.own_momenta import elements_on_flows
from bgc.equations.inertias.turning import turning_forces
from bgc.equations.storage.accounts import is_symmetric
from bgc.equations.storage.constrained_energy import (
    ReducedMatrix,
    cannot_merge,
    determine,
)
from bgc.equations.storage.coordinates import element_coordinate, flow_coordinate
from bgc.equations.storage.independent_states import (
    charge_state,
    integrate_alone,
    integrate_compliances,
)
from bgc.equations.storage.kinds import (
    IntegratedState,
    StorageElement,
    state_name,
    state_unit,
)
from bgc.equations.variables.definitions import Explicit, Unknown, Variables
from bgc.ir.causal import Role
from bgc.ir.graph import LinearLaw, Node

_LEAST_EIGENVALUE = 1e-9  # eigenvalue of the reduced mass scaled to a diagonal of ones
_ROUNDING = 1e-13  # the same without masses
_NO_MASS = 1e-24  # of the largest: less is what coefficients of rounded data leave over, squared
_NO_MASS_IN_A_CHAIN = 1e-12  # the same where a closed chain can be opened, and moves them then
_STILL = 1e-6  # of the fastest flow: slower ones are zero up to rounding
_TAKING_PART = 1e-3  # of the fastest


def merge_inertias(
    variables: Variables, elements: Sequence[StorageElement]
) -> list[IntegratedState]:
    """Define momenta and independent flows of dependent inertias; their states."""
    groups = find_groups(variables, elements)
    keeping = [elements_on_flows(variables, group) for group in groups]
    pairs = list(zip(groups, keeping, strict=True))
    merged = [element for group, kept in pairs if not kept for element in group.elements]
    variables.balances.turning = turning_forces(variables, merged)
    states = []
    for group, kept in pairs:
        for element in group.elements:
            start = integrate_alone if element in kept else integrate_compliances
            states += start(variables, element)
    taken: set[str] = set()
    for group, kept in pairs:
        _refuse_without_energy(variables, group)
        if kept:
            states += _keep_momenta(variables, group, kept)
        else:
            states += _merge_inertia_group(variables, group, taken)
    return states


def _keep_momenta(
    variables: Variables, group: Group, kept: Sequence[StorageElement]
) -> list[IntegratedState]:
    """Let the elements that keep no momenta react; the states of their charges."""
    others = [element for element in group.elements if element not in kept]
    for element in others:
        _define_momenta(variables, element)
    variables.balances.reacting.update(port.index for port in group.ports)
    return [state for element in others for state in _charges(variables, element)]


def _merge_inertia_group(
    variables: Variables, group: Group, taken: set[str]
) -> list[IntegratedState]:
    """The states of a group. `taken` collects their names.

    The flows of a group whose laws are not linear, or whose eliminated flows fail the check, are
    unknowns of `pi = N' p`.
    """
    dag, causal = variables.dag, variables.causal
    merged = {k: variables.new_state(Kind.MOMENTUM) for k in group.flows}
    for element in group.elements:
        _define_momenta(variables, element)
    _define_flows(variables, group, merged)
    states = [state for element in group.elements for state in _charges(variables, element)]
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
                dag.zero,  # `joint_start` gives the value
                None,
                held[k],
                flow=k,
            )
        )
    return states


def _charges(variables: Variables, element: StorageElement) -> list[IntegratedState]:
    """The charges beside the momenta of an IC."""
    return [
        charge_state(variables, element, position)
        for position, port in enumerate(element.ports)
        if port.charge is not None and port.port.role is Role.INERTIA
    ]


def _refuse_without_energy(variables: Variables, group: Group) -> None:
    """Refuse an inertia without a kinetic energy (not symmetric), which cannot be merged."""
    for element in group.elements:
        law = element.storage.law
        if isinstance(law, LinearLaw) and not is_symmetric(variables, law.matrix):
            why = f"the inertia of `{element.storage.name}` is not symmetric"
            raise cannot_merge(group.elements[0], group.names(), why)


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


def _define_flows(variables: Variables, group: Group, merged: dict[int, Node]) -> None:
    """The independent flows: `u = (N' M N)^-1 (pi - N' M N_s s)`, or by rows `pi = N' p`."""
    dag = variables.dag
    energy = kinetic_energy(variables, group.elements, group.flows)
    _require_moved(variables, group, energy)
    energy.form.vector.update(zip(energy.free, merged.values(), strict=True))

    def row_of(place: int) -> Node:
        k = group.flows[place]
        moved = dag.sum(dag.mul(p.flow[k], p.state) for p in group.ports if k in p.flow)
        return dag.sub(merged[k], moved)

    of_class = variables.symbols.of_class
    unknowns = [of_class(number) for number in energy.free]
    linear = energy if group.is_linear else None
    try:
        pivots = determine(variables, unknowns, linear, of_class, row_of)
    except SingularFormError:
        why = "their common inertia is singular"
        raise cannot_merge(group.elements[0], group.names(), why) from None
    if pivots:
        watch_pivots(variables, group, pivots)
        variables.kinetic.append((energy, merged))


def _require_moved(variables: Variables, group: Group, energy: ConstrainedEnergy) -> None:
    """Refuse a group with a motion that moves none of the reduced mass, where it is known.

    With linear laws, one that moves nearly none is refused as well.
    """
    mass = ReducedMatrix(variables, energy)
    if not mass.is_known:
        return
    masses = [row[i] for i, row in enumerate(mass.entries)]
    least = _LEAST_EIGENVALUE if group.is_linear else _ROUNDING
    none = _NO_MASS_IN_A_CHAIN if may_be_opened(variables.causal) else _NO_MASS
    motion = soft_motion(mass.entries, masses, least, none * max(masses, default=0.0))
    if motion is not None:
        raise _moving_without_inertia(variables, group, mass, motion)


def _moving_without_inertia(
    variables: Variables, group: Group, mass: ReducedMatrix, motion: Sequence[float]
) -> BgError:
    """The error that names the elements that take part in a motion; if none does, its bonds."""
    causal = variables.causal
    speeds = [
        max(
            abs(sum(x * motion[i] for i, x in mass.rows[causal.class_of[p.port.bond]].items()))
            for p in inertias_of(element)
        )
        for element in group.elements
    ]
    if max(speeds) < _STILL * max(map(abs, motion)):
        classes = [
            causal.classes[causal.basis[k].bond_class]
            for k, speed in zip(group.flows, motion, strict=True)
            if abs(speed) > _TAKING_PART * max(map(abs, motion))
        ]
        bonds = [causal.graph.bonds[members.bonds[0]] for members in classes]
        names = [bond.name for bond in bonds]
        return BgError([storage_messages.motion_without_inertia(bonds[0].span, names)])
    moving = [
        element.storage
        for element, speed in zip(group.elements, speeds, strict=True)
        if speed > _TAKING_PART * max(speeds)
    ]
    names = [storage.name for storage in moving]
    return BgError([storage_messages.motion_without_inertia(moving[0].span, names)])


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
