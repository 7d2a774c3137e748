"""The equations of the independent flows of merged inertias, kept beside their solution.

f needs the flows u themselves, so they are solved for in the DAG, in O(n) operations for a chain
of n bodies. Their derivatives by the states are dense, O(n^2) and more. The Jacobian therefore may
keep u as unknowns of its linear systems, by the rows 0 = pi - N' M (N u + N_s s)
(`emission/implicit_speeds.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.fingerprint import Fingerprints
from bgc.equations.inertias.flows import momenta_of
from bgc.equations.inertias.groups import find_groups
from bgc.equations.loops.substitution import Resolver
from bgc.equations.storage.kinds import (
    IntegratedState,
    StorageElement,
    columns_of,
    is_independent,
)
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import Role
from bgc.ir.graph import Node
from bgc.ir.program import Program, SpeedEquations

_FEWEST_FLOWS = 3  # flows of a group: with fewer there is nothing to gain
_KNOWN = frozenset({Kind.PARAM, Kind.TIME, Kind.INPUT, Kind.STATE, Kind.SPEED})


def with_speeds(
    program: Program,
    variables: Variables,
    resolver: Resolver,
    elements: Sequence[StorageElement],
    stored: Sequence[IntegratedState],
) -> Program:
    """Add the equations of the merged flows to a program whose derivation is complete.

    Its other nodes keep their numbers, and its DAG gets no others. Closed chains have none: their
    multipliers are solved for by the flows, too. Nor have equations that are not proven to hold.
    """
    if program.closures is not None:
        return program
    momenta = {state.flow: state.symbol for state in stored if state.flow is not None}
    columns = columns_of(elements, Role.INERTIA)
    merged = [e for e in elements if not is_independent(variables.causal, e, columns)]
    groups = [
        group
        for group in find_groups(variables, merged)
        if group.is_linear
        and len(group.flows) >= _FEWEST_FLOWS
        and momenta.keys() >= set(group.flows)
    ]
    if not groups:
        return program
    dag = variables.dag
    program = replace(program, dag=dag.copy())
    values: list[Node] = []
    residuals: list[Node] = []
    for group in groups:
        speeds = {k: dag.symbol(Kind.SPEED, len(values) + i) for i, k in enumerate(group.flows)}
        gathered = momenta_of(variables, group.elements, speeds)
        for k in group.flows:
            number = variables.causal.basis[k].bond_class
            values.append(resolver.resolve(variables.symbols.of_class(number)))
            residuals.append(resolver.resolve(dag.sub(momenta[k], gathered[k])))
    speeds_of = _alone(dag, values, residuals)
    return replace(program, speeds=speeds_of if _hold(speeds_of) else None)


def _alone(dag: Dag, values: Sequence[Node], residuals: Sequence[Node]) -> SpeedEquations:
    """The equations on a DAG of their own."""
    own = Dag()
    new: dict[Node, Node] = {}
    for node in dag.reachable((*values, *residuals)):
        new[node] = own.adopt(dag, node, tuple(new[x] for x in dag.operands(node)))
    return SpeedEquations(
        own, tuple(new[node] for node in values), tuple(new[node] for node in residuals)
    )


def _hold(speeds: SpeedEquations) -> bool:
    """Return whether the values are proven to satisfy the equations."""
    dag = speeds.dag.copy()
    symbols = (dag.symbol_of(n) for n in dag.reachable((*speeds.values, *speeds.residuals)))
    if any(symbol is not None and symbol.kind not in _KNOWN for symbol in symbols):
        return False
    given = {dag.symbol(Kind.SPEED, k): node for k, node in enumerate(speeds.values)}
    fingerprints = Fingerprints(dag)
    return all(fingerprints.is_zero(x) for x in dag.substitute(speeds.residuals, given))
