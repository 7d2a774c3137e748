"""Inertias that depend on each other, found by the independent flows they share."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.disjoint_sets import groups_sharing
from bgc.equations.storage.kinds import StorageElement, StoragePort
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import BasisKind, Role
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Group:
    """Elements whose inertias depend on each other, and the independent flows they share."""

    elements: tuple[StorageElement, ...]
    flows: tuple[int, ...]  # indices in the basis, of kind inertia

    @property
    def ports(self) -> list[StoragePort]:
        """The inertias of all elements; an IC may have compliances beside them."""
        return [port for element in self.elements for port in inertias_of(element)]

    @property
    def is_linear(self) -> bool:
        """True if all momenta are linear in the flows."""
        return all(element.law.capacity is not None for element in self.elements)

    def names(self) -> list[str]:
        """The elements' names."""
        return [element.storage.name for element in self.elements]


def inertias_of(element: StorageElement) -> list[StoragePort]:
    """The ports that answer with the through variable."""
    return [port for port in element.ports if port.port.role is Role.INERTIA]


def find_groups(variables: Variables, elements: Sequence[StorageElement]) -> list[Group]:
    """Find groups of elements whose inertias are connected by shared independent flows."""
    basis = variables.causal.basis
    chosen = [element for element in elements if inertias_of(element)]
    shared = [
        sorted({k for p in inertias_of(e) for k in p.flow if basis[k].kind is BasisKind.INERTIA})
        for e in chosen
    ]
    return [
        Group(
            tuple(chosen[i] for i in indices),
            tuple(sorted({k for i in indices for k in shared[i]})),
        )
        for indices in groups_sharing(shared)
    ]
