"""The equations of the independent flows of merged inertias, kept beside their solution.

f needs the flows u themselves, so they are solved for in the DAG, in O(n) operations for a chain
of n bodies. Their derivatives by the states are dense, O(n^2) and more. The Jacobian therefore may
keep u as unknowns of its linear systems, by the rows 0 = pi - N' M (N u + N_s s)
(`emission/implicit_speeds.py`).
"""

from __future__ import annotations

from dataclasses import replace

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.fingerprint import Fingerprints
from bgc.equations.inertias.flows import momenta_in
from bgc.equations.loops.substitution import Resolver
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node
from bgc.ir.program import Program, SpeedEquations

_FEWEST_FLOWS = 3  # flows of a group: with fewer there is nothing to gain
_KNOWN = frozenset({Kind.PARAM, Kind.TIME, Kind.INPUT, Kind.STATE, Kind.SPEED})


def with_speeds(program: Program, variables: Variables, resolver: Resolver) -> Program:
    """Add the equations of the merged flows to a program whose derivation is complete.

    `Variables.kinetic` has the energies of merged inertias and the momenta on their flows. The
    program's other nodes keep their numbers, and its DAG gets no others. Closed chains have none:
    their multipliers are solved for by the flows, too. Nor have equations that are not proven to
    hold.
    """
    groups = [group for group in variables.kinetic if len(group[1]) >= _FEWEST_FLOWS]
    if program.closures is not None or not groups:
        return program
    dag = variables.dag
    program = replace(program, dag=dag.copy())
    values: list[Node] = []
    residuals: list[Node] = []
    for energy, momenta in groups:
        speeds = {k: dag.symbol(Kind.SPEED, len(values) + i) for i, k in enumerate(momenta)}
        gathered = momenta_in(variables, energy, speeds)
        for number, (k, momentum) in zip(energy.free, momenta.items(), strict=True):
            values.append(resolver.resolve(variables.symbols.of_class(number)))
            residuals.append(resolver.resolve(dag.sub(momentum, gathered[k])))
    own = Dag()
    kept = SpeedEquations(own, tuple(own.adopted(dag, values)), tuple(own.adopted(dag, residuals)))
    return replace(program, speeds=kept if _hold(kept) else None)


def _hold(speeds: SpeedEquations) -> bool:
    """Return whether the values are proven to satisfy the equations."""
    dag = speeds.dag.copy()
    symbols = dag.symbols_in((*speeds.values, *speeds.residuals)).values()
    if any(symbol.kind not in _KNOWN for symbol in symbols):
        return False
    given = {dag.symbol(Kind.SPEED, k): node for k, node in enumerate(speeds.values)}
    fingerprints = Fingerprints(dag)
    return all(fingerprints.is_zero(x) for x in dag.substitute(speeds.residuals, given))
