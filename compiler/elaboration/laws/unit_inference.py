"""Infer units of bonds from ports, sources and the arguments of elements.

A plain number says nothing: no effort, flow or quotient of them is one, and `sin(3*time)` is plain
in a program without any units too.
"""

from __future__ import annotations

from collections.abc import Collection

from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.bonds.bond_units import SECOND, BondUnits, Link, Ratio
from bgc.elaboration.bonds.domains import Domains
from bgc.elaboration.bonds.scalarise import Scalars
from bgc.elaboration.bonds.shape_probe import WidthUnknown
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.tree import Element
from bgc.elaboration.instances.world import World
from bgc.elaboration.laws.law_blocks import value_argument
from bgc.language.elements import Family
from bgc.values.units import DIMENSIONLESS, Dimension, divide, power
from bgc.values.value import Value

_COUPLING = frozenset({Family.TWO_PORT, Family.STORAGE, Family.RESISTOR})


def infer_units(world: World, wiring: Wiring, domains: Domains, scalars: Scalars) -> BondUnits:
    """Infer the units of all bonds as far as they are determined; report contradictions."""
    units = BondUnits([bond.name for bond in scalars.bonds], world.report)
    for element in wiring.elements:
        if element.row.family is Family.JUNCTION:
            for ports in scalars.ports(element.faces["all"]):
                units.join(port.bond for port in ports)
    _from_domains(wiring, domains, scalars, units)
    ratios: list[Ratio] = []
    links: list[Link] = []
    for element in wiring.elements:
        argument = value_argument(element)
        if argument is None:
            continue
        name, given = argument
        try:
            value = world.evaluate(given.value, element.env)
        except (BgError, WidthUnknown):
            continue  # reported when the law is read
        if any(unit is not None for unit in value.units):
            _from_argument(element, name, value, scalars, units, ratios, links)
    units.solve(ratios, links)
    return units


def _from_domains(wiring: Wiring, domains: Domains, scalars: Scalars, units: BondUnits) -> None:
    found = []
    for port in wiring.ports:
        use = port.outer.net.root().domain
        if use is not None and port.declaration.domain is not None:
            facts = domains.facts(use.declared)
            for joint in port.inner.joints:
                for place, bond in zip(joint.at, scalars.at(joint), strict=True):
                    found.append((facts, place, bond, port.declaration.span))
                    if facts.pseudo:
                        units.mark_pseudo(bond)
    if any(facts.pseudo for facts, *_ in found):
        _spread_pseudo(wiring, scalars, units, {bond for _, _, bond, _ in found})
    for facts, place, bond, span in found:
        effort, flow = facts.effort_units[place], facts.flow_units[place]
        if effort is not None:
            units.set_unit("effort", bond, effort, span)
        if flow is not None:
            units.set_unit("flow", bond, flow, span)


def _spread_pseudo(
    wiring: Wiring, scalars: Scalars, units: BondUnits, in_domains: Collection[int]
) -> None:
    """Mark bonds without a domain that an element joins to pseudo bonds.

    Transformers, gyrators and fields keep, store or take effort times flow of all their bonds
    together: where that is no power on one bond, it is none on the others.
    """
    joined = [
        [
            port.bond
            for face in element.faces.values()
            for ports in scalars.ports(face)
            for port in ports
        ]
        for element in wiring.elements
        if element.row.family in _COUPLING
    ]
    known = {units.common(bond) for bond in in_domains}
    changed = True
    while changed:
        changed = False
        for bonds in joined:
            if all(map(units.is_power, bonds)):
                continue
            for bond in bonds:
                if units.is_power(bond) and units.common(bond) not in known:
                    units.mark_pseudo(bond)
                    changed = True


def _from_argument(
    element: Element,
    name: str,
    value: Value,
    scalars: Scalars,
    units: BondUnits,
    ratios: list[Ratio],
    links: list[Link],
) -> None:
    span = element.use.span
    side = "all" if "all" in element.faces else "in"
    ports = scalars.ports(element.faces[side])
    diagonal = [None if unit == DIMENSIONLESS else unit for unit in _diagonal(value, len(ports))]
    if element.row.family is Family.SOURCE:
        variable = "effort" if element.basic == "Se" else "flow"
        for found, unit in zip(ports, diagonal, strict=True):
            if unit is not None:
                units.set_unit(variable, found[0].bond, unit, span)
        return
    if element.row.family is Family.TWO_PORT:
        _from_ratio(element, value, scalars, links)
        return
    (sense, time), *_ = (each.unit for each in element.row.arguments if each.name == name)
    for found, unit in zip(ports, diagonal, strict=True):
        if unit is None:
            continue
        by_flow = power(divide(unit, power(SECOND, time)), sense)
        ratios.append(Ratio(found[0].bond, by_flow, span, name, sense, time))


def _from_ratio(element: Element, value: Value, scalars: Scalars, links: list[Link]) -> None:
    """Link the units of a TF by `f2 = m f1`, `e1 = m e2`, of a GY by `e2 = r f1`, `e1 = r f2`."""
    into = scalars.ports(element.faces["in"])
    out = scalars.ports(element.faces["out"])
    span = element.use.span
    first, second = ("flow", "effort") if element.basic == "TF" else ("effort", "effort")
    for i, two in enumerate(out):
        for j, one in enumerate(into):
            if len(value.shape) == 2:
                unit = (
                    value.units[i * len(into) + j] if len(value.units) > i * len(into) + j else None
                )
            else:
                unit = value.units[0 if value.is_scalar else i] if i == j else None
            if unit is None:
                continue
            source = ("flow", one[0].bond)
            links.append(Link((first, two[0].bond), source, unit, span))
            other = (second, two[0].bond) if element.basic == "TF" else ("flow", two[0].bond)
            links.append(Link(("effort", one[0].bond), other, unit, span))


def _diagonal(value: Value, width: int) -> list[Dimension | None]:
    """The unit of each component: that of a scalar repeated, or those on a matrix diagonal."""
    if value.is_scalar:
        return [value.units[0]] * width
    if len(value.shape) == 1:
        return list(value.units) if len(value.units) == width else [None] * width
    if value.shape != (width, width):
        return [None] * width
    return [value.units[k * width + k] for k in range(width)]
