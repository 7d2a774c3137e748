"""The momenta that a group keeps whose moduli read flows of the group itself.

With flows `N(u) u` the common momentum `N(u)' p` has folds where its slope by u is singular, which
holds `(dN/du)' p` beside the mass. The flows go on there. Inertias on the independent flows
themselves therefore keep their own momenta. The others react with the efforts
`d/dt (M N(u) u)`, which is an algebraic loop in the rates of u. Its matrix `N' M d(N u)/du` is
singular only where the equations of motion are. A source that sets part of the flows and jumps, or
has no rate, moves the common momentum alone, and so does a modulus: such groups keep it.
"""

from __future__ import annotations

from bgc.algebra.dag import Kind, Op
from bgc.equations.inertias.groups import Group, inertias_of
from bgc.equations.storage.kinds import StorageElement
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import BasisKind
from bgc.ir.graph import Node


def elements_on_flows(variables: Variables, group: Group) -> list[StorageElement]:
    """The elements that keep their momenta: together one inertia on each independent flow.

    Empty where no modulus reads a flow of the group, where a flow has no such element, and where a
    modulus may jump, or a source that sets flows of the group.
    """
    if not _reads_own_flows(variables, group) or _is_moved_by_jumps(variables, group):
        return []
    causal = variables.causal
    left = {causal.basis[k].bond_class for k in group.flows}
    found = []
    for element in group.elements:
        classes = [causal.class_of[port.port.bond] for port in inertias_of(element)]
        if left.issuperset(classes) and len({*classes}) == len(classes):
            found.append(element)
            left.difference_update(classes)
    return [] if left else found


def _reads_own_flows(variables: Variables, group: Group) -> bool:
    """Return whether a modulus before an inertia reads what the flows of the group determine."""
    dag, own = variables.dag, set(group.flows)
    entries = {node for port in group.ports for node in port.flow.values()}
    read = dag.symbols_in(entries, Kind.FLOW, Kind.EFFORT, Kind.MOMENTUM, Kind.DISPLACEMENT)
    momenta = {port.state: port.flow for port in group.ports}
    return any(not own.isdisjoint(_flows_behind(variables, s, momenta)) for s in read)


def _is_moved_by_jumps(variables: Variables, group: Group) -> bool:
    """Return whether moduli, or sources that set flows of the group, are piecewise or inputs."""
    dag, basis = variables.dag, variables.causal.basis
    rows = [entry for port in group.ports for entry in port.flow.items()]
    sources = {k for k, _ in rows if basis[k].kind is BasisKind.FLOW_SOURCE}
    nodes = dag.reachable([*map(variables.independent, sources), *(node for _, node in rows)])
    return any(Op(dag.op[node]).row.jump is not None for node in nodes) or bool(
        dag.symbols_in(nodes, Kind.INPUT)
    )


def _flows_behind(
    variables: Variables, symbol: Node, momenta: dict[Node, dict[int, Node]]
) -> dict[int, Node]:
    """The row of N of a bond's flow or of a momentum; empty for other symbols."""
    leaf, causal = variables.dag.leaf(symbol), variables.causal
    if leaf.kind not in {Kind.FLOW, Kind.EFFORT}:
        return momenta.get(symbol, {})
    if symbol != variables.symbols.through(leaf.index):
        return {}
    return dict(causal.flows[causal.class_of[leaf.index]])
