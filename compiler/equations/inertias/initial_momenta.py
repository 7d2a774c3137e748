"""Initial momenta of inertias that start together: given values hold, the rest has least energy.

Inertias start together where they are merged, and where the flow of a junction is given that
depends on several of them, such as the rate of a joint. Among all momenta that satisfy the given
values, those with the least stored energy are chosen. Without given values all momenta are zero.
Zeros that are only the defaults of parts give way: first those of elements, then those of
junctions. The joints of a crane on a moving vessel therefore start at rest, and its beams move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from bgc.algebra.disjoint_sets import DisjointSets
from bgc.algebra.symbolic_systems import solve_definite
from bgc.equations.inertias.flows import momenta_of
from bgc.equations.inertias.groups import inertias_of
from bgc.equations.storage.conditions import (
    Condition,
    Row,
    independent_conditions,
    solve_conditions,
    unusable,
)
from bgc.equations.storage.initial_values import given_values
from bgc.equations.storage.kinds import (
    IntegratedState,
    StorageElement,
    columns_of,
    is_independent,
)
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import BasisKind, Role
from bgc.ir.graph import Initial, Junction, Node


@dataclass(frozen=True, slots=True)
class _Given:
    """A junction whose through variable is given: its row over the independent flows."""

    index: int  # of the element
    junction: Junction
    initial: Initial
    row: Mapping[int, Node]


@dataclass(frozen=True, slots=True)
class _Together:
    """Inertias that start together: their elements, independent flows, and given junctions."""

    elements: tuple[StorageElement, ...]
    flows: tuple[int, ...]
    junctions: tuple[_Given, ...]
    closing: tuple[Row, ...]  # over the independent flows: each sums up to zero


def start_inertias(
    variables: Variables, elements: Sequence[StorageElement], states: Sequence[IntegratedState]
) -> list[IntegratedState]:
    """Set the initial values of merged momenta, and of inertias on which a junction depends.

    Where a pivot may vanish, as those of rotations do, they are in terms of START symbols, which
    the runtime solves for. Elements with a law that is not linear are noted in
    `Variables.starting`; so are junctions that depend on anything but inertias and sources.
    """
    inertial = [element for element in elements if inertias_of(element)]
    columns = columns_of(elements, Role.INERTIA)
    start: dict[Node, Node] = {}
    for block in _find_blocks(variables, inertial):
        alone = [e for e in block.elements if is_independent(variables.causal, e, columns)]
        is_held = bool(block.junctions) or (bool(block.closing) and _has_given_values(block))
        if not is_held and len(alone) == len(block.elements):
            continue
        momenta = _initial_momenta(variables, block)
        if momenta is None:
            variables.starting.update(e.ports[0].port.element for e in block.elements)
            variables.starting.update(given.index for given in block.junctions)
            continue
        for state in states:
            if state.flow in momenta:
                start[state.symbol] = momenta[state.flow]
        for element in alone:
            for port in inertias_of(element):
                ((k, entry),) = port.flow.items()
                start[port.state] = variables.dag.mul(entry, momenta[k])
    return [replace(s, initial=start.get(s.symbol, s.initial)) for s in states]


def _find_blocks(variables: Variables, inertial: Sequence[StorageElement]) -> list[_Together]:
    """Inertias with their junctions, in blocks that share no independent flow."""
    basis = variables.causal.basis
    flows = [
        sorted({k for p in inertias_of(e) for k in p.flow if basis[k].kind is BasisKind.INERTIA})
        for e in inertial
    ]
    given = _given_junctions(variables, {k for found in flows for k in found})
    closing = _closing_rows(variables, {k for found in flows for k in found})
    sets = DisjointSets(len(inertial) + len(basis))
    for index, found in enumerate(flows):
        sets.join([index, *(len(inertial) + k for k in found)])
    for row in (*(one.row for one in given), *closing):
        own = (k for k in row if basis[k].kind is BasisKind.INERTIA)
        sets.join([len(inertial) + k for k in own])
    return [
        _Together(
            tuple(inertial[i] for i in indices),
            tuple(sorted({k for i in indices for k in flows[i]})),
            tuple(g for g in given if not {k for i in indices for k in flows[i]}.isdisjoint(g.row)),
            tuple(c for c in closing if not {k for i in indices for k in flows[i]}.isdisjoint(c)),
        )
        for indices in sets.groups(range(len(inertial)))
    ]


def _has_given_values(block: _Together) -> bool:
    """Return whether an element of the block has a given value, not a default."""
    initials = (i for element in block.elements for i in element.storage.initial)
    return any(not initial.is_default for initial in initials)


def _closing_rows(variables: Variables, moved: set[int]) -> list[Row]:
    """The rows over the independent flows that close chains by their rates alone.

    Where positions close a chain too, the runtime closes the start: its rows are not known before.
    """
    causal, dag = variables.causal, variables.dag
    if causal.graph.conditions:
        return []
    found = []
    for closure in causal.closures:
        total: Row = {}
        for end in causal.rows[closure.row].ends:
            for k, entry in dict(causal.flows[causal.class_of[end.bond]]).items():
                term = dag.mul(end.coefficient, entry)
                total[k] = dag.add(total.get(k, dag.zero), term)
        free = {k for k in total if causal.basis[k].kind is not BasisKind.FLOW_SOURCE}
        if free and moved.issuperset(free):
            found.append(total)
    return found


def _given_junctions(variables: Variables, moved: set[int]) -> list[_Given]:
    """The given junctions whose flow inertias and sources determine.

    The others are noted, but for zeros that are the defaults of parts: these give way to storage
    that starts empty.
    """
    causal = variables.causal
    found = []
    for index, element in enumerate(causal.graph.elements):
        if not isinstance(element, Junction) or element.initial is None or not element.ports:
            continue
        bond = element.ports[0].bond
        row = dict(causal.flows[causal.class_of[bond]])
        free = [k for k in row if causal.basis[k].kind is not BasisKind.FLOW_SOURCE]
        if (element.kind == "J1") != causal.dual[bond] and free and moved.issuperset(free):
            found.append(_Given(index, element, element.initial, row))
            variables.given_junctions.add(index)
        elif not element.initial.is_default:
            variables.starting.add(index)
    return found


def _initial_momenta(variables: Variables, block: _Together) -> dict[int, Node] | None:
    """The initial merged momenta on the independent flows of a block.

    Conditions are on the flows u: `N_k u = f0`, `M_k N u = p0`. Least energy means
    `pi = G' l` for the conditions `G u = g`. None where a law is not linear, or where the
    conditions cannot be evaluated before the start is known.
    """
    dag, elements, flows = variables.dag, block.elements, block.flows
    if any(element.law.capacity is None for element in elements):
        return None
    order = {k: i for i, k in enumerate(flows)}
    own = [c for element in elements for c in _conditions_on_flows(variables, element, order)]
    joints = [_condition_on_junction(variables, given, order) for given in block.junctions]
    default = [c for c in own if c.is_default]
    conditions = [*(c for c in own if not c.is_default), *joints, *default]
    closing = independent_conditions(
        variables, [_condition_of_closing(variables, row, order) for row in block.closing]
    )
    if closing is None:
        return None
    known = [(condition.row, condition.value) for condition in closing]
    chosen = independent_conditions(variables, conditions, known)
    if chosen is None:
        return None
    chosen = [*closing, *chosen]
    if not chosen:
        return dict.fromkeys(flows, dag.zero)
    if all(condition.value == dag.zero for condition in chosen) and len(chosen) == len(flows):
        return momenta_of(variables, elements, dict.fromkeys(flows, dag.zero))
    found = _in_closed_form(variables, block, order, chosen)
    return _by_equations(variables, block, chosen) if found is None else found


def _in_closed_form(
    variables: Variables, block: _Together, order: Mapping[int, int], chosen: Sequence[Condition]
) -> dict[int, Node] | None:
    """The momenta by elimination; None where a pivot may vanish."""
    dag, elements = variables.dag, block.elements
    if len(chosen) == len(order):
        right = solve_conditions(variables, [c.row for c in chosen], [c.value for c in chosen])
        if right is None:
            return None
        return momenta_of(variables, elements, {k: right[i] for k, i in order.items()})
    mass, driven = reduced_mass(variables, elements, order)
    columns = [[c.row.get(i, dag.zero) for i in range(len(order))] for c in chosen]
    *answers, response = solve_definite(
        dag, variables.causal.fingerprints, mass, [*columns, driven]
    )
    matrix = [
        {j: dag.dot(column, answer) for j, answer in enumerate(answers)} for column in columns
    ]
    values = [
        dag.add(c.value, dag.dot(column, response))
        for c, column in zip(chosen, columns, strict=True)
    ]
    weights = solve_conditions(variables, matrix, values)
    if weights is None:
        return None
    return {k: dag.dot(weights, (column[i] for column in columns)) for k, i in order.items()}


def _by_equations(
    variables: Variables, block: _Together, chosen: Sequence[Condition]
) -> dict[int, Node]:
    """The momenta in terms of unknowns of the start: the flows u, and multipliers l.

    Their equations are `G u = g` and, where these leave flows open, `pi(u) = G' l`.
    """
    dag, flows = variables.dag, block.flows
    more = len(chosen) if len(chosen) < len(flows) else 0
    unknowns = variables.new_start_unknowns(len(flows) + more)
    u, multipliers = unknowns[: len(flows)], unknowns[len(flows) :]
    momenta = momenta_of(variables, block.elements, dict(zip(flows, u, strict=True)))
    for condition in chosen:
        total = dag.sum(dag.mul(entry, u[i]) for i, entry in condition.row.items())
        variables.start_rows.append(dag.sub(total, condition.value))
    for i, k in enumerate(flows if more else ()):
        pairs = zip(chosen, multipliers, strict=True)
        force = dag.sum(dag.mul(c.row[i], x) for c, x in pairs if i in c.row)
        variables.start_rows.append(dag.sub(momenta[k], force))
    variables.start_names.extend(dict.fromkeys(condition.name for condition in chosen))
    return momenta


def _condition_on_junction(
    variables: Variables, given: _Given, order: Mapping[int, int]
) -> Condition:
    row, known = _over(variables, given.row, order)
    value = variables.dag.sub(given.initial.value, known)
    return Condition(row, value, given.junction.name, given.initial)


def _condition_of_closing(
    variables: Variables, closing: Row, order: Mapping[int, int]
) -> Condition:
    row, known = _over(variables, closing, order)
    return Condition(row, variables.dag.neg(known), "", None)


def _over(
    variables: Variables, row: Mapping[int, Node], order: Mapping[int, int]
) -> tuple[Row, Node]:
    """The row over the flows of a block, and the part that sources contribute."""
    dag = variables.dag
    known = (dag.mul(entry, variables.independent(k)) for k, entry in row.items() if k not in order)
    return {order[k]: entry for k, entry in row.items() if k in order}, dag.sum(known)


def _conditions_on_flows(
    variables: Variables, element: StorageElement, order: Mapping[int, int]
) -> list[Condition]:
    dag = variables.dag
    found = []
    for (position, variable), initial in given_values(element).items():
        port = element.ports[position]
        if (port.port.role is Role.COMPLIANCE and variable in "qp") or (
            port.charge is not None and variable == "q"
        ):
            continue  # an IC's own state beside its merged momenta
        if variable == ("f" if port.has_momentum else "e"):
            weights = {position: dag.one}
        elif variable == ("p" if port.has_momentum else "q") and element.law.capacity is not None:
            weights = dict(enumerate(element.law.capacity[position]))
        else:
            raise unusable(Condition({}, dag.zero, element.storage.name, initial))
        row: Row = {}
        value = initial.value
        for other, weight in weights.items():
            for k, entry in element.ports[other].flow.items():
                term = dag.mul(weight, entry)
                if k in order:
                    row[order[k]] = dag.add(row.get(order[k], dag.zero), term)
                else:
                    value = dag.sub(value, dag.mul(term, variables.independent(k)))
        found.append(Condition(row, value, element.storage.name, initial))
    return found


def reduced_mass(
    variables: Variables, elements: Sequence[StorageElement], order: Mapping[int, int]
) -> tuple[list[Row], list[Node]]:
    """`N' M N`, and `N' M N_s s` of the sources that drive the elements."""
    dag = variables.dag
    mass: list[Row] = [{} for _ in order]
    driven = [dag.zero] * len(order)
    for element in elements:
        if element.law.capacity is None:
            continue
        for port, line in zip(element.ports, element.law.capacity, strict=True):
            for other, entry in zip(element.ports, line, strict=True):
                if entry == dag.zero:
                    continue
                for k, left in port.flow.items():
                    if k not in order:
                        continue
                    i = order[k]
                    for m, right in other.flow.items():
                        term = dag.mul(left, dag.mul(entry, right))
                        if m in order:
                            j = order[m]
                            mass[i][j] = dag.add(mass[i].get(j, dag.zero), term)
                        else:
                            source = variables.independent(m)
                            driven[i] = dag.add(driven[i], dag.mul(term, source))
    return mass, driven
