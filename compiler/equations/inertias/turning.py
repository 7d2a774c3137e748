"""The forces of moduli that vary, behind which there are merged inertias.

A varying modulus c has behind it the momentum P of all inertias beyond; it exerts the force `-c' P`
(c' the rate of c) on the class before it. The rows of the elimination propagate these forces like
those of elements.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Level
from bgc.equations.inertias.groups import inertias_of
from bgc.equations.storage.constrained_energy import at_random
from bgc.equations.storage.kinds import StorageElement
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node

_TOLERANCE = 1e-6  # of all powers; far above rounding, far below the effect of a wrong sign


def turning_forces(variables: Variables, elements: Sequence[StorageElement]) -> dict[int, Node]:
    """`N' bias - (dN/dt)' p` of merged inertias, as forces on the classes where they arise."""
    dag, causal = variables.dag, variables.causal
    momenta: dict[int, Node] = {}
    forces: dict[int, Node] = {}
    rates: dict[tuple[int, int], Node] = {}  # by the classes behind a modulus and before it

    def collect(totals: dict[int, Node], number: int, node: Node) -> None:
        totals[number] = dag.add(totals.get(number, dag.zero), node)

    for element in elements:
        for port in inertias_of(element):
            number, sign = causal.class_of[port.port.bond], port.port.through_sign
            collect(momenta, number, variables.symbols.turned(port.state, sign))
            collect(forces, number, variables.symbols.turned(port.bias, sign))
    for step, definition in zip(causal.steps, variables.flow_definitions.values(), strict=True):
        behind = momenta.get(definition.variable, dag.zero)
        if behind == dag.zero:
            continue
        for number, modulus in definition.row.items():
            collect(momenta, number, dag.mul(modulus, behind))
            if dag.level[modulus] > Level.PARAM:
                turning = variables.rate_of(modulus, causal.rows[step.row].element)
                rates[definition.variable, number] = turning
                collect(forces, number, dag.neg(dag.mul(turning, behind)))
    _assert_powerless(variables, elements, forces, rates)
    return forces


def _assert_powerless(
    variables: Variables,
    elements: Sequence[StorageElement],
    forces: Mapping[int, Node],
    rates: Mapping[tuple[int, int], Node],
) -> None:
    """The forces of turning moduli take the power that turning moduli give the flows.

    This holds for all momenta, independent flows, moduli and rates of moduli, so that all of them
    are random numbers; a failure is a bug in bgc.
    """
    causal, numbers = variables.causal, at_random(variables)
    flows: dict[int, float] = {}
    rises: dict[int, float] = {}  # what the rates of moduli add to the rates of flows
    for k, independent in enumerate(causal.basis):
        flows[independent.bond_class] = random.Random(f"flow {k}").uniform(0.3, 1)
        rises[independent.bond_class] = 0.0
    for definition in reversed(variables.flow_definitions.values()):
        behind, flow, rise = definition.variable, 0.0, 0.0
        for number, modulus in definition.row.items():
            c = numbers.value(modulus)
            flow += c * flows[number]
            rise += c * rises[number]
            if (behind, number) in rates:
                rise += numbers.value(rates[behind, number]) * flows[number]
        flows[behind], rises[behind] = flow, rise
    powers = [numbers.value(force) * flows[number] for number, force in forces.items()]
    for element in elements:
        for port in inertias_of(element):
            number, sign = causal.class_of[port.port.bond], port.port.through_sign
            momentum, bias = numbers.values([port.state, port.bias])
            powers += [sign * momentum * rises[number], -sign * bias * flows[number]]
    defect, size = abs(sum(powers)), sum(map(abs, powers))
    assert not defect > _TOLERANCE * size, f"turning moduli give the power {defect / size:.1e}"
