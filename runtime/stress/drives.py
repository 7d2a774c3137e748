"""Drives of a stress map: parameters by their role in the bond graph, steps, tolerances, times.

Roles do not depend on the domain: a parameter is a stiffness because the law of a C contains it.
Equal parameters of equal parts, as the stiffness of each joint, are driven together.
"""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from types import MappingProxyType

import numpy as np

from bgc.algebra.dag import Kind
from bgc.diagnostics.catalogue.stress import not_a_drive
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.elaboration.scenes.variants import Change, with_changes
from bgc.ir.fields import nodes_of
from bgc.ir.graph import (
    Element,
    FlatGraph,
    Form,
    Gyrator,
    Gyristor,
    Junction,
    Node,
    Resistor,
    Source,
    Storage,
    Transformer,
)
from bgc.record_class import dataclass, replace
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameter_grid import Listed, Range, read_axis
from bgc.runtime.running.parameters import Parameter
from bgc.values.shown_units import Shown

STEP, RTOL, TIME = "step", "rtol", "time"
_UNITS = {STEP: "s", RTOL: "", TIME: "s"}

_RANGE_OF_USE = 10.0  # times the scene's own value, or a part of it
_COARSE = 3  # every third value of a drive comes first
_BEYOND_USE = 1e100
_EXTREMES = (5e-324, 1e-300, 1e300, 1.7976931348623157e308)
# s; multiples and fractions of the usual periods of devices, which are then sampled equally
_STEPS = (1e-6, 1e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1)
_DECADES = 3.0  # from which on a range is spaced logarithmically
_EVEN = 9  # values of a narrower range
_MOST_RANGE_VALUES = 16  # values of a wider range


def is_extreme(value: float) -> bool:
    """Return whether numbers overflow or underflow at a value, so that no user needs it."""
    return value != 0 and not 1 / _BEYOND_USE < abs(value) < _BEYOND_USE


class Role(Enum):
    """The role of a parameter in the law of an element; of several, the first counts."""

    ANGLE = "angle"
    STIFFNESS = "stiffness"
    COMPLIANCE = "compliance"
    INERTIA = "inertia"
    RESISTANCE = "resistance"
    SOURCE = "source"
    MODULUS = "modulus"
    OTHER = "value"


_ROLES = tuple(Role)


@dataclass(frozen=True, slots=True)
class Drive:
    """A parameter (or `step`, `rtol`, `time`), its role, and the SI values that it takes.

    `members` are the parameters that are driven together, if `name` stands for several. `own` is
    the value of the scene, None if it is not known. `written` is the unit in which it is shown,
    None for its SI unit.
    """

    name: str
    unit: str
    role: str
    values: tuple[float, ...]
    members: tuple[str, ...] = ()
    own: float | None = None
    written: Shown | None = None

    @property
    def shown(self) -> Shown:
        """The unit in which its values are shown."""
        return self.written or Shown(self.unit)

    def urgency(self, value: float) -> int:
        """Rank a value: the scene's own, those around it, every third, others, extremes."""
        own = self.own
        if own is not None and value == own:
            return 0
        if (
            own is not None
            and value * own > 0
            and abs(value / own) <= _RANGE_OF_USE >= abs(own / value)
        ):
            return 1
        if is_extreme(value):
            return 4
        k = self.values.index(value)
        return 2 if k % _COARSE == 0 or k == len(self.values) - 1 else 3

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters to set; none for steps, tolerances and durations."""
        return self.members or (() if self.name in _UNITS else (self.name,))


def all_drives(graph: FlatGraph, known: Iterable[Parameter], duration: float) -> tuple[Drive, ...]:
    """List drives: the step, the tolerance and the duration, then parameters by their roles.

    One drive of each kind comes before the second of any, so that a small budget shows much.
    """
    longer = tuple(10.0**k for k in range(-2, 5) if 10.0**k > 2 * duration)
    return (
        Drive(STEP, "s", "step", _STEPS),
        Drive(RTOL, "", "tolerance", tuple(np.logspace(-1, -10, 10).tolist())),
        *([Drive(TIME, "s", "duration", longer)] if longer else ()),
        *_parameter_drives(graph, known),
    )


def _parameter_drives(graph: FlatGraph, known: Iterable[Parameter]) -> list[Drive]:
    """Make a drive for each run-time parameter within its range; equal ones are driven together.

    A kind is a role and a unit. One drive of each kind comes before the second of any, starting
    with the parameters that most parts have.
    """
    roles = _roles(graph)
    found: list[tuple[Role, Drive]] = []
    for name, group in _groups(known, roles):
        one = group[0]
        role = _role(one, roles)
        if values := _within(_ladder(role, one), one):
            members = tuple(parameter.name for parameter in group) if len(group) > 1 else ()
            drive = Drive(name, one.unit, role.value, values, members, one.value, one.shown)
            found.append((role, drive))
    found.sort(key=lambda pair: (-len(pair[1].members), not pair[1].unit))
    seen: Counter[tuple[Role, str]] = Counter()
    ranked: list[tuple[int, int, int, Drive]] = []
    for role, drive in found:
        units = [unit for other, unit in seen if other is role]
        before = units.index(drive.unit) if drive.unit in units else len(units)
        ranked.append((seen[role, drive.unit], before, _ROLES.index(role), drive))
        seen[role, drive.unit] += 1
    return [drive for *_, drive in sorted(ranked, key=lambda item: item[:3])]


def _role(parameter: Parameter, roles: Mapping[str, Role]) -> Role:
    return Role.ANGLE if parameter.unit == "rad" else roles.get(parameter.name, Role.OTHER)


def _groups(
    known: Iterable[Parameter], roles: Mapping[str, Role]
) -> Iterator[tuple[str, list[Parameter]]]:
    """Group parameters of parts of one name, as `*.part.name`, if all of them are equal."""
    tails: defaultdict[str, list[Parameter]] = defaultdict(list)
    for parameter in known:
        parts = parameter.name.split(".")
        tails[".".join(parts[-2:] if len(parts) > 2 else parts[-1:])].append(parameter)
    for tail, group in tails.items():
        kinds = {(p.unit, p.value, p.low, p.high, _role(p, roles)) for p in group}
        if len(group) > 1 and len(kinds) == 1:
            yield f"*.{tail}", group
        else:
            yield from ((p.name, [p]) for p in group)


# --- values -----------------------------------------------------------------------------------


def _ladder(role: Role, parameter: Parameter) -> tuple[float, ...]:
    """The scene's own value, a tenth and ten times of it, and the values of the role."""
    own = parameter.value
    return (own, own / _RANGE_OF_USE, own * _RANGE_OF_USE, *_of_role(role, parameter))


