"""Names of merged states, after the coordinate that each belongs to.

A merged momentum belongs to an independent flow, which the bonds of a 1-junction share: it is
called `shaft.p` where the flow is `shaft.f`. Without such a junction it is called after the port of
a transformer or gyrator (`gear.p1` beside `gear.f1`), or after its element (`rotor.merged.p`; what
the element itself stores is `rotor.p`). A merged charge is called after its 0-junction alike.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Bond, Gyrator, Junction, Transformer


def flow_coordinate(variables: Variables, number: int, taken: Collection[str]) -> str | None:
    """A free name for the momentum on a class of bonds (a charge where it is dual); None: none."""
    causal = variables.causal
    bonds = causal.classes[number].bonds
    letter, kind = ("q", "J0") if causal.dual[bonds[0]] else ("p", "J1")
    return next((n for n in _names(variables, bonds, kind, letter) if n not in taken), None)


def effort_coordinate(variables: Variables, bond: int, taken: Collection[str]) -> str | None:
    """A free name for the charge beside a bond (a momentum where it is dual); None: none."""
    letter, kind = ("p", "J1") if variables.causal.dual[bond] else ("q", "J0")
    return next((n for n in _names(variables, (bond,), kind, letter) if n not in taken), None)


def element_coordinate(name: str, taken: Collection[str]) -> str:
    """A free name after an element's own state: `rotor.merged.p` after `rotor.p`."""
    path, _, variable = name.rpartition(".")
    first = f"{path}.merged.{variable}"
    again = (f"{path}.merged{k}.{variable}" for k in range(2, len(taken) + 3))
    return next(n for n in (first, *again) if n not in taken)


def _names(variables: Variables, bonds: Collection[int], kind: str, letter: str) -> Iterator[str]:
    """Names after junctions of a kind on some bonds, outermost first, then after two-ports."""
    graph, index = variables.causal.graph, variables.index
    junctions: dict[str, Bond] = {}
    sides: dict[str, None] = {}
    for bond in bonds:
        for end in ((bond, 1), (bond, -1)):
            found = {index.junction_at[end]} if end in index.junction_at else set[int]()
            found |= {variables.causal.rows[r].element for r, _ in index.row_ends.get(end, ())}
            if end in index.port_at:
                found.add(variables.causal.ports[index.port_at[end]].element)
            for element in (graph.elements[k] for k in sorted(found)):
                if isinstance(element, Junction) and element.kind == kind:
                    junctions[element.name] = graph.bonds[bond]
                elif isinstance(element, Transformer | Gyrator):
                    sides |= dict.fromkeys(_ports_at(element, bond, letter))
    for name in sorted(junctions, key=lambda name: name.count(".")):
        yield _of_component(name, junctions[name], letter)
    yield from sides


def _ports_at(element: Transformer | Gyrator, bond: int, letter: str) -> Iterator[str]:
    for side, ports in (("1", element.ports1), ("2", element.ports2)):
        for k, port in enumerate(ports):
            if port.bond == bond:
                index = f"[{k + 1}]" if len(ports) > 1 else ""
                yield f"{element.name}.{letter}{side}{index}"


def _of_component(name: str, bond: Bond, letter: str) -> str:
    """`hub.p[3]` for component 3 of a wide junction, `shaft[3].p` for part 3 of an array."""
    index = f"[{bond.component}]"
    if bond.width > 1 and name.endswith(index):
        return f"{name.removesuffix(index)}.{letter}{index}"
    return f"{name}.{letter}"
