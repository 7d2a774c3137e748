"""Storage elements that depend on each other, found by the independent flows they share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bgc.causality.causal import BasisKind, Role
from bgc.causality.regions import Forest
from bgc.equations.storage import StorageElement, StoragePort
from bgc.equations.variables import Variables
from bgc.grammar.catalogue import causality as catalogue
from bgc.grammar.diagnostics import BgError


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


def shortened(names: list[str]) -> str:
    """A few names as they are, of many the first two."""
    shown = names if len(names) <= 3 else [*names[:2], f"{len(names) - 2} more"]
    return ", ".join(shown)


def cannot_merge(group: Group, why: str) -> BgError:
    """The error that refuses a group, named after its first element."""
    first = group.elements[0].storage
    others = group.names()[1:]
    return BgError([catalogue.dependent_storage(first.span, first.name, others, why)])
