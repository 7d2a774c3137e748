"""The target `ssp`: a system of FMUs."""

from __future__ import annotations

from bgc.runtime.fmi.binaries import read_platforms
from bgc.runtime.fmi.ssp import first_part, prepare_system, read_part, read_wire, system_archive
from bgc.runtime.targets.target import Order, Product


def make(order: Order, _: str) -> Product:
    """Compile the parts of a system, and pack them with their connections."""
    platforms = read_platforms(order.platforms)
    more = [read_part(text, order.file) for text in order.parts]
    wires = [read_wire(text) for text in order.wires]
    system = prepare_system([first_part(order.file, order.options), *more], wires, order.inputs)
    warnings = [each for part in system.parts for each in part.model.built.warnings]
    return Product({f"{system.name}.ssp": system_archive(system, platforms)}, warnings)
