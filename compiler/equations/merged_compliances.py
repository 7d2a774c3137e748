"""Dependent compliances merged: they keep the charges that their common flows do not change.

Compliances that share what only compliances determine keep the differences `Q = q - B q_d` to
designated charges `q_d`, which follow from the balance of efforts. The common stiffness is
symmetric positive definite; with a law that is not linear the balance is solved by iteration.
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Kind, Level
from bgc.algebra.solving import SingularSystemError, solve_definite
from bgc.causality.causal import BasisKind, Role
from bgc.equations.merged_groups import Group, cannot_merge, find_groups, shortened
from bgc.equations.merged_initial import initial_differences
from bgc.equations.storage import IntegratedState, StorageElement, StoragePort, state_unit
from bgc.equations.variables import Explicit, Unknown, Variables
from bgc.graph import Node, Source


def merge_compliances(
    variables: Variables, elements: Sequence[StorageElement]
) -> list[IntegratedState]:
    """Define charges and flows of dependent compliances; their states."""
    groups = find_groups(variables, elements, Role.COMPLIANCE, BasisKind.COMPLIANCE)
    return [state for group in groups for state in _merge_compliance_group(variables, group)]


def _merge_compliance_group(variables: Variables, group: Group) -> list[IntegratedState]:
    dag, causal = variables.dag, variables.causal
    if any(p.port.role is not Role.COMPLIANCE or p.charge is not None for p in group.ports):
        raise cannot_merge(group, "its energy mixes charges and momenta")
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
            raise cannot_merge(group, "the modulus that joins them may vanish")
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
        raise cannot_merge(group, "their common stiffness is singular") from None
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


def _kept_name(group: Group, port: StoragePort, leaders: list[StoragePort]) -> str:
    """A name for a merged charge: its own element, then those it is measured against."""
    owner = {p.index: e.storage.name for e in group.elements for p in e.ports}
    names = list(dict.fromkeys(owner[p.index] for p in (port, *leaders)))
    suffix = f"[{port.port.position + 1}]" if port.port.position else ""
    return f"merged({shortened(names)}).q{suffix}"
