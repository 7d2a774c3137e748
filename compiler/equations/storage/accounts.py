"""The energy accounts: energy stored, power supplied by sources, power dissipated by resistors.

Only bonds whose effort times flow is a power count. Gyrators, junctions and transformers are
power-continuous and have no account.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.polynomials import antiderivative
from bgc.equations.storage.kinds import IntegratedState, StorageElement
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import EnergyLaw, ExplicitLaw, LinearLaw, Matrix, Node, Port, Resistor, Source
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Accounts:
    """Raw nodes of the accounts, and states that integrate what has no closed form."""

    stored: Node
    supplied: Node
    dissipated: Node
    states: list[IntegratedState]

    @property
    def nodes(self) -> tuple[Node, Node, Node]:
        """The three accounts in order."""
        return self.stored, self.supplied, self.dissipated


def energy_accounts(variables: Variables, elements: Sequence[StorageElement]) -> Accounts:
    """Derive the accounts that the scene needs; the others are zero.

    A source of value zero supplies nothing, so its reaction is not computed.
    """
    graph = variables.causal.graph
    needed = graph.scene.needed_accounts(bool(graph.jumps))
    zero, supplied, dissipated = variables.dag.zero, *_powers(variables.causal)
    stored, states = _all_stored(variables, elements) if "stored" in needed else (zero, [])
    return Accounts(
        stored,
        supplied if "supplied" in needed else zero,
        dissipated if "dissipated" in needed else zero,
        states,
    )


def _all_stored(
    variables: Variables, elements: Sequence[StorageElement]
) -> tuple[Node, list[IntegratedState]]:
    """The energy of all storage; laws without a closed form get a state that integrates it."""
    causal, dag = variables.causal, variables.dag
    stored = dag.zero
    states: list[IntegratedState] = []
    for element in elements:
        ports = element.storage.ports
        if not all(causal.graph.bonds[port.bond].power for port in ports):
            continue
        energy = _stored(variables, element)
        if energy is None:
            energy = variables.new_state(Kind.DISPLACEMENT)
            power = dag.sum(_power(dag, port) for port in ports)
            name = f"{element.storage.name}.energy"
            states.append(IntegratedState(energy, name, "J", "declared", power, dag.zero, None, ()))
        stored = dag.add(stored, energy)
    for coupling in causal.graph.ports:
        stored = dag.add(stored, coupling.balance)
    return stored, states


def _powers(causal: CausalGraph) -> tuple[Node, Node]:
    dag = causal.graph.dag
    supplied = dissipated = dag.zero
    couplings = {f"{port.name}.source" for port in causal.graph.ports}
    for element in causal.graph.elements:
        match element:
            case Source() if element.name.partition("[")[0] in couplings:
                pass  # its work is in the balance of the port
            case Source() if element.value != dag.zero:
                if causal.graph.bonds[element.port.bond].power:
                    supplied = dag.sub(supplied, _power(dag, element.port))
            case Resistor():
                for port in element.ports:
                    if causal.graph.bonds[port.bond].power:
                        dissipated = dag.add(dissipated, _power(dag, port))
            case _:
                pass
    return supplied, dissipated


def _power(dag: Dag, port: Port) -> Node:
    """Power into an element."""
    power = dag.mul(dag.symbol(Kind.EFFORT, port.bond), dag.symbol(Kind.FLOW, port.bond))
    return power if port.sign > 0 else dag.neg(power)


def _stored(variables: Variables, element: StorageElement) -> Node | None:
    """The energy as a function of the element's states; None without a closed form."""
    dag = variables.dag
    half = dag.const(Fraction(1, 2))
    match element.storage.law:
        case EnergyLaw(energy=energy):
            return energy
        case ExplicitLaw(nodes=(node,)):
            return antiderivative(dag, node, element.law.states[0])
        case ExplicitLaw():
            return None
        case LinearLaw(matrix=matrix):
            if not is_symmetric(variables, matrix):
                return None
            return dag.mul(half, dag.dot(element.law.states, element.law.answers))


def is_symmetric(variables: Variables, matrix: Matrix) -> bool:
    """Return whether a law derives from an energy: proven, or true at the parameters' defaults."""
    for i, row in enumerate(matrix):
        for j in range(i):
            pair = (row[j], matrix[j][i])
            if variables.causal.fingerprints.equal(*pair):
                continue
            x, y = (variables.default(node) for node in pair)
            if not math.isclose(x, y, rel_tol=1e-12):
                return False
    return True
