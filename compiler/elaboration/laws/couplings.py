"""Read sampled ports: the energies and numbers of their couplings."""

from __future__ import annotations

from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.tree import Instance, PortEntry, Quantity
from bgc.elaboration.instances.world import World
from bgc.ir.graph import Node, SampledPort


def read_ports(world: World, wiring: Wiring) -> tuple[SampledPort, ...]:
    """Read the couplings of all sampled ports, in source order."""
    found = []
    for port in wiring.ports:
        if port.coupling is not None:
            with world.report.collecting(note(port.env)):
                found.append(_read_port(world, port, port.coupling))
    return tuple(found)


def _read_port(world: World, port: PortEntry, coupling: Instance) -> SampledPort:
    def nodes(name: str) -> tuple[Node, ...]:
        member = coupling.members[name]
        assert isinstance(member, Quantity)
        return world.quantities.value(member, port.declaration.name_span).nodes

    def book(name: str) -> int:
        symbol = world.dag.symbol_of(nodes(name)[0])
        assert symbol is not None
        return symbol.index

    return SampledPort(
        name=port.path,
        width=len(nodes("effort")),
        balance=nodes("balance")[0],
        coupling_energies=(book("supplied"), book("lost"), book("created")),
        stiffness=nodes("stiffness")[0],
        damping=nodes("damping")[0],
        mass=nodes("mass")[0],
        resolution=nodes("resolution")[0],
        lag=nodes("lag")[0],
        period=nodes("period")[0],
        span=port.declaration.name_span,
    )
