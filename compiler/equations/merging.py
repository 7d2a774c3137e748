"""Dependent storage merged: one state for what rigid connections make one.

Inertias on flows `N u` are merged into the generalised momentum `pi = N' p` (Karnopp's IC
field): `u` follows from `pi` by the reduced mass `N' M N`, and

    pi' = -(the other efforts on u) + (dN/dt)' p,

in which no rate of an effort or of a source occurs. Compliances that share what only
compliances determine keep the differences `Q = q - B q_d` to designated ones `q_d`, which
follow from the balance of efforts. Both systems are symmetric positive definite; with a law that
is not linear they become equations to be solved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bgc.algebra.dag import Kind, Level
from bgc.algebra.solving import SingularSystemError, solve_definite
from bgc.causality.causal import BasisKind, Role
from bgc.causality.regions import Forest
from bgc.equations.integrating import charge_state
from bgc.equations.merged_initial import initial_differences, initial_momenta
from bgc.equations.storage import IntegratedState, StorageElement, StoragePort, state_unit
from bgc.equations.variables import Explicit, Unknown, Variables
from bgc.grammar.catalogue import causality as catalogue
from bgc.grammar.diagnostics import BgError
from bgc.graph import Node, Source


@dataclass(frozen=True, slots=True)
class Group:
    """Elements whose storage depends on each other, and the independent flows they share."""

    elements: tuple[StorageElement, ...]
    flows: tuple[int, ...]  # indices in the basis, of the group's own kind

    @property
    def ports(self) -> list[StoragePort]:
        """The ports of all elements."""
        return [port for element in self.elements for port in element.ports]

    def names(self) -> list[str]:
        """The elements' names."""
        return [element.storage.name for element in self.elements]


def find_groups(
    variables: Variables, elements: Sequence[StorageElement], role: Role, kind: BasisKind
) -> list[Group]:
    """Elements with ports of a role, connected by the independent flows of a kind."""
    basis = variables.causal.basis
    chosen = [e for e in elements if any(p.port.role is role for p in e.ports)]
    shared = [
        sorted({k for port in e.ports for k in port.flow if basis[k].kind is kind}) for e in chosen
    ]
    forest = Forest(len(chosen) + len(basis))
    for index, flows in enumerate(shared):
        forest.join([index, *(len(chosen) + k for k in flows)])
    members: dict[int, list[int]] = {}
    for index in range(len(chosen)):
        members.setdefault(forest.find(index), []).append(index)
    return [
        Group(
            tuple(chosen[i] for i in indices),
            tuple(sorted({k for i in indices for k in shared[i]})),
        )
        for indices in members.values()
    ]


# --- inertias ---------------------------------------------------------------------------------


def merge_inertias(
    variables: Variables, elements: Sequence[StorageElement]
) -> list[IntegratedState]:
    """Define momenta and independent flows of dependent inertias; their states."""
    groups = find_groups(variables, elements, Role.INERTIA, BasisKind.INERTIA)
    return [state for group in groups for state in _merge_inertia_group(variables, group)]


def _merge_inertia_group(variables: Variables, group: Group) -> list[IntegratedState]:
    dag, causal = variables.dag, variables.causal
    if any(port.port.role is not Role.INERTIA for port in group.ports):
        raise _cannot_merge(group, "its energy mixes charges and momenta")
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
        raise _cannot_merge(group, "their common inertia is singular") from None
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


# --- compliances ------------------------------------------------------------------------------


def merge_compliances(
    variables: Variables, elements: Sequence[StorageElement]
) -> list[IntegratedState]:
    """Define charges and flows of dependent compliances; their states."""
    groups = find_groups(variables, elements, Role.COMPLIANCE, BasisKind.COMPLIANCE)
    return [state for group in groups for state in _merge_compliance_group(variables, group)]


def _merge_compliance_group(variables: Variables, group: Group) -> list[IntegratedState]:
    dag, causal = variables.dag, variables.causal
    if any(p.port.role is not Role.COMPLIANCE or p.charge is not None for p in group.ports):
        raise _cannot_merge(group, "its energy mixes charges and momenta")
    designated = _designate(variables, group)
    chosen = {port.index for port in designated.values()}
    kept = [port for port in group.ports if port.index not in chosen]
    merged = {port.index: variables.new_state(Kind.DISPLACEMENT) for port in kept}
    follow = {port.index: _follow(variables, port, designated) for port in group.ports}
    for port in group.ports:
        variables.set_answer(port.index, port.answer)
    for port in kept:
        parts = (dag.mul(b, designated[k].state) for k, b in follow[port.index].items())
        node = dag.add(merged[port.index], dag.sum(parts))
        variables.set_definition(port.state, Explicit(node), port.port.element)
    driven = {k: dag.div(_driving(variables, k), port.flow[k]) for k, port in designated.items()}
    _define_designated(variables, group, designated, merged, follow, driven)
    for k, port in designated.items():
        rate = variables.rate_of(port.state, port.port.element)
        others = dag.sum(
            dag.mul(entry, variables.independent(i))
            for i, entry in port.flow.items()
            if i not in designated
        )
        node = dag.div(dag.sub(rate, others), port.flow[k])
        variables.set_flow(causal.basis[k].bond_class, Explicit(node))
    start = initial_differences(variables, group.elements, designated, follow, driven)
    return [
        IntegratedState(
            merged[port.index],
            _kept_name(group, port, [designated[k] for k in follow[port.index]]),
            state_unit(variables, port.port, momentum=port.port.dual),
            "momentum" if port.port.dual else "displacement",
            _difference_rate(variables, port, designated, follow[port.index]),
            start[port.index],
            None,
        )
        for port in kept
    ]


