"""What a scene is driven by: parameters by their role in the bond graph, steps, tolerances.

Nothing here knows what a model is about: a parameter is a stiffness because a C has it, whatever
its domain.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from bgc.algebra.dag import Kind
from bgc.grammar.catalogue.stress import not_a_drive
from bgc.grammar.diagnostics import BgError
from bgc.graph import (
    Element,
    EnergyLaw,
    ExplicitLaw,
    FlatGraph,
    Form,
    Gyrator,
    Gyristor,
    Junction,
    Law,
    Node,
    Resistor,
    Source,
    Storage,
    Transformer,
)
from bgc.runtime.parameters import Parameter
from bgc.runtime.quantity import read_quantity

STEP, RTOL, TIME = "step", "rtol", "time"
_UNITS = {STEP: "s", RTOL: "", TIME: "s"}

_EXTREMES = (5e-324, 1e-300, 1e300, 1.7976931348623157e308)
# s, multiples or parts of the usual periods of devices, which are then sampled alike
_STEPS = (1e-6, 1e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1)
_DECADES = 3.0  # from which on a range is taken by decades
_EVEN = 9  # values of a narrower one
_MOST = 16


class Role(Enum):
    """What a parameter is to the element that holds it, in the order in which one counts."""

    ANGLE = "angle"
    STIFFNESS = "stiffness"
    COMPLIANCE = "compliance"
    INERTIA = "inertia"
    RESISTANCE = "resistance"
    SOURCE = "source"
    MODULUS = "modulus"
    OTHER = "value"


@dataclass(frozen=True, slots=True)
class Drive:
    """A parameter (or `step`, `rtol`, `time`), what it is, and the SI values it takes."""

    name: str
    unit: str
    role: str
    values: tuple[float, ...]


def all_drives(
    graph: FlatGraph, known: Iterable[Parameter], fixed: bool, duration: float
) -> tuple[Drive, ...]:
    """The step or tolerance, the parameters by their roles, and the duration.

    One of each kind comes before the next, so that little time shows much: four stiffnesses of
    four joints are one kind.
    """
    control = (
        Drive(STEP, "s", "step", _STEPS)
        if fixed
        else Drive(RTOL, "", "tolerance", tuple(np.logspace(-1, -10, 10).tolist()))
    )
    ranked = _parameter_drives(graph, known)
    firsts = [drive for rank, drive in ranked if rank == 0]
    others = [drive for rank, drive in ranked if rank > 0]
    longer = tuple(10.0**k for k in range(-2, 5) if 10.0**k > 2 * duration)
    lengths = [Drive(TIME, "s", "duration", longer)] if longer else []
    return (control, *firsts, *lengths, *others)


def _parameter_drives(graph: FlatGraph, known: Iterable[Parameter]) -> list[tuple[int, Drive]]:
    """A drive for each run-time parameter within its range, with its number among its kind.

    A kind is a role and a unit.
    """
    roles = _roles(graph)
    seen: Counter[tuple[Role, str]] = Counter()
    ranked: list[tuple[int, Drive]] = []
    for parameter in known:
        role = Role.ANGLE if parameter.unit == "rad" else roles.get(parameter.name, Role.OTHER)
        values = _within(_ladder(role, parameter), parameter)
        if values:
            drive = Drive(parameter.name, parameter.unit, role.value, values)
            ranked.append((seen[role, parameter.unit], drive))
            seen[role, parameter.unit] += 1
    return sorted(ranked, key=lambda pair: pair[0])


# --- values -----------------------------------------------------------------------------------


def _ladder(role: Role, parameter: Parameter) -> tuple[float, ...]:
    size = abs(parameter.value) or 1.0
    match role:
        case Role.ANGLE:
            right = (k * math.pi / 4 for k in range(-4, 5))
            return (*right, math.pi / 2 - 1e-6, math.pi / 2 + 1e-6, 1e3, 1e300)
        case Role.STIFFNESS if parameter.unit == "N/m":
            values = tuple(10.0**k for k in range(3, 15))
        case Role.STIFFNESS:
            values = tuple(size * 10.0**k for k in range(-6, 6))
        case Role.COMPLIANCE:
            values = tuple(size * 10.0**k for k in range(-5, 7))
        case Role.INERTIA:
            values = tuple(size * 10.0**k for k in range(-6, 7))
        case Role.RESISTANCE:
            values = (0.0, *(size * 10.0**k for k in range(-3, 4)))
        case Role.SOURCE:
            forces = tuple(size * 10.0**k for k in (1, 2, 3, 6, 12, 100, 200))
            return (*(-x for x in (1e300, size)), 0.0, *forces, *_EXTREMES)
        case Role.MODULUS | Role.OTHER:
            values = (-size, 0.0, *(size * 10.0**k for k in range(-3, 4)))
    return (*values, *_EXTREMES)


def _within(values: Iterable[float], parameter: Parameter) -> tuple[float, ...]:
    """Those in the declared range, its ends among them, by size."""
    ends = (end for end in (parameter.low, parameter.high) if math.isfinite(end))
    allowed = {x for x in values if parameter.low <= x <= parameter.high}
    return tuple(sorted({*allowed, *ends}))


# --- roles ------------------------------------------------------------------------------------


def _roles(graph: FlatGraph) -> Mapping[str, Role]:
    order = list(Role)
    found: dict[str, Role] = {}
    names = {p.index: p.name for p in graph.parameters}
    dag = graph.dag
    for element in graph.elements:
        for role, nodes in _nodes_of(element):
            for symbol in map(dag.symbol_of, dag.reachable(nodes)):
                if symbol is None or symbol.kind is not Kind.PARAM:
                    continue
                name = names[symbol.index]
                found[name] = min(found.get(name, Role.OTHER), role, key=order.index)
    return found


def _nodes_of(element: Element) -> Iterator[tuple[Role, Sequence[Node]]]:
    match element:
        case Storage():
            role = _storage_role(element)
            yield role, law_nodes(element.law)
        case Resistor():
            yield Role.RESISTANCE, law_nodes(element.law)
        case Source():
            yield Role.SOURCE, (element.value,)
        case Transformer() | Gyrator() | Gyristor():
            yield Role.MODULUS, [node for row in element.matrix for node in row]
        case Junction():
            return


def _storage_role(element: Storage) -> Role:
    if element.kind != "C":
        return Role.INERTIA
    by_charge = getattr(element.law, "form", Form.EFFORT) is Form.EFFORT
    return Role.STIFFNESS if by_charge else Role.COMPLIANCE


def law_nodes(law: Law) -> tuple[Node, ...]:
    """The nodes that a law is made of."""
    match law:
        case EnergyLaw():
            return (law.energy,)
        case ExplicitLaw():
            return law.nodes
        case _:
            return tuple(node for row in law.matrix for node in row)


# --- asked for --------------------------------------------------------------------------------


def read_drive(text: str, units: Mapping[str, str]) -> Drive:
    """Read `NAME=LO..HI`, `NAME=LO..HI:COUNT` or `NAME=A,B,C`; BG087 where it is none of these.

    `units` are those of the parameters. Values may have units of their own. A range of three
    decades and more is taken by decades, and from zero by decades below its upper end.
    """
    name, equals, given = (part.strip() for part in text.partition("="))
    if not (name and equals and given):
        raise BgError([not_a_drive(text)])
    unit = _UNITS.get(name, units.get(name, ""))
    if ".." not in given:
        values = [read_quantity(part.strip(), name, unit) for part in given.split(",")]
        return Drive(name, unit, "", tuple(values))
    low_text, _, rest = given.partition("..")
    high_text, _, count_text = rest.partition(":")
    low, high = (read_quantity(part.strip(), name, unit) for part in (low_text, high_text))
    count = int(count_text) if count_text.strip().isdecimal() else None
    if not low < high or (count_text and (count is None or count < 2)):
        raise BgError([not_a_drive(text)])
    return Drive(name, unit, "", _spread(low, high, count))


def _spread(low: float, high: float, count: int | None) -> tuple[float, ...]:
    if low == 0 and count is None:
        return (0.0, *(high * 10.0**-k for k in range(6, -1, -1)))
    decades = math.log10(high) - math.log10(low) if low > 0 else 0.0
    if decades >= _DECADES:
        number = count or min(round(decades) + 1, _MOST)
        exponents = np.linspace(math.log10(low), math.log10(high), number)
        return tuple(float(f"{10.0**x:.12g}") for x in exponents)
    return tuple(np.linspace(low, high, count or _EVEN).tolist())