def _of_role(role: Role, parameter: Parameter) -> tuple[float, ...]:
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
    """Keep the values in the declared range, add its ends, and sort."""
    ends = (end for end in (parameter.low, parameter.high) if math.isfinite(end))
    allowed = {x for x in values if parameter.low <= x <= parameter.high}
    return tuple(sorted({*allowed, *ends}))


# --- roles ------------------------------------------------------------------------------------


def _roles(graph: FlatGraph) -> Mapping[str, Role]:
    """Find the role of each parameter in the laws of the elements."""
    found: dict[str, Role] = {}
    names = {p.index: p.name for p in graph.parameters}
    dag = graph.dag
    for element in graph.elements:
        for role, nodes in _nodes_of(element):
            for symbol in map(dag.symbol_of, dag.reachable(nodes)):
                if symbol is None or symbol.kind is not Kind.PARAM:
                    continue
                name = names[symbol.index]
                found[name] = min(found.get(name, Role.OTHER), role, key=_ROLES.index)
    return found


def _nodes_of(element: Element) -> Iterator[tuple[Role, Sequence[Node]]]:
    match element:
        case Storage():
            role = _storage_role(element)
            yield role, nodes_of(element.law)
        case Resistor():
            yield Role.RESISTANCE, nodes_of(element.law)
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


# --- requested ------------------------------------------------------------------------------


def requested_drives(model: LoadedModel, texts: Iterable[str]) -> tuple[Drive, ...]:
    """Read the requested drives of a model.

    Raises the errors of `read_drive`, and for a name that `set` cannot change those of the
    compiler (BG210, BG211, BG603): it has to be a parameter or a constant.
    """
    known = [model.parameters[name] for name in model.parameters]
    units = {p.name: p.unit for p in known}
    shown = {p.name: p.shown for p in known}
    found = tuple(read_drive(text, units, shown) for text in texts)
    for drive in found:
        if not units.keys() >= {*drive.parameters}:
            _check_target(model, drive.name, drive.values[0])
    return found


def _check_target(model: LoadedModel, name: str, value: float) -> None:
    """Elaborate the scene with a value that is compiled in; raise the errors about its name."""
    path, options = model.source_for("drives")
    change = Change(name, repr(value), is_use=False)
    try:
        compile_scene(path, with_changes(options, [change]), until="elaborate")
    except BgError as problem:
        about = [
            replace(found, span=None, edits=())
            for found in problem.diagnostics
            if (at := found.span) is not None
            and at.source.text == f"{change.name}={change.value}"
            and at.start < len(name)
        ]
        if about:
            raise BgError(about) from None


def read_drive(
    text: str, units: Mapping[str, str], shown: Mapping[str, Shown] = MappingProxyType({})
) -> Drive:
    """Read a range or a list of values as `bgc sweep` does (`read_axis`); BG087 for other forms.

    `units` are those of the parameters, `shown` those in which they are shown. A `*` in the name
    matches any text; all matching parameters are driven together. A range rises. Without `log` or
    a count, one of three decades or more is spaced by decades, and one from zero by decades below
    its upper end.
    """
    name = text.partition("=")[0].strip()
    members = _matching(name, units) if "*" in name else ()
    if "*" in name and not members:
        raise BgError([not_a_drive(text, f"no parameter has a name of the form `{name}`")])
    one = members[0] if members else name
    unit = _UNITS.get(name, units.get(one, ""))
    axis = read_axis(text, lambda _: unit, not_a_drive)
    if isinstance(axis, Listed):
        values = axis.numbers
    elif axis.low < axis.high and axis.count != 1:
        values = _spread(axis)
    else:
        raise BgError([not_a_drive(text, "a range rises, in 2 values or more")])
    return Drive(name, unit, "", values, members, written=shown.get(one))


def _matching(pattern: str, names: Iterable[str]) -> tuple[str, ...]:
    form = re.compile(".*".join(map(re.escape, pattern.split("*"))))
    return tuple(name for name in names if form.fullmatch(name))


def _spread(axis: Range) -> tuple[float, ...]:
    """Space the values of a range."""
    low, high, count = axis.low, axis.high, axis.count
    if low == 0 and not count:
        return (0.0, *(high * 10.0**-k for k in range(6, -1, -1)))
    decades = math.log10(high) - math.log10(low) if low > 0 else 0.0
    if axis.log or decades >= _DECADES:
        number = count or min(max(round(decades) + 1, 2), _MOST_RANGE_VALUES)
        exponents = np.linspace(math.log10(low), math.log10(high), number)
        return tuple(float(f"{10.0**x:.12g}") for x in exponents)
    return tuple(np.linspace(low, high, count or _EVEN).tolist())