def _designate(variables: Variables, group: Group) -> dict[int, StoragePort]:
    """For each flow that only compliances determine, a port whose charge is solved for."""
    designated: dict[int, StoragePort] = {}
    own = set(group.flows)
    for k in group.flows:
        for port in group.ports:
            if own & set(port.flow) == {k} and variables.may_divide(
                port.flow[k], f"the modulus that joins `{group.names()[0]}` must not be zero"
            ):
                designated[k] = port
                break
        else:
            raise _cannot_merge(group, "the modulus that joins them may vanish")
    return designated


def _follow(
    variables: Variables, port: StoragePort, designated: dict[int, StoragePort]
) -> dict[int, Node]:
    """How a charge follows the designated ones: flow -> entry of B."""
    dag = variables.dag
    return {
        k: dag.div(entry, designated[k].flow[k])
        for k, entry in port.flow.items()
        if k in designated
    }


def _define_designated(
    variables: Variables,
    group: Group,
    designated: dict[int, StoragePort],
    merged: dict[int, Node],
    follow: dict[int, dict[int, Node]],
    driven: dict[int, Node],
) -> None:
    """The designated charges from the balance of efforts on the flows of the group."""
    dag = variables.dag
    order = {k: i for i, k in enumerate(designated)}
    if any(element.law.response is None for element in group.elements):
        for k, port in designated.items():
            total = driven[k]
            for other in group.ports:
                if k in follow[other.index]:
                    term = dag.mul(follow[other.index][k], other.answer)
                    total = dag.add(total, term)
            variables.set_definition(port.state, Unknown(), port.port.element)
            variables.add_equation(total, port.state)
        return
    matrix: list[dict[int, Node]] = [{} for _ in order]
    right = [dag.neg(driven[k]) for k in designated]
    for element in group.elements:
        response = element.law.response
        assert response is not None
        for port, line in zip(element.ports, response, strict=True):
            effort: dict[int, Node] = {}
            rest = dag.zero
            for other, entry in zip(element.ports, line, strict=True):
                for k, b in follow[other.index].items():
                    effort[k] = dag.add(effort.get(k, dag.zero), dag.mul(entry, b))
                if other.index in merged:
                    rest = dag.add(rest, dag.mul(entry, merged[other.index]))
            for k, b in follow[port.index].items():
                i = order[k]
                for other_k, node in effort.items():
                    j = order[other_k]
                    matrix[i][j] = dag.add(matrix[i].get(j, dag.zero), dag.mul(b, node))
                right[i] = dag.sub(right[i], dag.mul(b, rest))
    try:
        (solution,) = solve_definite(dag, variables.causal.fingerprints, matrix, [right])
    except SingularSystemError:
        raise _cannot_merge(group, "their common stiffness is singular") from None
    for k, port in designated.items():
        variables.set_definition(port.state, Explicit(solution[order[k]]), port.port.element)


def _driving(variables: Variables, k: int) -> Node:
    """What sources give on a flow that only compliances determine."""
    dag, causal = variables.dag, variables.causal
    total = dag.zero
    for port in causal.ports:
        source = causal.graph.elements[port.element]
        if port.role is Role.EFFORT_SOURCE and isinstance(source, Source):
            entry = dict(causal.flows[causal.class_of[port.bond]]).get(k)
            if entry is not None:
                force = source.value
                if port.sign < 0:
                    force = dag.neg(force)
                total = dag.add(total, dag.mul(entry, force))
    return total


def _difference_rate(
    variables: Variables,
    port: StoragePort,
    designated: dict[int, StoragePort],
    follow: dict[int, Node],
) -> Node:
    """`Q' = (q - B q_d)'`, from which the flows of the group itself cancel."""
    dag = variables.dag
    entries = {k: entry for k, entry in port.flow.items() if k not in designated}
    rate = dag.zero
    for k, b in follow.items():
        for other, entry in designated[k].flow.items():
            if other not in designated:
                left = dag.sub(entries.get(other, dag.zero), dag.mul(b, entry))
                entries[other] = left
        if dag.level[b] > Level.PARAM:
            turning = variables.rate_of(b, port.port.element)
            rate = dag.sub(rate, dag.mul(turning, designated[k].state))
    for other, entry in entries.items():
        flow = variables.independent(other)
        rate = dag.add(rate, dag.mul(entry, flow))
    return rate


# --- names and errors -------------------------------------------------------------------------


def _merged_names(group: Group, merged: dict[int, Node], letter: str) -> dict[int, str]:
    """A name for each merged momentum: the elements on its flow."""
    names: dict[int, str] = {}
    for k in merged:
        on_flow = [e.storage.name for e in group.elements if any(k in p.flow for p in e.ports)]
        name = f"merged({_shortened(on_flow)}).{letter}"
        again = sum(1 for other in names.values() if other.split("#")[0] == name)
        names[k] = f"{name}#{again + 1}" if again else name
    return names


def _kept_name(group: Group, port: StoragePort, leaders: list[StoragePort]) -> str:
    """A name for a merged charge: its own element, then those it is measured against."""
    owner = {p.index: e.storage.name for e in group.elements for p in e.ports}
    names = list(dict.fromkeys(owner[p.index] for p in (port, *leaders)))
    suffix = f"[{port.port.position + 1}]" if port.port.position else ""
    return f"merged({_shortened(names)}).q{suffix}"


def _shortened(names: list[str]) -> str:
    shown = names if len(names) <= 3 else [*names[:2], f"{len(names) - 2} more"]
    return ", ".join(shown)


def _cannot_merge(group: Group, why: str) -> BgError:
    first = group.elements[0].storage
    others = group.names()[1:]
    return BgError([catalogue.dependent_storage(first.span, first.name, others, why)])
