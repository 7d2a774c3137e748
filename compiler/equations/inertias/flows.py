"""The flows of merged inertias in factored form, one elimination step at a time.

The rows of the elimination are used as they are: `N` is never multiplied out. Flows are propagated
forward through them, momenta and efforts backward. Where a modulus varies, the momentum behind it
exerts a force on the flow before it (`turning.py`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import product

from bgc.algebra.linalg import identity
from bgc.algebra.quadratic import ConstrainedEnergy, Definition, Form, Row
from bgc.equations.inertias.groups import Group, inertias_of
from bgc.equations.inertias.rank import has_constant_rank
from bgc.equations.storage.kinds import StorageElement
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import BasisKind
from bgc.ir.graph import Node
from bgc.ir.program import Divisor

_NAMED = 3  # elements at most


def kinetic_energy(
    variables: Variables, elements: Sequence[StorageElement], flows: Sequence[int]
) -> ConstrainedEnergy:
    """`1/2 f' M f` over the classes of the elements' ports; `flows` of the basis are free.

    M is the identity for a law that is not linear: what such an inertia does not store is moved by
    no flow.
    """
    dag, causal = variables.dag, variables.causal
    matrix: dict[int, Row] = {}
    for element in elements:
        capacity = element.law.capacity or identity(dag, len(element.ports))
        for port, other in product(inertias_of(element), repeat=2):
            i, j = sorted((port.port.position, other.port.position))
            entry = capacity[i][j]
            if port.port.through_sign != other.port.through_sign:
                entry = dag.neg(entry)
            row = matrix.setdefault(causal.class_of[port.port.bond], {})
            column = causal.class_of[other.port.bond]
            row[column] = dag.add(row.get(column, dag.zero), entry)
    kept = {k: {j: x for j, x in row.items() if x != dag.zero} for k, row in matrix.items()}
    return ConstrainedEnergy(
        Form(kept, {}),
        _definitions_of(variables, elements, flows),
        [causal.basis[k].bond_class for k in flows],
    )


def watch_pivots(variables: Variables, group: Group, pivots: Sequence[Node]) -> None:
    """Note the pivots of a reduced mass that may vanish at a state."""
    doubtful = [node for node in pivots if variables.may_vanish(node)]
    if doubtful and not has_constant_rank(variables, group):
        names = " and ".join(f"`{name}`" for name in group.names()[:_NAMED])
        more = f" and {len(group.elements) - _NAMED} more" if len(group.elements) > _NAMED else ""
        what = f"the common inertia of {names}{more}"
        if len(group.elements) == 1:
            what = f"the inertia of {names}, seen from the flow that moves it,"
        span = group.elements[0].storage.span
        variables.raw_divisors += [Divisor(node, what, span) for node in doubtful]


def _definitions_of(
    variables: Variables, elements: Sequence[StorageElement], flows: Collection[int]
) -> list[Definition]:
    """The definitions behind the flows of a group's ports; `flows` are its own in the basis.

    Where these seem to hold flows that in truth cancel, the rows of `N` itself.
    """
    causal, index = variables.causal, variables.index
    basis = causal.basis
    definitions = variables.flow_definitions
    classes = dict.fromkeys(
        causal.class_of[port.port.bond] for element in elements for port in inertias_of(element)
    )
    reached = set(classes)
    stack = list(classes)
    while stack:
        definition = definitions.get(stack.pop())
        new = set(definition.row) - reached if definition is not None else set()
        reached |= new
        stack.extend(new)
    others = reached - {basis[k].bond_class for k in flows}
    source = BasisKind.FLOW_SOURCE
    if all(index.kind_of.get(number, source) is source for number in others):
        defined = sorted(reached & definitions.keys(), key=index.step_of.__getitem__)
        return [definitions[number] for number in defined]
    return [
        Definition(number, {basis[k].bond_class: entry for k, entry in causal.flows[number]})
        for number in classes
        if number in definitions
    ]


def momenta_in(
    variables: Variables, energy: ConstrainedEnergy, flows: Mapping[int, Node]
) -> dict[int, Node]:
    """`N' M (N u + N_s s)` of inertias whose laws are linear, by their energy, u being given.

    Independent flow -> its flow gives independent flow -> its momentum.
    """
    dag, basis = variables.dag, variables.causal.basis
    values = {basis[k].bond_class: node for k, node in flows.items()}

    def value(number: int) -> Node:
        return values[number] if number in values else variables.source_of(number).value

    for definition in reversed(energy.definitions):
        terms = definition.row.items()
        values[definition.variable] = dag.sum(dag.mul(c, value(k)) for k, c in terms)
    momenta: dict[int, Node] = {}
    for number, row in energy.form.matrix.items():
        momenta[number] = dag.sum(dag.mul(m, value(k)) for k, m in row.items())
    for definition in energy.definitions:
        behind = momenta.get(definition.variable, dag.zero)
        for number, c in definition.row.items():
            momenta[number] = dag.add(momenta.get(number, dag.zero), dag.mul(c, behind))
    return {k: momenta.get(basis[k].bond_class, dag.zero) for k in flows}
