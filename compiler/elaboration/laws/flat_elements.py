"""Convert the elements of the tree to those of the flat graph, with their laws as nodes."""

from __future__ import annotations

from dataclasses import replace

from bgc.diagnostics.catalogue import graph
from bgc.diagnostics.catalogue import laws as law_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.bonds.bond_values import BondValues
from bgc.elaboration.bonds.scalarise import Scalars
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.components import component_name
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.tree import Element
from bgc.elaboration.instances.world import World
from bgc.elaboration.laws.law_blocks import Laws, arguments_of
from bgc.elaboration.laws.matrix_checks import LawChecks
from bgc.elaboration.laws.one_ports import (
    read_initials,
    read_resistor,
    read_sources,
    read_storage,
)
from bgc.elaboration.laws.two_ports import read_gyrators, read_gyristor, read_transformers
from bgc.ir.graph import Element as FlatElement
from bgc.ir.graph import Junction
from bgc.language.elements import Family


def read_elements(
    world: World, wiring: Wiring, values: BondValues, scalars: Scalars
) -> tuple[FlatElement, ...]:
    """Read all elements with their laws, in source order; invalid laws are reported."""
    laws, checks = Laws(world, values, scalars), LawChecks(world)
    found: list[FlatElement] = []
    for element in wiring.elements:
        with world.report.collecting(note(element.env)):
            found.extend(_read(laws, checks, element))
    return tuple(found)


def _read(laws: Laws, checks: LawChecks, element: Element) -> list[FlatElement]:
    """Convert one element of the tree; a Mux has no element in the flat graph."""
    match element.row.family:
        case Family.JUNCTION:
            return [*_read_junctions(laws, element)]
        case Family.SOURCE:
            return [*read_sources(laws, element)]
        case Family.STORAGE:
            return [read_storage(laws, element)]
        case Family.RESISTOR:
            return [read_resistor(laws, element)]
        case Family.TWO_PORT if element.basic == "TF":
            return [*read_transformers(laws, checks, element)]
        case Family.TWO_PORT if element.is_gyristor:
            return [read_gyristor(laws, checks, element)]
        case Family.TWO_PORT:
            return [*read_gyrators(laws, checks, element)]
        case Family.BUNDLE:
            _require_bare(element)
            return []


def _read_junctions(laws: Laws, element: Element) -> list[Junction]:
    """Split a wide junction into scalar ones."""
    given = arguments_of(element, element.row.initial_arguments)
    _require_no_law(element)
    found = laws.scalars.ports(element.faces["all"])
    for k, ports in enumerate(found, 1):
        if not ports:
            name = f"{element.path}[{k}]"
            raise BgError([graph.not_bonded(element.span, name, "the component")])
    starts = {initial.port: initial for initial in read_initials(laws, element, given)}
    return [
        Junction(
            component_name(element.path, (k + 1,) if len(found) > 1 else ()),
            element.basic,
            tuple(ports),
            element.span,
            replace(starts[k], port=0) if k in starts else None,
        )
        for k, ports in enumerate(found)
    ]


def _require_bare(element: Element) -> None:
    """Raise BgError if a Mux has an argument or a law."""
    arguments_of(element, ())
    _require_no_law(element)


def _require_no_law(element: Element) -> None:
    """Raise BgError if a junction or Mux has a law."""
    if element.law is not None:
        raise BgError([law_messages.law_of_junction(element.span, element.path, element.kind)])
