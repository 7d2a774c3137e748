"""Causal strokes from the result of the elimination, each with its reason.

Sequential assignment (SCAP) places strokes one by one. Here the independent flows are known
already, and the through variable of every class of bonds is given at exactly one end: by the
element that determines an independent flow, or by the junction or transformer from which a
dependent one follows.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from bgc.algebra.matching import match
from bgc.causality.regions import sums_through
from bgc.ir.causal import (
    Basis,
    BasisKind,
    BondClass,
    ElementPort,
    Role,
    Row,
    Rule,
    Step,
    Stroke,
)
from bgc.ir.graph import (
    FlatGraph,
    Gyristor,
    Junction,
    Resistor,
    Source,
    Storage,
    Transformer,
    port_ends,
)

_Ends = dict[int, dict[int, tuple[int, int]]]


def place_strokes(
    graph: FlatGraph,
    dual: Sequence[bool],
    ports: Sequence[ElementPort],
    classes: Sequence[BondClass],
    class_of: Sequence[int],
    rows: Sequence[Row],
    steps: Sequence[Step],
    basis: Sequence[Basis],
    cut: Collection[int],
) -> tuple[Stroke, ...]:
    """Place the stroke of every bond. The arguments are the parts of a `CausalGraph`."""
    givers = _givers(ports, classes, class_of, rows, steps, basis)
    at = {(bond, sign): index for bond, sign, index in port_ends(graph)}
    giving: dict[int, int] = {}  # bond -> sign of the end that gives the through variable
    for number, members in enumerate(classes):
        bond, sign = givers.get(number, (members.bonds[0], -1))
        _spread(graph, dual, at, cut, bond, sign, giving)
        for bond in members.bonds:  # in an undetermined loop any stroke is right
            if bond not in giving:
                _spread(graph, dual, at, cut, bond, -1, giving)
    by_port = {(p.bond, p.sign): p for p in ports}
    return tuple(
        _stroke(graph, dual, at, by_port, bond, giving[bond]) for bond in range(len(graph.bonds))
    )


def _givers(
    ports: Sequence[ElementPort],
    classes: Sequence[BondClass],
    class_of: Sequence[int],
    rows: Sequence[Row],
    steps: Sequence[Step],
    basis: Sequence[Basis],
) -> dict[int, tuple[int, int]]:
    """Class -> the end (bond, sign) where its through variable is given."""
    givers: dict[int, tuple[int, int]] = {}
    wanted = {
        BasisKind.FLOW_SOURCE: Role.FLOW_SOURCE,
        BasisKind.INERTIA: Role.INERTIA,
        BasisKind.RESISTANCE: Role.RESISTANCE,
        BasisKind.COMPLIANCE: Role.COMPLIANCE,
    }
    for independent in basis:
        for k in classes[independent.bond_class].ports:
            if ports[k].role is wanted.get(independent.kind):
                givers.setdefault(independent.bond_class, (ports[k].bond, ports[k].sign))
    ends: dict[int, dict[int, tuple[int, int]]] = {}  # row -> class -> its end there
    for step in steps:
        for end in rows[step.row].ends:
            ends.setdefault(step.row, {}).setdefault(class_of[end.bond], (end.bond, end.sign))
    for row, number in _matching(steps, ends).items():
        givers[number] = ends[row][number]
    for number, members in enumerate(classes):
        if number not in givers:
            for _row, at in ends.items():
                if number in at and members.bonds:
                    givers[number] = at[number]
                    break
    return givers


def _matching(steps: Sequence[Step], ends: _Ends) -> dict[int, int]:
    """Match each row with the dependent class that it gives, as in the elimination if possible.

    The elimination may have solved a row for a class that entered it by an earlier substitution;
    the matching differs then.
    """
    dependents = {step.dependent for step in steps}
    rows = [step.row for step in steps]
    candidates = [[n for n in ends.get(row, {}) if n in dependents] for row in rows]
    preferred = {
        k: step.dependent for k, step in enumerate(steps) if step.dependent in candidates[k]
    }
    return {rows[k]: number for k, number in match(candidates, preferred).items()}


def _spread(
    graph: FlatGraph,
    dual: Sequence[bool],
    at: dict[tuple[int, int], int],
    cut: Collection[int],
    bond: int,
    sign: int,
    giving: dict[int, int],
) -> None:
    """Propagate the through variable from the end where it is given to all bonds of the class."""
    giving[bond] = sign
    queue = [bond]
    while queue:
        known = queue.pop()
        index = at[known, -giving[known]]
        element = graph.elements[index]
        if isinstance(element, Junction) and not sums_through(element, dual) and index not in cut:
            for port in element.ports:
                if port.bond not in giving:
                    giving[port.bond] = port.sign
                    queue.append(port.bond)


def _stroke(
    graph: FlatGraph,
    dual: Sequence[bool],
    at: dict[tuple[int, int], int],
    by_port: dict[tuple[int, int], ElementPort],
    bond: int,
    giving: int,
) -> Stroke:
    """Place the stroke at the end that gives the flow: the through variable, unless dual."""
    at_head = (giving > 0) != dual[bond]
    flow, effort = ("effort", "flow") if dual[bond] else ("flow", "effort")
    for kinds in (Source, Storage, (Resistor, Gyristor)):
        for sign in (1, -1):
            element = graph.elements[at[bond, sign]]
            if isinstance(element, kinds):
                role = by_port[bond, sign].role
                rule, reason = element_reason(element.name, role, giving == sign, flow, effort)
                return Stroke(at_head, rule, reason)
    element = graph.elements[at[bond, giving]]
    match element:
        case Junction() if sums_through(element, dual):
            reason = f"the other bonds of `{element.name}` determine this {flow}"
        case Junction():
            reason = f"`{element.name}` has one {flow}, which another bond brings"
        case Transformer():
            reason = f"`{element.name}` gives the {flow} of this side from the other"
        case _:
            reason = f"`{element.name}` gives the {flow}"
    return Stroke(at_head, Rule.IMPLIED, reason)


def element_reason(
    name: str, role: Role, gives_through: bool, flow: str, effort: str
) -> tuple[Rule, str]:
    """The rule and the reason of a stroke at an element.

    It gives the through variable, called `flow`, or receives it; `effort` is the across variable.
    """
    match role:
        case Role.FLOW_SOURCE:
            return Rule.FIXED, f"`{name}` sets the {flow}"
        case Role.EFFORT_SOURCE:
            return Rule.FIXED, f"`{name}` sets the {effort}"
        case Role.INERTIA if gives_through:
            return Rule.PREFERRED, f"`{name}` integrates the {effort}"
        case Role.COMPLIANCE if not gives_through:
            return Rule.PREFERRED, f"`{name}` integrates the {flow}"
        case Role.INERTIA | Role.COMPLIANCE:
            return Rule.DERIVATIVE, f"what `{name}` stores follows from other elements"
        case Role.RESISTANCE:
            given = effort if gives_through else flow
            return Rule.INDIFFERENT, f"`{name}` takes the {given} it is given"
