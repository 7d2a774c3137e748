"""The kinds of storage: independent storage is integrated, dependent storage is merged.

A compliance whose flow the rest of the graph determines keeps its own charge as a state; an inertia
alone on an independent flow keeps its own momentum. All others are merged
(`inertias/merged_inertias.py`, `motions/merged_motions.py`).
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.equations.storage.symmetry import even_matrix
from bgc.equations.variables.definitions import Variables
from bgc.equations.variables.law_nodes import StorageLaw, storage_law
from bgc.ir.causal import BasisKind, CausalGraph, ElementPort, Role
from bgc.ir.graph import Node, Storage
from bgc.record_class import dataclass
from bgc.values.units import parse_unit


@dataclass(frozen=True, slots=True)
class IntegratedState:
    """A storage state of the program: its raw symbol, its rate and its name.

    `port` is the element port it belongs to, None for a merged state; `stores` names the elements
    whose momenta or charges it holds. `flow` is the independent flow of a merged momentum.
    """

    symbol: Node
    name: str
    unit: str
    kind: str  # `momentum` or `displacement`
    derivative: Node
    initial: Node
    port: int | None
    stores: tuple[str, ...]
    flow: int | None = None


@dataclass(frozen=True, slots=True)
class StoragePort:
    """A port of a storage element with its part of the law.

    `flow` is its row of N in the element's own sense: independent flow -> entry.
    """

    index: int  # of CausalGraph.ports
    port: ElementPort
    state: Node
    answer: Node
    bias: Node
    charge: Node | None
    flow: dict[int, Node]

    @property
    def has_momentum(self) -> bool:
        """Return whether it answers with a flow to its momentum, rather than with an effort."""
        return _has_momentum(self.port)


@dataclass(frozen=True, slots=True)
class StorageElement:
    """A storage element with its ports and law."""

    storage: Storage
    law: StorageLaw
    ports: tuple[StoragePort, ...]


def storage_elements(causal: CausalGraph, variables: Variables) -> list[StorageElement]:
    """All storage elements with their laws; refuses laws that cannot be used."""
    dag = causal.graph.dag
    found = []
    for index, element in enumerate(causal.graph.elements):
        if isinstance(element, Storage):
            members = variables.index.ports_of_element[index]
            ports = [causal.ports[k] for k in members]
            inertial = [p.role is Role.INERTIA for p in ports]
            momenta = [_has_momentum(p) for p in ports]
            law = storage_law(dag, element, momenta, inertial, even_matrix(variables, element))
            for symbol in (*law.states, *law.charges):
                if symbol is not None:
                    variables.places.note(symbol, index)
            found.append(
                StorageElement(
                    element,
                    law,
                    tuple(
                        StoragePort(
                            k,
                            port,
                            law.states[position],
                            law.answers[position],
                            law.bias[position],
                            law.charges[position],
                            own_flow(causal, port),
                        )
                        for position, (k, port) in enumerate(zip(members, ports, strict=True))
                    ),
                )
            )
    return found


def _has_momentum(port: ElementPort) -> bool:
    return (port.role is Role.INERTIA) != port.dual


def own_flow(causal: CausalGraph, port: ElementPort) -> dict[int, Node]:
    """A port's row of N in the element's own sense: independent flow -> entry."""
    row = dict(causal.flows[causal.class_of[port.bond]])
    if port.through_sign < 0:
        return {k: causal.graph.dag.neg(entry) for k, entry in row.items()}
    return row


def columns_of(elements: Sequence[StorageElement], role: Role) -> dict[int, list[StoragePort]]:
    """The ports of a role that take part in each independent flow."""
    columns: dict[int, list[StoragePort]] = {}
    for element in elements:
        for port in element.ports:
            if port.port.role is role:
                for k in port.flow:
                    columns.setdefault(k, []).append(port)
    return columns


def is_independent(
    causal: CausalGraph, element: StorageElement, columns: dict[int, list[StoragePort]]
) -> bool:
    """Return whether each inertia of an element has a state and an independent flow of its own.

    A compliance always can at first; storage that free motions join is merged later.
    """
    for port in element.ports:
        if port.port.role is Role.INERTIA:
            kinds = {causal.basis[k].kind for k in port.flow}
            number = causal.class_of[port.port.bond]
            own = [k for k in port.flow if causal.basis[k].bond_class == number]
            if not own or kinds != {BasisKind.INERTIA} or columns[own[0]] != [port]:
                return False
    return True


def state_name(storage: Storage, letter: str, position: int) -> str:
    """`coil.p`, or `spring.q[3]` of a wide element."""
    suffix = f"[{position + 1}]" if len(storage.ports) > 1 else ""
    return f"{storage.name}.{letter}{suffix}"


def state_unit(variables: Variables, port: ElementPort, *, momentum: bool) -> str:
    """The unit of a port's momentum or charge: that of its effort or flow, times a second."""
    bond = variables.causal.graph.bonds[port.bond]
    rate = bond.effort_unit if momentum else bond.flow_unit
    unit = parse_unit(f"{rate}*s") if rate else None
    return unit.symbol if unit else ""
